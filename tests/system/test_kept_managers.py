"""A manager that tests hand on is as new for each, or another one."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import pytest
from forked import Commands
from kept import KeptManager
from shells import Shell
from waiting import told_pid

MANAGER = "/localhost/manager.mgr"
STORE = {"manager.desired", "manager.desired-commits"}
"""What a manager has from its first commit on."""


@pytest.fixture
def kept(commands: Commands) -> Iterator[KeptManager]:
    kept = KeptManager(commands)
    yield kept
    kept.close()


def look(shell: Shell) -> list[str]:
    """Return what a test could see of one before it."""
    files = sorted({path.name for path in (shell.folder / "state").iterdir()} - STORE)
    files += sorted(path.name for path in shell.modules.iterdir())
    listed = shell.ok("rtls -lR /localhost"), shell.ok(f"rtcat {MANAGER}")
    return [*listed, *files, *sorted(shell.environment)]


def test_nothing_of_a_test_is_left(kept: KeptManager) -> None:
    shell = kept.take()
    pid, before = told_pid(shell), look(shell)
    (shell.modules / "More.py").write_text("def MoreInit(manager):\n    print('seen')\n")
    shell.ok(f"rtmgr -l More.py:MoreInit -c ConsoleIn -c ConsoleOut?manager_name=s {MANAGER}")
    shell.ok("rtcon /localhost/ConsoleIn0.rtc:out /localhost/ConsoleOut0.rtc:in")
    shell.ok(f"rtmgr -c ConsoleIn?manager_name=s -c ConsoleOut {MANAGER}")
    shell.ok("rtcon /localhost/ConsoleIn1.rtc:out /localhost/ConsoleOut1.rtc:in")
    shell.ok("rtact /localhost/ConsoleIn0.rtc /localhost/ConsoleOut0.rtc")
    shell.ok("rtcryo --all -o saved.xml")
    os.kill(told_pid(shell, "s"), signal.SIGKILL)
    shell.environment["RTKIT_MANAGER"] = "other"
    kept.give_back()
    again = kept.take()
    assert (told_pid(again), look(again)) == (pid, before)
    assert "ConsoleOut" not in again.log()


@pytest.mark.parametrize("line", [f"rtmgr -s config.version=7 {MANAGER}", "rtmgr stop"])
def test_one_that_cannot_be_as_new_is_replaced(kept: KeptManager, line: str) -> None:
    shell = kept.take()
    pid, before = told_pid(shell), look(shell)
    shell.ok(line)
    kept.give_back()
    again = kept.take()
    assert told_pid(again) != pid
    assert again is not shell
    assert len(look(again)) == len(before)
