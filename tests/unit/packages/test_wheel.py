"""Wheels that could do harm are refused before anything of them is unpacked."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from wheelkit import made

from rtkit.errors import InvalidDocument, Malformed, Refused, RtkitError
from rtkit.packages import wheel as wheels
from rtkit.packages.wheel import named, objections, read_wheel


def test_what_a_wheel_is_is_read_without_running_it(tmp_path: Path) -> None:
    found = read_wheel(str(made(tmp_path, "gain", "1.2", type="Gain", requires=("rtkit",))))
    assert (found.name, found.version, found.requires) == ("gain", "1.2", ("rtkit",))
    assert [each.id for each in found.types] == ["RTC:me:test:Gain:1.2"]


@pytest.mark.parametrize("path", ["../x.py", "/x.py", "a/../../x.py", "c:x.py"])
def test_paths_that_leave_the_folder_are_refused(tmp_path: Path, path: str) -> None:
    with pytest.raises(Refused, match="leaves its folder"):
        read_wheel(str(made(tmp_path, "gain", "1", {path: ""})))


def test_links_are_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="has a link"):
        read_wheel(str(made(tmp_path, "gain", "1", {"x": "/etc"}, links=("x",))))


def test_control_characters_are_refused_and_shown_as_escapes(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="control characters") as caught:
        read_wheel(str(made(tmp_path, "gain", "1", {"\x1b[2Jx": ""})))
    assert "\x1b" not in str(caught.value)
    with pytest.raises(Malformed) as named_badly:
        named("ga\x1bin-1-py3-none-any.whl")
    assert "\x1b" not in str(named_badly.value)


def test_other_bytes_than_those_of_record_are_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="x is not what RECORD says"):
        read_wheel(str(made(tmp_path, "gain", "1", {"x": "y"}, lies=("x",))))


def test_files_that_record_lacks_are_refused(tmp_path: Path) -> None:
    path = made(tmp_path, "gain", "1")
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("more.py", "")
    with pytest.raises(Refused, match=r"RECORD has no more\.py"):
        read_wheel(str(path))


def test_bombs_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wheels, "LARGEST_WHEEL", 1 << 10)
    with pytest.raises(Refused, match="unpacks to more than"):
        read_wheel(str(made(tmp_path, "gain", "1", {"x": "0" * 5000})))


def test_another_name_inside_is_refused(tmp_path: Path) -> None:
    path = made(tmp_path, "gain", "1").rename(tmp_path / "other-1-py3-none-any.whl")
    with pytest.raises(Refused, match="calls itself gain 1 inside"):
        read_wheel(str(path))


@pytest.mark.parametrize("data", [b"", b"PK", b"rubbish" * 100])
def test_rubbish_is_no_wheel(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "gain-1-py3-none-any.whl"
    path.write_bytes(data)
    with pytest.raises(InvalidDocument, match="is no wheel"):
        read_wheel(str(path))


def test_every_cut_of_a_wheel_is_refused(tmp_path: Path) -> None:
    path = made(tmp_path, "gain", "1", type="Gain")
    whole = path.read_bytes()
    for length in range(0, len(whole), 97):
        path.write_bytes(whole[:length])
        with pytest.raises(RtkitError):
            read_wheel(str(path))


def test_a_changed_byte_is_refused_or_of_no_account_but_no_bug(tmp_path: Path) -> None:
    path = made(tmp_path, "gain", "1", type="Gain")
    with zipfile.ZipFile(path) as stored:
        inside = {each: stored.read(each) for each in stored.namelist()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in inside.items():
            packed.writestr(name, data)
    whole, found = path.read_bytes(), set[str]()
    for place in range(0, len(whole), 3):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 2]) + whole[place + 1 :])
        try:
            read_wheel(str(path))
        except RtkitError as error:
            found.add(str(error).partition(": ")[0])
    assert f"{path.name} is no wheel, or damaged" in found
    unnamed = made(tmp_path, "gain", "2", {"gain-2.dist-info/x": ""})
    _replace(unnamed, b"Name: gain", b"Nbme: gain")
    with pytest.raises(InvalidDocument, match="'name' is a required field"):
        read_wheel(str(unnamed))


def _replace(wheel: Path, old: bytes, new: bytes) -> None:
    with zipfile.ZipFile(wheel) as archive:
        inside = {each: archive.read(each).replace(old, new) for each in archive.namelist()}
    with zipfile.ZipFile(wheel, "w") as archive:
        for name, data in inside.items():
            archive.writestr(name, data)


def test_types_without_profile_and_entry_points_without_type_are_objected_to(
    tmp_path: Path,
) -> None:
    whole = read_wheel(str(made(tmp_path, "gain", "1", type="Gain")))
    assert objections(whole) == ["type RTC:me:test:Gain:1 has no RTC profile in the package"]
    assert "offers no type" in objections(whole._replace(types=()))[0]
    assert "no entry point" in objections(whole._replace(entries=()))[0]
    bad = whole._replace(profiles={"a.xml": b"<rtcProfile>"})
    assert objections(bad)[0].startswith("a.xml:")
