"""Who looks at all managers names the one that does not answer, within its time."""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Iterator
from typing import Any

import pytest

SILENT = "manager 'm2' does not answer"


@pytest.fixture(scope="module")
def stopped(shared_shell: Any) -> Iterator[Any]:
    """A manager beside which another one is stopped; the tests only look at them."""
    shared_shell.ok("rtmgr start")
    shared_shell.ok("rtmgr start m2")
    pid = json.loads(shared_shell.ok("rtmgr status m2 --json"))["pid"]
    os.kill(pid, signal.SIGSTOP)
    yield shared_shell
    os.kill(pid, signal.SIGCONT)


@pytest.mark.parametrize(
    ("line", "status"),
    [
        ("rtls -R / --timeout 1", 1),
        ("rtls -l /localhost --timeout 1", 0),
        ("rtfind / --timeout 1", 1),
        ("rtcat /localhost/m2.mgr --timeout 1", 1),
        ("rtconf /localhost/m2.mgr --timeout 1", 1),
        ("rtmgr /localhost/m2.mgr -r --timeout 1", 1),
        ("rtmgr status m2 --timeout 1", 1),
        ("rtdoc /localhost/m2.mgr/X.rtc --timeout 1", 1),
        ("rttop -n 1 --timeout 1", 0),
        ("rtwatch -t 1 /", 1),
    ],
)
def test_silence_is_told(stopped: Any, line: str, status: int) -> None:
    began = time.monotonic()
    found, out, err = stopped.run(line)
    assert (found, SILENT in out + err) == (status, True)
    assert time.monotonic() - began < 9.0  # the usual time-out is 10 s


def test_a_listing_of_all_waits_less_for_others_than_for_the_one_that_is_asked(
    stopped: Any,
) -> None:
    assert "m2.mgr was not listed" in (told := stopped.run("rtls -R / --timeout 2").err)
    assert "does not answer within 0.8 s" in told
