"""Files that a page may use: those in the folders that were granted."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtkit.errors import NotFound, Refused
from rtkit.web.folders import granted, profiles_in


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a profile, a folder below, and links out of it."""
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "secret.xml").touch()
    folder = tmp_path / "in"
    (folder / "below").mkdir(parents=True)
    (folder / "robot.xml").touch()
    (folder / "link.xml").symlink_to(tmp_path / "out" / "secret.xml")
    (folder / "way").symlink_to(tmp_path / "out")
    return folder


def test_files_in_the_folder_are_granted(folder: Path) -> None:
    file = str(folder / "robot.xml")
    assert profiles_in([str(folder)]) == [file]
    assert granted(file, [str(folder)]) == file
    fresh = str(folder / "below" / "new.yaml")
    assert granted(fresh, [str(folder)], is_new=True) == fresh
    with pytest.raises(NotFound):
        granted(fresh, [str(folder)])


def test_a_file_is_found_once_in_folders_within_each_other(folder: Path) -> None:
    (folder / "below" / "arm.xml").touch()
    found = profiles_in([str(folder), str(folder / "below")])
    assert found == [str(folder / "below" / "arm.xml"), str(folder / "robot.xml")]


@pytest.mark.parametrize("is_new", [False, True])
@pytest.mark.parametrize(
    "path",
    [
        "link.xml", "way/secret.xml", "../out/secret.xml", "below/../../out/secret.xml",
        "robot.sh", "", "//robot.xml", "./robot.xml",
    ],
)  # fmt: skip
def test_what_leaves_the_folder_is_refused(folder: Path, path: str, is_new: bool) -> None:
    with pytest.raises(Refused):
        granted(f"{folder}/{path}", [str(folder)], is_new=is_new)


def test_other_folders_are_refused(folder: Path) -> None:
    with pytest.raises(Refused, match="in no folder that this page was granted"):
        granted("/etc/passwd.xml", [str(folder)])
    with pytest.raises(Refused):
        granted(f"{folder}{folder}x/robot.xml", [])
