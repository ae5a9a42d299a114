"""Lockstep beside several managers, and over the end of one."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import pytest
from waiting import BOUND_S, told_pid, until

import rtkit
from rtkit.world import Lockstep, ParticipantLost

MODULE = """
import os
from rtkit.component import Component
from rtkit.world import Lockstep


class Leader(Component):
    def on_activated(self, context):
        with Lockstep("Follower0") as lockstep:
            lockstep.tick()


class Follower(Component):
    execution_type = "ExtTrigExecutionContext"

    def on_execute(self, context):
        with open(os.environ["RTKIT_STATE_DIR"] + "/cycles", "a") as cycles:
            cycles.write(self.instance + "\\n")
        gate = os.environ["RTKIT_STATE_DIR"] + "/gate"
        if os.path.exists(gate):
            open(gate).close()


def LedInit(manager):
    manager.register_factory(Leader)
    manager.register_factory(Follower)
"""


@pytest.fixture
def folder(manager: Any, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where what components note is, beside a manager."""
    for key in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
        monkeypatch.setenv(key, manager.environment[key])
    (manager.modules / "Led.py").write_text(MODULE)
    return Path(manager.environment["RTKIT_STATE_DIR"])


def test_a_component_connects_to_its_own_manager(manager: Any, folder: Path) -> None:
    manager.ok("rtmgr start second")
    with rtkit.connect("second") as tree:
        tree.load("Led.py")
        tree.activate(tree.create("Follower"))
        for place in ("", "?manager_name=far"):
            leader = tree.create(f"Leader{place}")
            tree.activate(leader)
            tree.delete(leader)
    assert (folder / "cycles").read_text() == "Follower0\n" * 2
    manager.ok("rtmgr stop second")


def test_a_tick_goes_on_with_the_next_manager(manager: Any, folder: Path) -> None:
    with rtkit.connect() as tree:
        tree.load("Led.py")
        for name in ("A", "B"):
            tree.activate(tree.create(f"Follower?instance_name={name}&manager_name=far"))
    gate = folder / "gate"
    os.mkfifo(gate)
    with Lockstep("A", "B", timeout_s=0.3) as lockstep:
        with pytest.raises(ParticipantLost, match=r"no end of a cycle within 0\.3 s"):
            lockstep.tick()
        lockstep.timeout_s = BOUND_S
        until((folder / "cycles").exists, "A has begun its cycle")
        os.kill(told_pid(manager), signal.SIGKILL)
        with pytest.raises(ParticipantLost, match="manager 'manager' ended before it answered"):
            lockstep.tick()
        with pytest.raises(ParticipantLost, match="is not running"):
            lockstep.tick()
        writer = os.open(gate, os.O_WRONLY)
        gate.unlink()
        os.close(writer)
        assert lockstep.is_under_way
        manager.ok("rtmgr start")
        lockstep.tick()
        assert not lockstep.is_under_way
    # The cycle of A was under way, so that nobody knows whether it was over.
    assert (folder / "cycles").read_text().split() == ["A", "A", "B"]
