"""Commands at a manager that hangs: each ends, within its time-out, and says why."""

from __future__ import annotations

import json
import os
import signal
from typing import Any

import jsonrecords

IN0 = "/localhost/ConsoleIn0.rtc"
LINES = (
    "rtls --timeout 0.5 /localhost",
    "rtfind --timeout 0.5 /localhost",
    f"rtcat --timeout 0.5 {IN0}",
    f"rtconf --timeout 0.5 {IN0}",
    f"rtact --timeout 0.5 {IN0}",
    f"rtdoc --timeout 0.5 {IN0}",
    "rtcryo --timeout 0.5",
    "rtstodot --timeout 0.5 --live",
    "rtmgr --timeout 0.5 status",
    f"rtprint -t 0.5 {IN0}:out",
    f"rtlog -t 0.5 -f x.mcap {IN0}:out",
    f"rtwait -t 0.5 {IN0}",
)


def test_a_manager_that_hangs_holds_no_command_up(manager: Any) -> None:
    manager.ok("rtmgr localhost/manager.mgr -c ConsoleIn")
    pid = json.loads(manager.ok("rtmgr status --json"))["pid"]
    os.kill(pid, signal.SIGSTOP)
    try:
        running = {line: manager.open(line) for line in (*LINES, f"rtwait --json -t 0.5 {IN0}")}
        ended = {line: process.communicate(timeout=40) for line, process in running.items()}
    finally:
        os.kill(pid, signal.SIGCONT)
    for line in LINES:
        assert running[line].returncode == 1, line
        assert "does not answer within" in ended[line][1], (line, ended[line])
    (goal,) = jsonrecords.checked(ended[f"rtwait --json -t 0.5 {IN0}"][0])
    assert "does not answer within" in goal["problem"]
