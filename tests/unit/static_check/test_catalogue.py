"""Which profile is that of a component."""

from __future__ import annotations

from typing import Any

import pytest

from rtkit.profile.forms import may_be_component
from rtkit.profile.read import read_rtc
from rtkit.report.finding import NOTE, WARNING
from rtkit.static_check.catalogue import Catalogue
from rtkit.static_check.stock import CandidateDocument, stocked
from rtkit.static_check.verdict import Options


@pytest.fixture
def motor(profile_of: Any) -> Any:
    """Make profiles like that of the motor, with other words in it."""

    def make(version: str = "1.0", rate: str = "100.0", id: str | None = None) -> Any:
        text = profile_of("Motor")
        text = text.replace("Motor:1.0", f"Motor:{version}")
        text = text.replace('rtc:version="1.0"', f'rtc:version="{version}"')
        text = text.replace('executionRate="100.0"', f'executionRate="{rate}"')
        if id is not None:
            text = text.replace(f'rtc:id="RTC:rtkit:example:Motor:{version}"', f'rtc:id="{id}"')
        return read_rtc(text.encode()).profile

    return make


def test_the_very_version_comes_first_else_the_newest(motor: Any) -> None:
    versions = ("1.9", "1.10", "1.2-beta", "0." + "9" * 5000)
    known = Catalogue((motor(version), version) for version in versions)
    for version in versions:
        match = known.find(f"RTC:rtkit:example:Motor:{version}")
        assert match is not None
        assert (match.blueprint.source, match.is_other_version, match.others) == (
            version,
            False,
            (),
        )
    other = known.find("RTC:rtkit:example:Motor:3")
    assert other is not None
    assert (other.blueprint.source, other.is_other_version) == ("1.10", True)
    assert known.find("RTC:rtkit.example.Motor:1.9") == known.find("RTC:rtkit:example:Motor:1.9")


def test_vendor_and_category_have_to_be_the_same(motor: Any) -> None:
    known = Catalogue([(motor(), "m")])
    for id in ("RTC:other:example:Motor:1.0", "RTC:rtkit:sample:Motor:1.0", "RTC:::Motor:", "x"):
        assert known.find(id) is None
    assert known.namesakes("RTC:other:example:Motor:1.0") == ["RTC:rtkit:example:Motor:1.0"]


@pytest.mark.parametrize(
    ("id", "found"),
    [
        ("$id", ["RTC:rtkit:example:Motor:1.0"]),
        ("", ["RTC:rtkit:example:Motor:1.0"]),
        ("RTC:AIST:arms:Motor:2", ["RTC:rtkit:example:Motor:1.0", "RTC:AIST:arms:Motor:2"]),
    ],
)
def test_basic_info_and_the_id_both_lead_to_a_profile(
    id: str, found: list[str], motor: Any
) -> None:
    known = Catalogue([(motor(id=id), "m")])
    assert [each for each in found if known.find(each) is None] == []
    assert known.find("RTC:$id:::") is None


def test_of_several_the_first_counts_and_others_are_told(motor: Any) -> None:
    known = Catalogue([(motor(), "a"), (motor(), "b"), (motor(rate="5.0"), "c")])
    match = known.find("RTC:rtkit:example:Motor:1.0")
    assert match is not None
    assert (match.blueprint.source, match.others) == ("a", ("c",))


def test_several_profiles_are_a_warning(check: Any, text_of: Any, profile_of: Any) -> None:
    other = profile_of("Motor").replace('executionRate="100.0"', 'executionRate="5.0"')
    (finding,) = check(text_of("sensor-controller-motor"), {"Other.xml": other}).findings
    assert (finding.severity, finding.rule) == (WARNING, "several-profiles")
    assert finding.text == (
        "Motor0 is checked against Motor.xml; its type is described otherwise in Other.xml"
    )


def test_what_is_no_profile_of_a_wanted_type_is_not_even_read(profile_of: Any) -> None:
    broken = profile_of("Motor").replace("</rtc:RtcProfile>", "")
    documents = [
        CandidateDocument("broken.xml", broken.encode()),
        CandidateDocument("x.xml", b"<a/>"),
    ]
    known, troubles = stocked(documents, {"Sensor"})
    assert known.find("RTC:rtkit:example:Motor:1.0") is None
    assert troubles == []
    _, troubles = stocked(documents, {"Motor"})
    (trouble,) = troubles
    assert (trouble.name, trouble.is_valid) == ("broken.xml", True)
    assert [f.rule for f in trouble.findings] == ["unreadable-profile"]
    assert "cannot be read: not well-formed" in trouble.findings[0].text
    _, (strict,) = stocked(documents, {"Motor"}, Options(strict=True))
    assert not strict.is_valid
    assert stocked(documents, {"Motor"}, Options(ignored=("unreadable-profile",)))[1] == []


def test_a_name_may_be_written_with_references(profile_of: Any) -> None:
    text = profile_of("Motor").replace('"Motor"', '"&#77;otor"').replace("RTC:rtkit:", "RTC:x:")
    text = text.replace("Motor.py", "M.py").replace("MotorInit", "M").replace("Motor:", "M:")
    assert "Motor" not in text
    known, _ = stocked([CandidateDocument("m", text.encode())], {"Motor"})
    assert known.find("RTC:rtkit:example:Motor:1.0") is not None
    known, _ = stocked(
        [CandidateDocument("m", text.replace("UTF-8", "UTF-16").encode("utf-16"))], {"Motor"}
    )
    assert known.find("RTC:rtkit:example:Motor:1.0") is not None


def test_a_profile_is_known_by_its_beginning() -> None:
    assert may_be_component(b"<rtc:RtcProfile")
    assert may_be_component("rtcProfile:".encode("utf-16"))
    assert not may_be_component(b"<rts:RtsProfile")


def test_versions_are_noted(check: Any, text_of: Any) -> None:
    text = text_of("console").replace("ConsoleIn:1.0", "ConsoleIn:2.0")
    (finding,) = check(text).findings
    assert (finding.severity, finding.rule) == (NOTE, "version")
