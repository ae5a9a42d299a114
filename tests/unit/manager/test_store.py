"""The store on disk: what was written is read again, and what is no store is put aside."""

from __future__ import annotations

import errno
import os
import shutil
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rtkit.errors import Refused
from rtkit.manager.store.store import (
    APPLICATION,
    NOTED,
    VERSION,
    Store,
    StoreFailed,
    StoreLost,
    remove,
)
from rtkit.manager.store.writer import StoreWriter

ROWS = [("component", f"C{n}", f'{{"create":"{"x" * 300}"}}') for n in range(60)]


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Where a store with rows lies, as a manager that was killed leaves it."""
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    draft = str(tmp_path / "draft")
    store = Store(draft)
    store.write(ROWS)
    path = tmp_path / "m.desired"
    for suffix in ("", "-wal"):
        shutil.copyfile(draft + suffix, f"{path}{suffix}")
    store.forget()
    return str(path)


def test_a_store_under_its_former_name_is_read_and_renamed(path: str) -> None:
    former = path.replace(".desired", ".wishes")
    os.rename(path, former)  # broken off before: what lies beside it was renamed already
    assert Store(path).find() == (ROWS, "")
    assert not os.path.lexists(former)
    assert not os.path.lexists(f"{former}-wal")


def test_the_writer_finds_a_store_under_its_former_name(path: str) -> None:
    os.rename(path, path.replace(".desired", ".wishes"))
    assert StoreWriter(path).find() == (ROWS, "")


def test_a_store_under_its_former_name_is_put_aside(path: str) -> None:
    os.rename(path, path.replace(".desired", ".wishes"))
    assert (
        StoreWriter(path).set_aside()
        == f"the unrestored state store is kept aside: {path}.unrestored-1"
    )
    assert StoreWriter(path).find() == ([], "")


def test_a_store_that_cannot_be_renamed_is_told(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    os.rename(path, path.replace(".desired", ".wishes"))

    def refuse(*_: str) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(os, "rename", refuse)
    found = Store(path).find()
    assert found.rows == []
    assert "cannot be renamed" in found.finding


def alter(path: str, *statements: str) -> None:
    with sqlite3.connect(path) as db:
        for statement in statements:
            db.execute(statement)
    db.close()


def cut(path: str, keep: int) -> None:
    os.truncate(path, keep)


def spoil(path: str, start: int, end: int) -> None:
    with open(path, "r+b") as file:
        file.seek(start)
        file.write(os.urandom(end - start))


def merged(path: str) -> str:
    """Have all in the main file, nothing in the log."""
    store = Store(path)
    assert store.find().rows == ROWS
    store.close()
    assert not os.path.exists(f"{path}-wal")
    return path


DAMAGES: dict[str, Callable[[str], object]] = {
    "emptied": lambda path: (merged(path), cut(path, 0)),
    "emptied with its log": lambda path: (cut(path, 0), cut(f"{path}-wal", 0)),
    "truncated": lambda path: cut(merged(path), 9000),
    "cut in its first page": lambda path: cut(merged(path), 700),
    "rubbish": lambda path: Path(merged(path)).write_text("rubbish\n" * 500),
    "flipped head": lambda path: spoil(merged(path), 0, 64),
    "flipped pages": lambda path: spoil(merged(path), 4096, 16384),
    "somebody else's": lambda path: alter(path, "pragma application_id = 7"),
    "an older form": lambda path: alter(path, "pragma user_version = 0"),
    "another table": lambda path: alter(path, "drop table kept", "create table kept (x)"),
    "no table": lambda path: alter(path, "drop table kept"),
}


def test_rows_come_back_in_their_order_and_changed(path: str) -> None:
    store = Store(path)
    assert store.find() == (ROWS, "")
    store.write([("component", "C3", "new"), ("component", "C0", None), ("wire", "w", "1")])
    store.close()
    expected = [("component", "C3", "new") if row[1] == "C3" else row for row in ROWS[1:]]
    assert Store(path).find().rows == [*expected, ("wire", "w", "1")]


@pytest.mark.parametrize("damage", DAMAGES)
def test_what_is_no_store_is_put_aside_and_another_one_begun(path: str, damage: str) -> None:
    DAMAGES[damage](path)
    store = Store(path)
    rows, told = store.find()
    assert rows == []
    assert told.startswith(f"the damaged state store is kept aside: {path}.damaged-1 (")
    assert os.path.exists(f"{path}.damaged-1")
    store.write(ROWS)
    store.close()
    assert Store(path).find() == (ROWS, "")


def test_several_are_put_aside_under_several_names(path: str) -> None:
    os.unlink(f"{path}-wal")
    for number in (1, 2, 3):
        Path(path).write_text("rubbish")
        assert f"damaged-{number}" in Store(path).find().finding


def test_one_of_a_newer_rtkit_is_left_as_it_is(path: str) -> None:
    alter(path, f"pragma user_version = {VERSION + 1}")
    before = Path(path).read_bytes()
    with pytest.raises(
        Refused, match=rf"a newer rtkit wrote .* \(version {VERSION + 1}\).*rtkit.restore:NO"
    ):
        Store(path).find()
    assert Path(path).read_bytes() == before


def test_one_that_another_process_uses_is_left_as_it_is(path: str) -> None:
    """Who that is, is told: this process would not see locks of its own."""
    code = f"""
import sqlite3, sys
db = sqlite3.connect({path!r}, isolation_level=None)
db.execute("begin exclusive")
print("locked", flush=True)
sys.stdin.read()
"""
    other = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert other.stdout is not None
    assert other.stdout.readline() == b"locked\n"
    try:
        with pytest.raises(
            Refused, match=rf"process {other.pid} \(python.*\) uses the state store"
        ):
            Store(path).find()
    finally:
        other.communicate()
    assert Store(path).find().rows == ROWS


def test_one_that_cannot_be_written_is_read_and_told(
    path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on a disk that is mounted for reading only."""
    connect = sqlite3.connect

    def refuse(file: str, *args: object, **options: object) -> sqlite3.Connection:
        if file == path:
            error = sqlite3.OperationalError("unable to open database file")
            error.sqlite_errorcode = sqlite3.SQLITE_CANTOPEN
            raise error
        return connect(file, *args, **options)  # type: ignore[call-overload, no-any-return]

    monkeypatch.setattr(sqlite3, "connect", refuse)
    store = Store(path)
    rows, told = store.find()
    assert rows == ROWS
    assert told == f"the state store cannot be written: unable to open database file ({path})"
    with pytest.raises(StoreFailed, match="unable to open"):
        store.write([("wire", "w", "1")])
    monkeypatch.undo()
    store.write([("wire", "w", "1")])
    store.close()
    assert len(Store(path).find().rows) == len(ROWS) + 1


def test_a_write_is_done_whole_or_not_at_all(path: str) -> None:
    store = Store(path)
    with pytest.raises(StoreFailed, match="NOT NULL"):
        store.write([("wire", "w", "1"), ("wire", None, "2")])  # type: ignore[list-item]
    assert store.find().rows == ROWS
    store.close()


def test_a_store_that_is_removed_under_way_is_told_once_and_then_made_anew(path: str) -> None:
    """What is left of its log is not taken for one of the new file."""
    store = Store(path)
    store.find()
    store.write([("wire", "old", "1")])
    os.unlink(path)
    with pytest.raises(StoreLost, match="the state store was removed"):
        store.write([("wire", "w", "1")])
    Path(f"{path}-wal").write_bytes(b"a log of another file" * 1000)
    store.write([("wire", "w", "1")])
    store.close()
    assert Store(path).find().rows == [("wire", "w", "1")]


def test_a_store_that_is_replaced_under_way_is_put_aside(path: str) -> None:
    store = Store(path)
    store.find()
    os.unlink(path)
    Path(path).write_text("a backup")
    with pytest.raises(StoreLost, match=r"another file; .* kept aside: .*foreign-1"):
        store.write([("wire", "w", "1")])
    store.write([("wire", "w", "1")])
    assert Path(f"{path}.foreign-1").read_text() == "a backup"
    store.close()


def test_the_keeper_tells_that_the_store_is_gone_before_it_makes_another(path: str) -> None:
    """Also when it was removed before anything was written to it."""
    keeper = StoreWriter(path)
    keeper.find()
    os.unlink(path)
    told: list[tuple[int, bool]] = []
    keeper.stored = lambda number, why, is_lost: told.append((number, is_lost))
    keeper.keep(1, [("wire", "w", "1")])
    keeper.close()
    assert told == [(1, True)]
    assert not os.path.exists(path)


def killed(path: str, commits: int) -> str:
    """Return a store as a manager that was killed leaves it after so many commits."""
    store = Store(f"{path}.before")
    for number in range(commits):
        store.write([("wire", str(number), "1")])
    for suffix in ("", "-wal", NOTED):
        shutil.copyfile(f"{path}.before{suffix}", f"{path}{suffix}")
    store.forget()
    assert not os.path.lexists(f"{path}.before{NOTED}")
    return path


def test_a_store_that_was_removed_with_nobody_there_is_told_once(path: str) -> None:
    os.unlink(killed(path, 3))
    told = f"the state store was removed ({path}): only what lives is known"
    assert Store(path).find() == ([], told)
    assert StoreWriter(path).find() == ([], told)
    store = Store(path)
    store.prepare()
    store.close()
    assert Store(path).find() == ([], "")


@pytest.mark.parametrize("keep", [0.0, 0.6, 0.9])
def test_a_journal_that_lacks_its_end_is_told(path: str, keep: float) -> None:
    log = f"{killed(path, 5)}-wal"
    os.truncate(log, int(keep * os.path.getsize(log)))
    store = Store(path)
    rows, told = store.find()
    assert len(rows) < 5
    assert told.startswith(f"the state store lacks its last {5 - len(rows)} changes ({path})")
    store.write([("wire", "w", "1")])
    store.close()
    assert Store(path).find().finding == ""


def test_an_older_store_in_its_place_is_told(path: str) -> None:
    older = killed(f"{path}.older", 2)
    killed(path, 4)
    for suffix in ("", "-wal"):
        os.replace(older + suffix, path + suffix)
    assert "lacks its last 2 changes" in Store(path).find().finding


def test_a_store_of_an_earlier_rtkit_counts_from_now_on(path: str) -> None:
    alter(merged(path), "drop table commits")
    store = Store(path)
    assert store.find() == (ROWS, "")
    store.write([("wire", "w", "1")])
    store.close()
    os.unlink(path)
    assert "was removed" in Store(path).find().finding


@pytest.mark.parametrize("suffix", ["", "-wal", NOTED])
def test_nothing_is_written_through_a_link(path: str, suffix: str) -> None:
    target = Path(f"{path}.target")
    target.write_bytes(b"somebody else's")
    if os.path.exists(path + suffix):
        os.unlink(path + suffix)
    os.symlink(target, path + suffix)
    store = Store(path)
    with pytest.raises(Refused, match=rf"{path}{suffix} is a link, and not written through"):
        store.find()
    with pytest.raises(StoreFailed, match="symbolic link"):
        store.write([("wire", "w", "1")])
    assert target.read_bytes() == b"somebody else's"
    store.set_aside("unrestored")
    store.write([("wire", "w", "1")])
    store.close()
    assert target.read_bytes() == b"somebody else's"


def test_what_is_forgotten_leaves_nothing(path: str) -> None:
    store = Store(path)
    store.find()
    store.forget()
    assert os.listdir(os.path.dirname(path)) == []
    assert not remove(path)


def test_a_store_is_one_by_what_is_written_in_it(tmp_path: Path) -> None:
    path = tmp_path / "m.desired"
    store = Store(str(path))
    store.prepare()
    store.close()
    assert path.stat().st_mode & 0o777 == 0o600
    with sqlite3.connect(path) as db:
        assert db.execute("pragma application_id").fetchone() == (APPLICATION,)
        assert db.execute("pragma journal_mode").fetchone() == ("wal",)
    db.close()


def test_the_keeper_tells_what_is_on_the_disk_and_what_is_not(tmp_path: Path) -> None:
    path = tmp_path / "m.desired"
    keeper = StoreWriter(str(path))
    assert keeper.find() == ([], "")
    told: list[tuple[int, str]] = []
    keeper.stored = lambda number, why, _is_lost: told.append((number, why))
    keeper.keep(1, ROWS[:1])
    keeper.keep(2, ROWS[1:])
    keeper.keep(3, [("wire", None, "2")])  # type: ignore[list-item]
    keeper.close()
    assert [number for number, _ in told] == [1, 2, 3]
    assert all("NOT NULL" in why for number, why in told if number == 3)
    heir = StoreWriter(str(path))
    rows, remark = heir.find()
    # What comes while it writes is one commit, so that the second may fail with the third.
    orders = zip((ROWS[:1], ROWS[1:]), told, strict=False)
    assert rows == [row for order, (_, why) in orders if not why for row in order]
    assert remark == ""
    heir.forget()
    heir.close()
    assert not path.exists()
