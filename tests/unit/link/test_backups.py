"""Copies of files before they are replaced."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtkit.errors import NotFound
from rtkit.link import backups


def kept(folder: Path) -> dict[str, str]:
    return {each.name: each.read_text() for each in sorted(folder.glob("*.bak*"))}


def replaced(file: Path, text: str, most: int = backups.MOST) -> None:
    backups.keep(str(file), most)
    file.unlink()
    file.write_text(text)


def test_the_latest_copies_are_kept(tmp_path: Path) -> None:
    file = tmp_path / "a.py"
    file.write_text("0")
    for number in range(1, 6):
        replaced(file, str(number), 3)
    assert kept(tmp_path) == {"a.py.bak": "2", "a.py.bak2": "3", "a.py.bak3": "4"}
    replaced(file, "6", 2)
    assert kept(tmp_path) == {"a.py.bak": "4", "a.py.bak2": "5"}
    replaced(file, "7", 0)
    assert kept(tmp_path) == {"a.py.bak": "4", "a.py.bak2": "5"}


def test_a_copy_is_put_back_and_what_was_there_is_the_latest(tmp_path: Path) -> None:
    file = tmp_path / "a.py"
    file.write_text("old")
    replaced(file, "new")
    (copy,) = backups.copies_in(str(tmp_path))
    backups.put_back(copy)
    assert (file.read_text(), kept(tmp_path)) == ("old", {"a.py.bak": "new"})
    backups.put_back(copy)
    assert (file.read_text(), kept(tmp_path)) == ("new", {"a.py.bak": "old"})
    file.unlink()
    backups.put_back(copy)
    assert (file.read_text(), kept(tmp_path)) == ("old", {})
    with pytest.raises(NotFound, match=r"a\.py\.bak"):
        backups.put_back(copy)


def test_only_copies_are_found_and_no_links(tmp_path: Path) -> None:
    for name in ("a.py", "a.py.bak", "a.py.bak12", "b.bakery", ".git/x.bak", "below/c.bak2"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(name)
    (tmp_path / "d.bak").symlink_to(tmp_path / "a.py")
    found = [(Path(e.path).name, Path(e.file).name, e.number)
             for e in backups.copies_in(str(tmp_path))]  # fmt: skip
    assert found == [("a.py.bak", "a.py", 1), ("a.py.bak12", "a.py", 12), ("c.bak2", "c", 2)]
    assert [each.number for each in backups.copies_of(str(tmp_path / "a.py"))] == [1, 12]
