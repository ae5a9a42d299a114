"""Files are written whole or not at all."""

from __future__ import annotations

import errno
import os
import stat
import threading
from pathlib import Path

import pytest

from rtkit.errors import NotFound, Refused
from rtkit.link.atomic import write_output


def left_over(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.iterdir() if file.name.startswith("."))


def test_a_new_file_has_the_usual_mode(tmp_path: Path) -> None:
    mask = os.umask(0o027)
    try:
        write_output(b"text", str(tmp_path / "a"))
    finally:
        os.umask(mask)
    assert (tmp_path / "a").read_bytes() == b"text"
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o640


def test_a_file_that_is_replaced_keeps_its_mode_and_its_links(tmp_path: Path) -> None:
    file, link = tmp_path / "a", tmp_path / "link"
    file.write_bytes(b"old")
    file.chmod(0o604)
    link.symlink_to("a")
    write_output(b"new", str(link))
    assert link.is_symlink()
    assert file.read_bytes() == b"new"
    assert stat.S_IMODE(file.stat().st_mode) == 0o604
    assert left_over(tmp_path) == []


def test_what_must_be_new_touches_nothing(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"old")
    (tmp_path / "dangling").symlink_to("nowhere")
    with pytest.raises(Refused, match="a is there already; --force replaces it"):
        write_output(b"new", str(tmp_path / "a"), is_new=True)
    write_output(b"new", str(tmp_path / "b"), is_new=True)
    assert (tmp_path / "a").read_bytes() == b"old"
    assert (tmp_path / "b").read_bytes() == b"new"
    assert left_over(tmp_path) == []


def test_of_two_that_make_a_new_file_one_is_told_so(tmp_path: Path) -> None:
    refused = []
    start = threading.Barrier(8)

    def write(number: int) -> None:
        start.wait()
        try:
            write_output(b"%d" % number * 10_000, str(tmp_path / "a"), is_new=True)
        except Refused:
            refused.append(number)

    writers = [threading.Thread(target=write, args=(number,)) for number in range(8)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert len(refused) == 7
    assert len(set((tmp_path / "a").read_bytes())) == 1
    assert left_over(tmp_path) == []


def test_a_failure_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a").write_bytes(b"old")

    def full(_descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(NotFound, match=r"cannot write .*a: No space left on device"):
        write_output(b"new", str(tmp_path / "a"))
    assert (tmp_path / "a").read_bytes() == b"old"
    assert left_over(tmp_path) == []


def test_where_no_links_can_be_made_it_is_written_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unable(_old: str, _new: str, **_how: int) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "link", unable)
    write_output(b"new", str(tmp_path / "a"), is_new=True)
    assert (tmp_path / "a").read_bytes() == b"new"
    assert left_over(tmp_path) == []


@pytest.mark.parametrize(
    ("name", "why"), [("no/a", "No such file"), (".", "Is a directory"), ("a\0b", "null")]
)
def test_places_that_cannot_be_written(tmp_path: Path, name: str, why: str) -> None:
    with pytest.raises(NotFound, match=f"(?s)cannot write .*{why}"):
        write_output(b"new", f"{tmp_path}/{name}")


def test_a_device_is_written_to(tmp_path: Path) -> None:
    write_output(b"new", os.devnull)
    assert not Path(os.devnull).is_file()


@pytest.mark.parametrize("is_new", [True, False])
def test_without_files_that_have_no_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_new: bool
) -> None:
    opened = os.open

    def refuse(path: str, flags: int, *more: int) -> int:
        if flags & os.O_TMPFILE == os.O_TMPFILE:
            raise OSError(errno.EOPNOTSUPP, os.strerror(errno.EOPNOTSUPP))
        return opened(path, flags, *more)

    monkeypatch.setattr(os, "open", refuse)
    write_output(b"text", str(tmp_path / "a"), is_new=is_new)
    assert (tmp_path / "a").read_bytes() == b"text"
    assert left_over(tmp_path) == []


def test_who_reads_meanwhile_reads_the_whole(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"a" * 100_000)
    with (tmp_path / "a").open("rb") as reader:
        write_output(b"b", str(tmp_path / "a"))
        assert reader.read() == b"a" * 100_000


def test_drafts_of_the_dead_are_removed_and_those_of_the_living_are_not(tmp_path: Path) -> None:
    child = os.fork()
    if not child:
        os._exit(0)
    os.waitpid(child, 0)
    others = [f".a.{os.getppid()}.1.draft", ".a.of mine.draft", f".b.{child}.1.draft"]
    for name in (*others, f".a.{child}.1.draft"):
        (tmp_path / name).touch()
    write_output(b"text", str(tmp_path / "a"))
    assert left_over(tmp_path) == sorted(others)


def test_the_longest_name(tmp_path: Path) -> None:
    write_output(b"text", str(tmp_path / ("ä" * 127)))
    write_output(b"more", str(tmp_path / ("ä" * 127)))
    assert [file.read_bytes() for file in tmp_path.iterdir()] == [b"more"]


@pytest.mark.parametrize("is_lasting", [True, False])
def test_only_for_what_has_to_last_the_disk_is_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_lasting: bool
) -> None:
    synced: list[int] = []
    monkeypatch.setattr(os, "fsync", synced.append)
    write_output(b"text", str(tmp_path / "a"), is_lasting=is_lasting)
    assert (tmp_path / "a").read_bytes() == b"text"
    assert bool(synced) is is_lasting
