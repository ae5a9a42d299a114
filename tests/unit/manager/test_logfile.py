"""Log files stay short, are for one user, and never stop who logs, whatever becomes of the disk."""

from __future__ import annotations

import errno
import logging
import os
import pty
import re
import subprocess
import sys

import pytest

from rtkit.logs import logfile
from rtkit.logs.logfile import LogFile, Lossy, Terminal


def line(text):
    return logging.LogRecord("A", logging.INFO, "", 0, text, (), None)


def lossy(target):
    return Lossy(target, logging.Formatter("%(message)s"))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "m.log"


def test_lines_are_appended_to_what_is_there(path):
    for text in (b"one\n", b"two\n"):
        file = LogFile(str(path))
        file.write(text)
        file.close()
    assert path.read_bytes() == b"one\ntwo\n"


def test_a_full_file_is_begun_anew_and_the_older_ones_are_bounded(path):
    file = LogFile(str(path), max_bytes=20, files=3)
    for number in range(100):
        file.write(b"line %04d\n" % number)
    found = {each.name: each.read_text() for each in path.parent.iterdir()}
    assert found == {
        "m.log": "line 0098\nline 0099\n",
        "m.log.1": "line 0096\nline 0097\n",
        "m.log.2": "line 0094\nline 0095\n",
    }


def test_a_line_longer_than_a_file_has_one_of_its_own(path):
    file = LogFile(str(path), max_bytes=20, files=2)
    for text in (b"short\n", b"x" * 100 + b"\n", b"short again\n"):
        file.write(text)
    assert path.read_bytes() == b"short again\n"
    assert (path.parent / "m.log.1").read_bytes() == b"x" * 100 + b"\n"


def test_who_finds_another_file_there_follows(path):
    one, two = LogFile(str(path), 20, 3), LogFile(str(path), 20, 3)
    one.write(b"one 1\n")
    two.write(b"two 1\n")
    one.write(b"one 2\n")
    two.write(b"two 2\n")  # turns it over
    one.write(b"one 3\n")
    assert path.read_bytes() == b"two 2\none 3\n"
    path.unlink()
    one.write(b"one 4\n")
    assert path.read_bytes() == b"one 4\n"


def test_only_one_of_two_turns_a_file_over(path, monkeypatch):
    file = LogFile(str(path), 10, 3)
    file.write(b"12345678\n")

    def busy(_descriptor, _operation):
        raise BlockingIOError

    monkeypatch.setattr(logfile.fcntl, "flock", busy)
    file.write(b"abc\n")
    assert path.read_bytes() == b"12345678\nabc\n"


def test_many_writers_lose_no_line_and_tear_none(path):
    script = (
        "import sys; from rtkit.logs.logfile import LogFile\n"
        f"file = LogFile({str(path)!r}, 4096, 10)\n"
        "for number in range(500): file.write(b'%s %03d\\n' % (sys.argv[1].encode(), number))\n"
    )
    writers = [subprocess.Popen([sys.executable, "-c", script, str(n)]) for n in range(4)]
    assert [writer.wait() for writer in writers] == [0] * 4
    files = list(path.parent.iterdir())
    lines = sorted(line for file in files for line in file.read_text().splitlines())
    assert lines == sorted(f"{writer} {number:03}" for writer in range(4) for number in range(500))
    assert len(files) > 2
    assert max(file.stat().st_size for file in files) < 2 * 4096


def test_files_are_for_one_user(path):
    before = os.umask(0)
    try:
        path.write_text("old\n")
        path.chmod(0o666)
        file = LogFile(str(path), 10, 3)
        for _ in range(3):
            file.write(b"1234567\n")
    finally:
        os.umask(before)
    modes = {each.stat().st_mode & 0o777 for each in path.parent.iterdir()}
    assert modes == {0o600}


@pytest.mark.parametrize("kind", ["folder", "fifo", "link"])
def test_what_is_no_file_is_not_written_to(path, kind):
    if kind == "folder":
        path.mkdir()
    elif kind == "fifo":
        os.mkfifo(path)
    else:
        (path.parent / "elsewhere").write_text("")
        path.symlink_to(path.parent / "elsewhere")
    with pytest.raises(OSError, match=r"directory|not a file|No such device|symbolic links"):
        LogFile(str(path)).write(b"x\n")
    if kind == "link":
        assert (path.parent / "elsewhere").read_text() == ""


class Disk:
    """Writes, unless it is full."""

    def __init__(self):
        self.text = b""
        self.failure: Exception | None = None

    def write(self, text):
        if self.failure is not None:
            raise self.failure
        self.text += text

    def close(self):
        self.is_closed = True


def test_what_is_lost_is_counted_and_told_once():
    disk = Disk()
    handler = lossy(disk)
    handler.handle(line("before"))
    disk.failure = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    for number in range(3):
        handler.handle(line(f"lost {number}"))
    disk.failure = None
    handler.handle(line("after"))
    handler.handle(line("more"))
    assert disk.text == (b"before\n3 log records were lost: No space left on device\nafter\nmore\n")


def test_no_failure_reaches_who_logs():
    disk = Disk()
    handler = lossy(disk)
    for failure in (MemoryError(), RecursionError("deep"), OSError()):
        disk.failure = failure
        handler.handle(line("x"))
    disk.failure = None
    handler.handle(line("y"))
    assert disk.text == b"3 log records were lost: OSError: \ny\n"


def test_a_line_that_was_cut_by_a_full_disk_does_not_spoil_the_next(path, monkeypatch):
    handler = lossy(LogFile(str(path)))
    write = os.write
    monkeypatch.setattr(logfile.os, "write", lambda fd, text: write(fd, text[:4]))
    handler.handle(line("first line"))
    monkeypatch.setattr(logfile.os, "write", write)
    handler.handle(line("second line"))
    assert path.read_text() == (
        "firs\n1 log records were lost: No space left on device\nsecond line\n"
    )


def test_a_terminal_that_is_held_up_holds_nobody_up():
    read, write = os.pipe()
    handler = lossy(Terminal(write))
    for _ in range(100):  # more than the pipe takes, and nobody reads
        handler.handle(line("x" * 4000))
    os.set_blocking(read, False)
    assert len(os.read(read, 1_000_000)) < 100 * 4000
    handler.handle(line("last"))
    text = os.read(read, 1_000_000).decode()
    assert re.fullmatch(r"(x*\n)?\d+ log records were lost: the terminal was held up\nlast\n", text)
    os.close(read)
    handler.handle(line("nobody reads"))
    handler.close()


def test_a_real_terminal_gets_lines():
    ours, theirs = pty.openpty()
    handler = lossy(Terminal(theirs))
    handler.handle(line("hello"))
    assert os.read(ours, 100) == b"hello\r\n"
    handler.close()
    os.close(ours)
