"""Shared memory that nobody holds any more is removed, and no other."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

import pytest

from rtkit.link import segments
from rtkit.link.segments import remove_orphans


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(segments, "_SETTLED_S", 0.0)
    return tmp_path


def test_only_what_no_process_holds_is_removed(folder: Path) -> None:
    for name in ("1.zenoh", "22.zenoh", "333.zenoh", "x.zenoh", "4.other", "5.zenoh.bak"):
        (folder / name).write_bytes(b"x" * 100)
    (folder / "6.zenoh").mkdir()
    (folder / "7.zenoh").symlink_to(folder / "4.other")
    os.mkfifo(folder / "8.zenoh")
    with (folder / "22.zenoh").open("rb") as held:
        fcntl.flock(held, fcntl.LOCK_SH)
        assert remove_orphans(str(folder)) == 200
    left = {each.name for each in folder.iterdir()}
    kept = {"22.zenoh", "x.zenoh", "4.other", "5.zenoh.bak", "6.zenoh", "7.zenoh", "8.zenoh"}
    assert left == kept
    assert remove_orphans(str(folder)) == 100


def test_what_was_just_made_may_not_be_locked_yet(tmp_path: Path) -> None:
    (tmp_path / "1.zenoh").write_bytes(b"x")
    assert remove_orphans(str(tmp_path)) == 0
    assert remove_orphans(str(tmp_path / "absent")) == 0
