"""rtstatus: of what lives, of what crashed, and without any manager from the disk."""

from __future__ import annotations

import os
import signal
from typing import Any

import jsonrecords
import pytest

KEEPS_MANAGER = True

MODULE = '''
import ctypes
import os

from rtkit.component import Component, InPort, OutPort, Parameter, TimedLong


class Arm(Component):
    """Move."""

    rate = 50.0
    out = OutPort(TimedLong)
    into = InPort(TimedLong)
    how = Parameter("")

    def on_activated(self, context):
        for number in range(12):
            print("line", number)

    def on_execute(self, context):
        self.out.write(TimedLong())
        if self.how == "crash":
            print("crashes now")
            os.write(1, b"past the log\\n")
            ctypes.string_at(0)
        elif self.how == "raise":
            raise ValueError("too far")


def ArmInit(manager):
    manager.register_factory(Arm)
'''
MANAGER = "/localhost/manager.mgr"
A, B = "/localhost/A.rtc", "/localhost/B.rtc"


@pytest.fixture
def arms(manager: Any) -> Any:
    (manager.modules / "Arm.py").write_text(MODULE)
    create = "-c Arm?instance_name={}&manager_name={}&rtkit.limit.memory=500M"
    manager.ok(f"rtmgr {MANAGER} {create.format('A', 'a')} {create.format('B', 'b')}")
    manager.ok(f"rtcon {A}:out {B}:into")
    manager.ok(f"rtact {A} {B}")
    return manager


def status(arms: Any, path: str, *, is_well: bool, options: str = "--no-rates") -> Any:
    done = arms.run(f"rtstatus --json {options} {path}")
    [record] = jsonrecords.checked(done.out)
    assert record["schema"] == "rtkit.status/1"
    assert (done.status, record["is_well"]) == (0 if is_well else 1, is_well), record
    return record


def test_one_that_lives(arms: Any) -> None:
    record = status(arms, A, is_well=True, options="")
    assert (record["state"], record["why"], record["kind"]) == ("Active", "", "component")
    assert record["since"] <= record["events"][-1]["time"] or record["since"]
    [context] = record["contexts"]
    assert context["reached_hz"] > 10
    out, into = record["connections"]
    assert (out["port"], out["to"], into["to"]) == ("out", [f"{B}:into"], [])
    assert out["rate_hz"] > 10
    assert record["memory_bytes"] > 2**20
    assert record["limits"] == "memory 500 MiB"
    events = [each["event"] for each in record["events"]]
    assert events[-1] == "ACTIVE"
    assert [each["message"] for each in record["log"]] == [f"line {n}" for n in range(2, 12)]
    assert status(arms, MANAGER, is_well=True)["components"][0]["name"] == "A"
    assert status(arms, f"{MANAGER}/b.mgr", is_well=True)["components"] == [
        {"name": "B", "state": "Active", "why": "", "process": "b"}
    ]
    [shown] = jsonrecords.checked(arms.ok(f"rtcat --json {A}"))
    assert shown["since"] == record["since"]


def test_one_in_error(arms: Any) -> None:
    arms.ok(f"rtconf {A} set how raise")
    arms.ok(f"rtwait {A} error")
    record = status(arms, A, is_well=False)
    assert record["state"] == "Error"
    assert record["why"].startswith("ValueError: too far (Arm.py:")
    assert record["events"][-1]["event"] == "ERROR"
    assert not any("has changed" in each for each in record["warnings"])
    (arms.modules / "Arm.py").write_text(f"{MODULE}# new\n")
    [changed, _] = status(arms, A, is_well=False)["warnings"]
    assert changed.startswith("its code has changed since it was loaded (")
    assert f"rtreset {A} takes it out of Error" in record["warnings"]
    assert arms.run(f"rtstatus {A}").out.splitlines()[1].startswith("  State      Error since ")
    quiet = arms.run(f"rtstatus -q {A}")
    assert (quiet.status, quiet.out, quiet.err) == (1, "", "")


def is_crash(record: Any) -> None:
    """Check what is promised of one that crashed, whoever tells it."""
    assert record["state"] == "Zombie"
    assert record["why"].startswith("signal 11 at Arm.py:")
    crash = record["crash"]
    assert crash["what"].startswith("Fatal Python error: Segmentation fault at Arm.py:")
    assert "in on_execute" in crash["stack"]
    messages = [each["message"] for each in record["log"]]
    assert messages == [*(f"line {n}" for n in range(3, 12)), "crashes now"]
    assert record["output"] == ["past the log"]
    assert record["since"] >= record["log"][-1]["time"]


@pytest.mark.parametrize("is_noted", [False, True])
def test_one_that_crashed_under_a_manager_that_was_killed_since(arms: Any, is_noted: bool) -> None:
    arms.run(f"rtconf {A} set how crash")
    while arms.run(f"rtstatus -q {A}").status == 0:
        pass
    kept = [arms.folder / "state" / f"manager.desired{end}" for end in ("", "-wal")]
    while is_noted and not any(b"zombieA" in each.read_bytes() for each in kept):
        pass
    live = status(arms, A, is_well=False)
    is_crash(live)
    assert [e["event"] for e in live["events"]][-1] == "ZOMBIE"
    [told] = jsonrecords.checked(arms.ok("rtmgr --json status"))
    pidfd = os.pidfd_open(told["pid"])
    signal.pidfd_send_signal(pidfd, signal.SIGKILL)
    os.close(pidfd)
    while "not running" not in arms.run("rtmgr status").err:
        pass
    left = status(arms, A, is_well=False)
    is_crash(left)
    assert arms.run(f"rtstatus --exit-detail -q {A}") == (5, "", "")
    assert left["manager"]["is_running"] is False
    assert any("A was lost: signal 11" in each["detail"] for each in left["events"])
    other = status(arms, B, is_well=False)
    assert (other["state"], other["process"]["state"]) == ("Active", "up")
    assert status(arms, MANAGER, is_well=False)["state"] == "lost"
    nowhere = arms.run("rtstatus /localhost/C.rtc")
    assert (nowhere.status, nowhere.out) == (1, "")
    assert "No such object: /localhost/C.rtc (manager 'manager' is not running)" in nowhere.err
    if is_noted:  # else it counts as having died with its manager, and would be made again
        arms.ok("rtmgr start")
        is_crash(status(arms, A, is_well=False))
        assert status(arms, B, is_well=True)["state"] == "Active"
