"""Forms of components: the same profile comes back, and findings stand at their fields."""

from __future__ import annotations

from pathlib import Path

import pytest
from corpus import corpus

from rtkit.errors import Malformed
from rtkit.fast_dataclass import replace
from rtkit.profile.read import read_file
from rtkit.profile.rtc_model import RtcProfile
from rtkit.profile_tools.new_component import ComponentHeading, data_port, new_component, parameter
from rtkit.web.builder.component_form import form_of, place_of, read_form
from rtkit.web.builder.form_checks import check_form

ROOT = Path(__file__).parents[3]
FILES = sorted(
    [
        *corpus("rtc/*"),
        *(ROOT / "profiles").glob("*.xml"),
        ROOT / "tests/unit/profile/samples/rtc.xml",
    ]
)


@pytest.fixture
def form():
    ports = [data_port("in:TimedLong", "DataInPort"), data_port("out:TimedLong", "DataOutPort")]
    items = [parameter("gain:double=1.0;0<=x<=10"), parameter("name:string=a")]
    heading = ComponentHeading("Gain", "2026-01-01T00:00:00Z", rate=10.0)
    return form_of(new_component(heading, ports, (), items, ("onExecute",)))


def told(form, folder="/nowhere", folders=("/nowhere",)):
    both = [*read_form(form).findings, *check_form(form, folder, folders)]
    return {(each.place, each.level) for each in both}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_profile_comes_back_as_it_was(file: Path) -> None:
    profile = read_file(str(file), kind="rtc").profile
    assert isinstance(profile, RtcProfile)
    if profile.basic_info is None:  # a fragment is no component
        with pytest.raises(Malformed, match="basicInfo"):
            read_form(form_of(profile))
        return
    found = read_form(form_of(profile)).profile
    assert found is not None
    assert replace(found, id=profile.id) == profile


def test_constraints_are_texts(form) -> None:
    gain, name = form["configurationSet"]["configuration"]
    assert gain["constraint"] == "0<=x<=10"
    assert "constraint" not in name
    gain["constraint"] = "0<=x<="
    assert told(form) == {("configurationSet.configuration.0.constraint", "error")}


def test_a_good_form_has_no_findings(form) -> None:
    assert told(form) == set()
    profile = read_form(form).profile
    assert profile is not None
    assert profile.id == "RTC:Me:Misc:Gain:1.0.0"


def test_names_are_checked_across_all_kinds_of_ports(form) -> None:
    form["servicePorts"] = [{"name": "out", "rtcExt::position": "LEFT"}]
    form["dataPorts"][0]["name"] = "a:b"
    form["dataPorts"].append({"portType": "DataInPort", "name": "", "type": ""})
    form["basicInfo"]["name"] = "速度"
    form["basicInfo"]["vendor"] = "a:b"
    assert told(form) >= {
        ("servicePorts.0.name", "error"),
        ("dataPorts.0.name", "error"),
        ("dataPorts.2.name", "error"),
        ("dataPorts.2.type", "error"),
        ("basicInfo.name", "warning"),
        ("basicInfo.vendor", "error"),
    }


def test_numbers_and_words_are_checked(form) -> None:
    form["basicInfo"] |= {"executionRate": "fast", "maxInstances": -1, "activityType": "NEVER"}
    gain, name = form["configurationSet"]["configuration"]
    gain["defaultValue"] = "11"
    name |= {"type": "int", "defaultValue": "x", "name": "gain"}
    assert told(form) == {
        ("basicInfo.executionRate", "error"),
        ("basicInfo.maxInstances", "error"),
        ("basicInfo.activityType", "error"),
        ("configurationSet.configuration.0.defaultValue", "error"),
        ("configurationSet.configuration.1.defaultValue", "warning"),
        ("configurationSet.configuration.1.name", "error"),
    }


def test_idl_files_outside_of_what_is_granted_are_not_read(form, tmp_path: Path) -> None:
    (tmp_path / "out.idl").write_text("")
    (tmp_path / "in").mkdir()
    (tmp_path / "in/good.idl").write_text("")
    granted = str(tmp_path / "in")
    port = form["dataPorts"][0]
    for name, is_bad in (
        ("good.idl", False), (f"{granted}/good.idl", False), ("C:\\idl\\other.idl", False),
        ("../out.idl", True), (str(tmp_path / "out.idl"), True), ("/etc/passwd", True),
    ):  # fmt: skip
        port["idlFile"] = name
        assert (("dataPorts.0.idlFile", "error") in told(form, granted, (granted,))) is is_bad, name


def test_places_follow_the_form() -> None:
    form = {"servicePorts": [{"serviceInterface": [{}, {}]}], "basicInfo": {}}
    service = "/rtc:RtcProfile/rtc:ServicePorts"
    assert place_of(f"{service}/rtc:ServiceInterface[2]/@rtc:type", form) == (
        "servicePorts.0.serviceInterface.1.type"
    )
    doc = "/rtc:RtcProfile/rtc:BasicInfo/rtcDoc:Doc/@rtcDoc:license"
    assert place_of(doc, form) == "basicInfo.rtcDoc::doc.license"
    assert place_of("/rtc:RtcProfile/*[local-name()='x']", form) == ""
