"""The wall clock jumps: nothing that waits or repeats notices, what is stamped follows."""

from __future__ import annotations

import json
import os
import signal
import threading
import time
from datetime import datetime
from pathlib import Path
from typing import Any

import clockkit
import pytest
from clockkit import YEAR_S, WallClock
from waiting import until

from rtkit.deployment.actions import ChangeState, Connect, Create
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree

MODULE = '''
import os, time
from rtkit.component import Component, InPort, OutPort, Time, TimedLong


class Beat(Component):
    """Write numbers; note those that come, and when that was."""

    rate = 200.0
    out = OutPort(TimedLong)
    into = InPort(TimedLong)
    number = last = 0

    def on_activated(self, context):
        if "hang" in self.options:
            open(os.environ["RTKIT_STATE_DIR"] + "/hangs", "w").close()
            time.sleep(1000)

    def on_execute(self, context):
        self.number += 1
        self.out.write(TimedLong(Time.now(), self.number))
        for value in self.into.read_all():
            if self.last not in (0, value.data - 1):
                raise ValueError(f"{value.data} came after {self.last}")
            self.last = value.data
            name = os.environ["RTKIT_STATE_DIR"] + "/" + self.instance
            with open(name + ".new", "w") as file:
                file.write(f"{value.data} {value.tm.sec} {time.monotonic()}")
            os.replace(name + ".new", name)


def BeatInit(manager):
    manager.register_factory(Beat)
'''
RATE_HZ = 200.0
BOUND_S = 30.0
WAIT_S = 0.8
JUMPS_S = {
    "an hour on": 3600,
    "an hour back": -3600,
    "ten years on": 10 * YEAR_S,
    "ten years back": -10 * YEAR_S,
}


class Came(tuple[int, int, float]):
    """The last number, its stamp [s since 1970], and when it came, monotonic [s]."""


def last(file: Path) -> Came:
    """Return what came last."""
    until(file.exists, "the first number")
    number, stamp, moment = file.read_text().split()
    return Came((int(number), int(stamp), float(moment)))


def perform(tree: Tree, *actions: Any) -> None:
    for result in tree.apply(actions):
        result.raise_for_error()


def hang(tree: Tree, ends: list[float]) -> None:
    """Wait for what never ends, and note for how long that was [s]."""
    began = time.monotonic()
    (result,) = tree.apply([ChangeState("C", "0", Transition.ACTIVATE)], timeout_s=WAIT_S)
    assert "stuck in on_activated" in result.why, result
    ends.append(time.monotonic() - began)


@pytest.mark.skipif(bool(clockkit.missing()), reason=clockkit.missing())
def test_only_stamps_follow_a_clock_that_jumps(shell: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = WallClock(shell)
    (shell.modules / "Beat.py").write_text(MODULE)
    shell.ok("rtmgr start")
    for key in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
        monkeypatch.setenv(key, shell.environment[key])
    from rtkit.tree.connect import connect

    with connect() as tree:
        ends = (PortRef("A", "out"), PortRef("B", "into"))
        perform(
            tree,
            Create("Beat?instance_name=A&manager_name=a"),
            Create("Beat?instance_name=B&manager_name=b"),
            Connect(ConnectorProfile("w", "w", ends, {"dataport.buffer.length": "10000"})),
            *(ChangeState(each, "0", Transition.ACTIVATE) for each in "BA"),
        )
        for name, ahead_s in JUMPS_S.items():
            jump(shell, tree, clock, name, ahead_s)
    assert 0 <= json.loads(shell.ok("rtmgr status --json"))["uptime_s"] < 10 * BOUND_S


def jump(shell: Any, tree: Tree, clock: WallClock, name: str, ahead_s: int) -> None:
    """Have the clock jump while somebody waits, and see what that changed."""
    file = shell.folder / "state" / "B"
    perform(tree, Create("Beat?instance_name=C&manager_name=c&hang=1"))
    waited: list[float] = []
    waiting = threading.Thread(target=hang, args=(tree, waited))
    waiting.start()
    hangs = shell.folder / "state" / "hangs"
    until(hangs.exists, "somebody who waits")
    hangs.unlink()
    began = last(file)
    clock.jump(ahead_s)
    now = until(lambda: (each := last(file))[0] > began[0] + 20 and each, f"numbers, {name}")
    waiting.join(BOUND_S)
    assert waited, f"a time-out that never ends, {name}"
    assert waited[0] >= WAIT_S
    assert abs(now[1] - time.time() - ahead_s) < BOUND_S, f"a stamp, {name}"
    # No more than the rate allows, with a margin: nothing is made up for.
    assert now[0] - began[0] < 10 * (RATE_HZ * (now[2] - began[2]) + 10), name
    rows = {row.instance: row for row in tree.listing().rows}
    assert {each: (rows[each].state, rows[each].trouble) for each in "AB"} == {
        "A": ("Active", ""),
        "B": ("Active", ""),
    }, name
    (pid,) = [process.pid for process in tree.snapshot().processes if process.name == "c"]
    os.kill(pid, signal.SIGKILL)
    until(lambda: any(row.zombie for row in tree.listing().rows), "a zombie")
    told = json.loads((shell.folder / "state" / "manager.log").read_text().splitlines()[-1])
    assert told["message"] == "C was lost: signal 9"
    logged = datetime.fromisoformat(told["time"]).timestamp()
    assert abs(logged - time.time() - ahead_s) < BOUND_S, told
