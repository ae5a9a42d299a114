"""Real slaves that use more and more, and what becomes of them and of their neighbours."""

from __future__ import annotations

import os
import re
import signal
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from waiting import facts_of, until

from rtkit.deployment.actions import ChangeState, Create
from rtkit.manager.limits.usage import tree_usage
from rtkit.resources import resource
from rtkit.rtc.enums import Transition
from rtkit.tree.client import Tree

KEEPS_MANAGER = True
SYSTEM = resource("profiles", "systems", "sensor-controller-motor.xml")
HUNGRY = '''
import os
import time
from rtkit.component import Component, Parameter


class Hungry(Component):
    """Uses more and more of what `what` says, each period."""

    rate = 100.0
    what = Parameter("nothing")

    def on_activated(self, context):
        self.kept = []

    def on_execute(self, context):
        if self.what == "memory":
            self.kept.append(bytearray(b"x") * (4 << 20))
        elif self.what == "huge":
            self.kept.append(bytearray(64 << 30))
        elif self.what == "processes":
            if not os.fork():
                os.setsid()
                time.sleep(1000)
        elif self.what == "bomb":
            while True:
                os.fork()
        elif self.what == "descriptors":
            self.kept.append(open("/dev/null"))
        elif self.what == "files":
            while True:
                self.kept.append(open("/dev/null"))
        elif self.what == "processor":
            until = time.thread_time() + 0.008
            while time.thread_time() < until:
                pass


def HungryInit(manager):
    manager.register_factory(Hungry)
'''
NEIGHBOUR = '''
import os
import time
from rtkit.component import Component


class Neighbour(Component):
    """Counts its cycles, and how many came more than half a period late."""

    rate = 100.0

    def on_activated(self, context):
        self.cycles = self.late = 0
        self.last = time.monotonic()
        self.path = os.environ["RTKIT_STATE_DIR"] + "/cycles"

    def on_execute(self, context):
        now = time.monotonic()
        self.cycles += 1
        self.late += now - self.last > 1.5 / self.rate
        self.last = now
        with open(self.path + ".new", "w") as file:
            file.write(f"{self.cycles} {self.late}")
        os.rename(self.path + ".new", self.path)


def NeighbourInit(manager):
    manager.register_factory(Neighbour)
'''
ENDS = {
    "memory": ("memory=150M", r"memory limit of 150 MiB reached \(1\d\d(\.\d)? MiB\)"),
    "huge": ("memory=150M", r"memory limit of 150 MiB reached \(MemoryError \(Hungry\.py:\d+ in "),
    "processes": ("processes=4", r"limit of 4 processes reached \(\d+\)"),
    "bomb": ("processes=4", r"limit of 4 processes reached \(\d+\)"),
    "descriptors": ("descriptors=120", r"limit of 120 descriptors reached \(1\d\d\)"),
    "files": (
        "descriptors=120",
        r"limit of 120 descriptors reached \((OSError: \[Errno 24\]|1\d\d\))",
    ),
    "processor": ("processor=5%", r"processor limit of 0\.05 reached \(\d\.\d\d over 5 s\)"),
}


def apply(tree: Tree, *actions: Any) -> None:
    for result in tree.apply(actions):
        result.raise_for_error()


@pytest.fixture
def modules(manager: Any) -> None:
    (manager.modules / "Hungry.py").write_text(HUNGRY)
    (manager.modules / "Neighbour.py").write_text(NEIGHBOUR)


def cycles(manager: Any) -> tuple[int, int]:
    path = Path(manager.environment["RTKIT_STATE_DIR"]) / "cycles"
    until(path.exists, "cycles of the neighbour")
    count, late = map(int, path.read_text().split())
    return count, late


def start(tree: Tree, what: str, limit: str, more: str = "") -> str:
    """Have something use more and more; return how it is named."""
    name = what.capitalize()
    options = f"manager_name=s_{what}&rtkit.limit.{limit}&conf.default.what={what}{more}"
    apply(tree, Create(f"Hungry?instance_name={name}&{options}"))
    tree.apply([ChangeState(name, "0", Transition.ACTIVATE)])  # its slave may have ended by then
    return name


@pytest.mark.parametrize("what", ENDS)
def test_who_reaches_a_limit_is_ended_with_that_reason_and_the_rest_goes_on(
    manager: Any, tree: Tree, modules: None, what: str
) -> None:
    """Periods of a neighbour are late about as seldom as when it was alone."""
    apply(
        tree,
        Create("Neighbour?instance_name=N&manager_name=n"),
        ChangeState("N", "0", Transition.ACTIVATE),
    )
    until(lambda: cycles(manager)[0] >= 100, "a hundred cycles")
    alone = cycles(manager)
    limit, reason = ENDS[what]
    name = start(tree, what, limit)
    until(lambda: bool(facts_of(tree, name).zombie), "its end")
    assert re.match(reason, facts_of(tree, name).zombie), facts_of(tree, name).zombie
    until(lambda: cycles(manager)[0] >= alone[0] + 100, "a hundred cycles more")
    count, late = (now - before for now, before in zip(cycles(manager), alone, strict=True))
    assert late / count <= alone[1] / alone[0] + 0.5
    assert f"*{name}.rtc  ({facts_of(tree, name).zombie})" in manager.ok(
        f"rtls -l /localhost/{name}.rtc"
    )
    doctor = manager.run("rtdoctor")
    assert f"slave s_{what} has ended: {facts_of(tree, name).zombie}" in doctor.out + doctor.err
    until(lambda: not _named(tree, f"s_{what}"), "the end of all that it started")


def _named(tree: Tree, slave: str) -> list[int]:
    """Return the processes below the manager that go by the name of a slave."""
    found = []
    for pid in tree_usage(tree.snapshot().pid).pids:
        with suppress(FileNotFoundError, ProcessLookupError):
            if slave in Path(f"/proc/{pid}/comm").read_text():
                found.append(pid)
    return found


def test_its_policy_brings_it_back_and_what_was_its_reason_is_told(
    manager: Any, tree: Tree, modules: None
) -> None:
    name = start(tree, "memory", "memory=150M", "&rtkit.restart=on-failure&rtkit.restart.limit=1")

    def is_given_up() -> bool:
        told = tree.snapshot().component(name)  # none while it is made again in its place
        return told is not None and "given up after 1 restarts" in told.zombie

    until(is_given_up, "the second end")
    told = facts_of(tree, name)
    assert told.restart_status.restarts == 1
    assert told.restart_status.why.startswith("memory limit of 150 MiB reached (")


def test_the_next_manager_keeps_slaves_within_their_limits(
    manager: Any, tree: Tree, modules: None
) -> None:
    options = "manager_name=s&rtkit.limit.memory=150M&rtkit.restart=on-failure"
    apply(
        tree,
        Create(f"Hungry?instance_name=H&{options}"),
        ChangeState("H", "0", Transition.ACTIVATE),
    )
    os.kill(tree.snapshot().pid, signal.SIGKILL)
    manager.ok("rtmgr start")
    assert "memory 150 MiB (slave s)" in manager.ok("rtcat /localhost/H.rtc")
    manager.ok("rtconf /localhost/H.rtc set what memory")
    why = "for memory limit of 150 MiB reached ("
    # For a moment, while it is made again in its place, there is none.
    until(lambda: why in manager.run("rtls -l /localhost/H.rtc").out, "its end and its return")


def test_limits_change_while_a_slave_lives(manager: Any, tree: Tree, modules: None) -> None:
    """By a plan, without a stop; one that is lowered too far ends it."""
    profile = Path(manager.environment["RTKIT_STATE_DIR"]) / "system.xml"
    manager.ok(f"rtprofile set {SYSTEM} Motor0:rtkit.limit.memory=2G -o {profile}")
    assert manager.run(f"rtapply {profile}").status == 0
    before = tree.snapshot().processes
    manager.ok(f"rtprofile set {profile} Motor0:rtkit.limit.memory=1G")
    assert manager.run(f"rtapply {profile}").status == 0
    assert tree.snapshot().processes == before
    assert "memory 1 GiB (slave motor)" in manager.ok("rtcat /localhost/Motor0.rtc")
    manager.ok(f"rtprofile set {profile} Motor0:rtkit.limit.memory=1M")
    manager.run(f"rtapply {profile}")
    until(
        lambda: "memory limit of 1 MiB" in facts_of(tree, "Motor0").zombie, "the end of its slave"
    )
    assert facts_of(tree, "Sensor0").state == "Active"


def test_a_plan_that_reserves_more_than_the_host_has_is_refused(manager: Any, tree: Tree) -> None:
    profile = Path(manager.environment["RTKIT_STATE_DIR"]) / "system.xml"
    told = "Motor0:rtkit.limit.processor=4000 Sensor0:rtkit.limit.processor=0.5"
    manager.ok(f"rtprofile set {SYSTEM} {told} -o {profile}")
    why = "rtkit.limit.processor: 4000.5 in all (Motor0 4000, Sensor0 0.5), but this host has "
    for line in ("rtplan", "rtapply", "rtresurrect"):
        outcome = manager.run(f"{line} --exit-detail {profile}")
        assert outcome.status == 7
        assert why in outcome.err
    assert why in manager.run(f"rtprofile check {profile}").out
    assert not tree.snapshot().components
