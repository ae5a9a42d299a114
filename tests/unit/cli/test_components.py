"""Where RTC profiles are looked for, and in which order."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from rtkit.api.component_profiles import profiles
from rtkit.errors import NotFound

PROFILES = Path(__file__).parents[3] / "profiles"


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in ("RTKIT_PROFILE_PATH", "RTKIT_MODULE_PATH", "RTC_MANAGER_CONFIG"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def put(place: Path, *names: str) -> None:
    for name in names:
        file = place / name
        file.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(PROFILES / "Motor.xml", file)


def names(*paths: str) -> list[str]:
    """Return what is found, without what ships."""
    found = [name for name, _ in profiles(paths, print)]
    return [name for name in found if not name.startswith(str(PROFILES))]


def test_what_ships_comes_last(place: Path) -> None:
    put(place, "a/Motor.xml")
    found = [name for name, _ in profiles(["a"], print)]
    assert found[0] == "a/Motor.xml"
    assert found[1:] == sorted(str(each) for each in PROFILES.glob("*.xml"))


def test_folders_that_are_named_are_looked_through(place: Path) -> None:
    put(
        place, "b/Z.xml", "b/deep/er/A.YAML", "b/.hidden/A.xml", "b/note.txt", "own.rtc", "c/C.json"
    )
    (place / "b" / "other.xml").write_text("<project/>")
    (place / "b" / "link.xml").symlink_to(place / "b" / "Z.xml")
    (place / "b" / "gone.xml").symlink_to(place / "nowhere")
    assert names("own.rtc", "c", "b") == ["own.rtc", "c/C.json", "b/Z.xml", "b/deep/er/A.YAML"]


def test_what_is_named_has_to_be_there(place: Path) -> None:
    with pytest.raises(NotFound, match="cannot read nix: No such file"):
        names("nix")


def test_profiles_beside_modules_and_in_the_search_path(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(
        place,
        "Arm.xml",
        "Leg.xml",
        "m/RTC.xml",
        "m/Leg.yaml",
        "m/x/Arm.xml",
        "p/Any.xml",
        "l/A.xml",
    )
    for module in ("Arm.py", "m/Leg.py", "m/.Any.py", "l/A.py"):
        (place / module).write_text("raise SystemExit('never run')")
    assert names() == ["Arm.xml"]
    monkeypatch.setenv("RTKIT_MODULE_PATH", f"{place / 'none'}:m")
    monkeypatch.setenv("RTKIT_PROFILE_PATH", "p")
    assert names() == ["p/Any.xml", "Arm.xml", "m/Leg.yaml", "m/RTC.xml"]
    (place / "rtc.conf").write_text("manager.modules.load_path: ./l\n")
    assert names() == ["p/Any.xml", "Arm.xml", "l/A.xml", "m/Leg.yaml", "m/RTC.xml"]


def test_an_rtc_conf_that_cannot_be_read_is_told_of(place: Path) -> None:
    (place / "rtc.conf").write_text("nonsense\n")
    told: list[str] = []
    assert len(list(profiles([], told.append))) == len(list(PROFILES.glob("*.xml")))
    assert told == [f"load paths are not known: {place}/rtc.conf:1: not KEY: VALUE: nonsense"]


def test_installed_packages_tell_their_components(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(place, "site/Arm.xml", "site/Other.xml")
    (place / "site" / "Arm.py").write_text("raise SystemExit('never run')")
    (place / "site" / "arm-1.dist-info").mkdir()
    entries = place / "site" / "arm-1.dist-info" / "entry_points.txt"
    entries.write_text("[rtkit.components]\nArm = Arm:ArmInit\n")
    monkeypatch.syspath_prepend(place / "site")
    found = profiles([], lambda _: None, with_shipped=False)
    assert [name for name, _ in found] == [str(place / "site" / "Arm.xml")]


def test_a_repository_tells_the_components_of_its_systems(place: Path) -> None:
    put(place, "rtc/Arm/RTC.xml", "rtc/Leg/RTC.xml", "rtc/Leg/Other.xml", "system/A.xml", "o/B.xml")
    for system in ("system/A.xml", "A.xml", "o/B.xml"):
        found = profiles([], lambda _: None, systems=[system], with_shipped=False)
        assert [name for name, _ in found] == ["rtc/Arm/RTC.xml", "rtc/Leg/RTC.xml"]
    assert not list(profiles([], lambda _: None, systems=["o/p/B.xml"], with_shipped=False))
