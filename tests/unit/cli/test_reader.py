"""Who reads stdout."""

from __future__ import annotations

import io
import os
import sys
import threading

import pytest

from rtkit.cli.data import recorder
from rtkit.cli.shared import stdout_reader
from rtkit.errors import Refused


def test_the_end_of_a_reader_is_heard_though_nothing_is_written(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    read, write = os.pipe()
    heard = threading.Event()
    with os.fdopen(write, "w") as stdout:
        monkeypatch.setattr(sys, "stdout", stdout)
        with stdout_reader.while_read(heard.set) as reader:
            reader.check()
            os.close(read)
            assert heard.wait(30)
            with pytest.raises(BrokenPipeError):
                reader.check()


def test_a_reader_that_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    read, write = os.pipe()
    with os.fdopen(write, "w") as stdout:
        monkeypatch.setattr(sys, "stdout", stdout)
        with stdout_reader.while_read(pytest.fail) as reader:
            pass
        assert not reader.is_gone
    os.close(read)


def test_what_nobody_can_leave(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", io.StringIO())
    with stdout_reader.while_read(pytest.fail) as reader:
        reader.check()


def test_a_terminal_is_shown_no_mcap(monkeypatch: pytest.MonkeyPatch) -> None:
    master, slave = os.openpty()
    with os.fdopen(slave, "w") as stdout:
        monkeypatch.setattr(sys, "stdout", stdout)
        with pytest.raises(Refused, match="cannot show MCAP"), recorder.opened("-", "mcap"):
            pass
        with recorder.opened("-", "text") as file:
            assert file is stdout.buffer
    os.close(master)
