"""The id of a component in a profile chooses among the versions of installed packages."""

from __future__ import annotations

from pathlib import Path

import pytest
from wheelkit import made, unpacked

from rtkit.deployment.described import properties_of
from rtkit.modules.package_folders import folders
from rtkit.packages.offering import chosen, offerings
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import ComponentInstance, RtsProfile

ONE, TWO = "RTC:me:test:Gain:1.0", "RTC:me:test:Gain:2.0"


@pytest.fixture(autouse=True)
def _installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    for version in ("1.0", "2.0"):
        unpacked(tmp_path, made(tmp_path / "wheels", "gain", version, type="Gain"))


def of(id: str, *, offers: bool = False, **told: str) -> dict[str, str]:
    """Return what a profile says of its one component when ids have chosen."""
    properties = [ExtensionProperty(f"rtkit.{key}", value) for key, value in told.items()]
    component = ComponentInstance(
        id=id, path_uri="localhost/g.rtc", instance_name="g", properties=tuple(properties)
    )
    profile = RtsProfile("RTSystem:me:s:1", "0.2", "", "", components=(component,))
    found = dict.fromkeys(["g"], offerings({id})[id]) if offerings({id}) else {}
    (after,) = chosen(profile, found, lambda *_: offers).components
    return {key.removeprefix("rtkit."): v for key, v in properties_of(after.properties).items()}


def test_versions_are_found_by_id() -> None:
    found = offerings({ONE, "RTC:me:test:Gain:3.0"})
    assert {id: [each.module for each in all] for id, all in found.items()} == {
        ONE: ["Gain==1.0:GainInit"]
    }


@pytest.mark.parametrize("stated", ["Gain.py:GainInit", "Gain", "gain.Gain", "Gain==2.0:GainInit"])
def test_the_id_outranks_the_module_of_another_version(stated: str) -> None:
    told = of(ONE, create="Gain?manager_name=a&conf.default.x=1", module=stated)
    assert told == {
        "create": "RTC:me:test:Gain:Python:1.0?manager_name=a&conf.default.x=1",
        "module": "Gain==1.0:GainInit",
    }


def test_the_id_outranks_the_version_of_a_create_string() -> None:
    told = of(TWO, create="RTC:me:test:Gain:Python:1.0?manager_name=a", module="Gain==1.0:GainInit")
    assert told["create"] == "RTC:me:test:Gain:Python:2.0?manager_name=a"
    assert told["module"] == "Gain==2.0:GainInit"


def test_a_module_that_offers_the_very_type_stays() -> None:
    told = of(ONE, create="Gain", module="Gain.py:GainInit", offers=True)
    assert told == {"create": "RTC:me:test:Gain:Python:1.0", "module": "Gain.py:GainInit"}


@pytest.mark.parametrize(
    ("id", "told"),
    [
        (ONE, {"create": "Gain", "module": "/home/me/Gain.py:GainInit"}),
        (ONE, {"create": "Gain", "stand-in": "yes"}),
        (ONE, {"create": "Other"}),
        ("RTC:me:test:Gain:3.0", {"create": "Gain", "module": "Gain.py:GainInit"}),
        (ONE, {}),
    ],
)
def test_what_no_package_makes_is_left_as_it_is(id: str, told: dict[str, str]) -> None:
    assert of(id, **told) == told


def test_a_link_or_a_folder_without_a_record_is_no_version(tmp_path: Path) -> None:
    packages = tmp_path / "rtkit" / "packages"
    (packages / "gain" / "3.0").symlink_to(packages / "gain" / "1.0")
    (packages / "more").symlink_to(packages / "gain")
    (packages / "gain" / "4.0").mkdir()
    assert [(each.name, each.version) for each in folders()] == [("gain", "2.0"), ("gain", "1.0")]
