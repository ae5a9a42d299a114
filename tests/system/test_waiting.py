"""rtwait: for managers, components, states and data that come while it waits."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import jsonrecords

EXAMPLES = Path(__file__).parents[2] / "examples" / "basic"
MOTOR = "/localhost/Motor0.rtc"


def start(shell: Any, line: str) -> Any:
    """Start a command that waits, and return when it says for what."""
    process = shell.open(f"{line} -v")
    assert process.stderr.readline()
    return process


def test_everything_comes_while_it_waits(shell: Any) -> None:
    shutil.copy(EXAMPLES / "Motor.py", shell.modules)
    waiting = start(shell, f"rtwait {MOTOR} active {MOTOR}:pose data")
    shell.ok("rtmgr start")
    shell.ok("rtmgr localhost/manager.mgr -c Motor?manager_name=s")
    assert waiting.poll() is None
    shell.ok(f"rtact {MOTOR}")
    out, _ = waiting.communicate(timeout=30)
    assert (waiting.returncode, out) == (0, "")


def test_what_is_missing_in_the_end_is_told(manager: Any) -> None:
    shutil.copy(EXAMPLES / "Motor.py", manager.modules)
    manager.ok("rtmgr localhost/manager.mgr -c Motor")
    told = manager.run(f"rtwait -t 0.2 {MOTOR} active /localhost/Arm0.rtc exists {MOTOR} gone")
    assert told == (
        1,
        "",
        f"rtwait: {MOTOR} is Inactive, not Active after 0.2 s\n"
        "rtwait: /localhost/Arm0.rtc does not exist after 0.2 s\n"
        f"rtwait: {MOTOR} still exists after 0.2 s\n",
    )
    done = manager.run(f"rtwait --json -t 0.2 {MOTOR} inactive {MOTOR} active")
    assert (done.status, done.err) == (1, "")
    assert [(each["reached"], each["problem"]) for each in jsonrecords.checked(done.out)] == [
        (True, None),
        (False, "is Inactive, not Active"),
    ]
    told = manager.run(f"rtwait -t 0.2 {MOTOR}:pose")
    assert told == (1, "", f"rtwait: {MOTOR}:pose carried no data after 0.2 s\n")


def test_a_component_goes(manager: Any) -> None:
    shutil.copy(EXAMPLES / "Motor.py", manager.modules)
    manager.ok("rtmgr localhost/manager.mgr -c Motor")
    manager.ok(f"rtwait {MOTOR} inactive")
    waiting = manager.open(f"rtwait {MOTOR} gone")
    manager.ok(f"rtexit {MOTOR}")
    assert waiting.wait(30) == 0
    waiting.communicate()


def test_no_manager(shell: Any) -> None:
    told = shell.run(f"rtwait -t 0.2 {MOTOR}")
    assert told.status == 1
    assert "is not running" in told.err


def test_what_cannot_be_waited_for(manager: Any) -> None:
    for line in ("rtwait", "rtwait active", f"rtwait {MOTOR}:pose active", f"rtwait {MOTOR} data"):
        assert manager.run(line).status == 1, line
