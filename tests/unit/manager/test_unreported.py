"""Who has not come back to a manager, and what is told of them when no more is waited for."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rtkit.container.heartbeats import Heartbeats
from rtkit.container.slave_checkpoint import CheckpointWriter
from rtkit.manager.core.events import SlaveExitedUnseen, SlaveFound
from rtkit.manager.predecessor.unreported import (
    UnreportedSlaves,
    checkpoints_of_the_dead,
    living_slaves,
)

SLAVE = """
import os, sys
from rtkit.container.heartbeats import Heartbeats
from rtkit.container.slave_checkpoint import CheckpointWriter
beats = Heartbeats(f"{sys.argv[1]}/m.{os.getpid()}.beats")
CheckpointWriter(f"{sys.argv[1]}/m.{os.getpid()}.held", "s").keep("A", {"instance": "A"})
print("ready", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    return tmp_path


@pytest.fixture
def slave(folder: Path) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        [sys.executable, "-c", SLAVE, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        yield process
        process.kill()


def stop(slave: subprocess.Popen[str]) -> None:
    os.kill(slave.pid, signal.SIGSTOP)
    os.waitid(os.P_PID, slave.pid, os.WSTOPPED)


def test_the_manager_itself_is_not_waited_for(folder: Path) -> None:
    heartbeats = Heartbeats(str(folder / f"m.{os.getpid()}.beats"))
    absent = UnreportedSlaves("m", {})
    absent.look(())
    assert not absent.is_worth_waiting((), ())
    assert list(absent.settle({}, ())) == []
    del heartbeats


def test_one_that_runs_is_waited_for_until_it_is_known(slave: subprocess.Popen[str]) -> None:
    absent = UnreportedSlaves("m", checkpoints_of_the_dead("m", living_slaves("m")))
    absent.look(())
    assert absent.is_worth_waiting((), ())
    assert not absent.is_worth_waiting((), (slave.pid,))
    (told,) = absent.settle({}, ())
    assert told == SlaveFound(slave.pid, "s", [{"instance": "A"}], [], silence="does not answer")
    assert list(absent.settle({}, ())) == []


def test_one_that_is_stopped_is_not_waited_for(slave: subprocess.Popen[str]) -> None:
    stop(slave)
    absent = UnreportedSlaves("m", {})
    absent.look(())
    assert not absent.is_worth_waiting((), ())
    (told,) = absent.settle({}, ())
    assert isinstance(told, SlaveFound)
    assert told.silence == "stopped"


@pytest.mark.parametrize("when", ["before", "meanwhile"])
@pytest.mark.parametrize("why", ["signal 9", ""])
def test_one_that_died_is_told_once(slave: subprocess.Popen[str], when: str, why: str) -> None:
    if when == "before":
        slave.kill()
        slave.wait()
    absent = UnreportedSlaves("m", checkpoints_of_the_dead("m", living_slaves("m")))
    absent.look(())
    slave.kill()
    slave.wait()
    if why:
        absent.ended(slave.pid, why)
    reason = why or "exit status unknown"
    (told,) = absent.settle({}, ())
    assert told == SlaveExitedUnseen(slave.pid, "s", [{"instance": "A"}], reason, bool(why))
    absent.ended(slave.pid, "told too late")
    assert list(absent.settle({}, ())) == []


def test_a_child_of_a_zygote_that_wrote_nothing_yet_is_named_by_it(folder: Path) -> None:
    absent = UnreportedSlaves("m", {})
    absent.look(())
    children = {os.getppid(): "s", os.getpid(): ""}
    told = {each.pid: each.name for each in absent.settle(children, ())}
    assert told == {os.getppid(): "s", os.getpid(): f"slave_{os.getpid()}"}


def test_one_that_held_nothing_is_not_missed(folder: Path) -> None:
    CheckpointWriter(str(folder / "m.99999999.held"), "s")
    dead = checkpoints_of_the_dead("m", ())
    assert list(dead) == [99999999]
    assert list(UnreportedSlaves("m", dead).settle({}, ())) == []
