"""rtdoctor at managers and slaves that are stopped, hung, and killed."""

from __future__ import annotations

import json
import os
import signal
from typing import Any

import jsonrecords
from waiting import told_pid


def errors(shell: Any) -> list[tuple[str, str]]:
    done = shell.run("rtdoctor --json")
    found = [each for each in jsonrecords.checked(done.out) if each["severity"] == "error"]
    assert (done.status, done.err) == (1 if found else 0, "")
    return [(each["check"], each["cure"]) for each in found]


def test_everything_that_can_be_wrong_is_named_with_its_cure(manager: Any) -> None:
    manager.ok("rtmgr localhost/manager.mgr -c ConsoleIn -c ConsoleOut?manager_name=s")
    assert errors(manager) == []
    pid = json.loads(manager.ok("rtmgr status --json"))["pid"]
    os.kill(pid, signal.SIGSTOP)
    try:
        assert errors(manager) == [("managers", f"kill -CONT {pid}")]
    finally:
        os.kill(pid, signal.SIGCONT)
    os.kill(told_pid(manager, "s"), signal.SIGKILL)
    manager.ok("rtwait /localhost/ConsoleIn0.rtc inactive")
    while ("components", zombie()) not in (found := errors(manager)):
        assert "slaves" not in dict(found)
    os.kill(pid, signal.SIGKILL)
    while (found := errors(manager)) and found[0][0] != "remains":
        assert found[0][0] in ("slaves", "components", "managers")
    (left,) = found
    assert "rtmgr stop manager" in left[1]


def zombie() -> str:
    return "rtdel -z /localhost/ConsoleOut0.rtc, or rtresurrect makes it again"
