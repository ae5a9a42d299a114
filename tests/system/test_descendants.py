"""What components in the manager's own process have started, and the end of that process."""

from __future__ import annotations

import os
import signal
from collections.abc import Set
from pathlib import Path
from typing import Any

import pytest
from waiting import until

from rtkit.link import places

MANAGER = "/localhost/manager.mgr"
STARTER = '''
import subprocess
from rtkit.component import Component


class Starter(Component):
    """Leaves a child, an orphan in a session of its own, one without environment."""

    def on_activated(self, context):
        subprocess.Popen(["sleep", "1000"], start_new_session=True)
        subprocess.Popen(["sh", "-c", "setsid sleep 1000 & exit"]).wait()
        if self.instance == "Open":
            return
        hidden = ["/usr/bin/setsid", "--fork", "sh", "-c", "/bin/sleep 1000; :"]
        subprocess.Popen(hidden, env={}).wait()


def StarterInit(manager):
    manager.register_factory(Starter)
'''


@pytest.fixture
def starter(manager: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", manager.environment["RTKIT_RUNTIME_DIR"])
    (manager.modules / "Starter.py").write_text(STARTER)
    manager.ok(f"rtmgr {MANAGER} -c Starter -c 'Starter?instance_name=S&manager_name=s'")
    return manager


def below(pid: int) -> set[int]:
    """Return what descends from a process."""
    found = set()
    for task in Path(f"/proc/{pid}/task").iterdir():
        for child in map(int, (task / "children").read_text().split()):
            found |= {child, *below(child)}
    return found


def sleepers(pids: set[int]) -> set[int]:
    found = set()
    for pid in pids:
        try:
            if Path(f"/proc/{pid}/comm").read_text() in ("sleep\n", "sh\n"):
                found.add(pid)
        except (FileNotFoundError, ProcessLookupError):
            continue
    return found


def forked(pid: int, count: int, before: Set[int] = frozenset()) -> set[int]:
    """Wait until what was forked below a process runs its programs, and return these."""
    until(lambda: len(sleepers(below(pid)) - before) >= count, f"{count} more processes")
    return sleepers(below(pid)) - before


def listed(pid: int) -> str:
    path = Path(places.runtime_dir()) / f"manager.{pid}.family"
    return path.read_text() if path.exists() else ""


@pytest.mark.parametrize("end", ["rtmgr start", "rtmgr stop"])
def test_what_they_started_ends_though_the_manager_was_killed(starter: Any, end: str) -> None:
    """And what a slave started goes on with it, until that ends."""
    starter.ok("rtact /localhost/S.rtc")
    pid = places.owner("manager")
    assert pid is not None
    of_slave = forked(pid, 4)
    starter.ok("rtact /localhost/Starter0.rtc")
    mine = forked(pid, 4, of_slave)
    assert len(mine) == len(of_slave) == 4
    until(lambda: all(str(each) in listed(pid) for each in mine), "a list of them all")
    os.kill(pid, signal.SIGKILL)
    until(lambda: places.owner("manager") is None, "the end of the manager")
    assert sleepers(mine) == mine
    starter.run(end)
    until(lambda: not sleepers(mine), "their end")
    assert not listed(pid)
    if end == "rtmgr start":
        assert sleepers(of_slave) == of_slave
        assert "had started was ended" in starter.log()
    else:
        assert not sleepers(of_slave)


def test_what_was_started_in_the_last_second_is_known_by_its_mark(starter: Any) -> None:
    """It need not have come to the list yet; only what hides from the mark must have."""
    pid = places.owner("manager")
    assert pid is not None
    starter.ok(f"rtmgr {MANAGER} -c 'Starter?instance_name=Open'")
    before = sleepers(below(pid))
    starter.ok("rtact /localhost/Open.rtc")
    marked = forked(pid, 2, before)
    assert len(marked) == 2
    os.kill(pid, signal.SIGKILL)
    (Path(places.runtime_dir()) / f"manager.{pid}.family").unlink(missing_ok=True)
    starter.ok("rtmgr start")
    until(lambda: not sleepers(marked), "their end")
