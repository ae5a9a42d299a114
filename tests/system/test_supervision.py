"""Real ends of real processes, answered as their policies say."""

from __future__ import annotations

import os
import re
import signal
from functools import partial
from pathlib import Path
from typing import Any

import jsonrecords
from waiting import facts_of, until

from rtkit.deployment.actions import ChangeState, Connect, Create, SetParameters
from rtkit.resources import resource
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree

KEEPS_MANAGER = True
MANAGER = "/localhost/manager.mgr"
SYSTEM = resource("profiles", "systems", "sensor-controller-motor.xml")
FRAIL = '''
import os
from rtkit.component import Component


class Frail(Component):
    """Raises in its first life when it is executed, and whenever it is made where `bad` lies."""

    rate = 100.0

    def on_initialize(self):
        if os.path.exists(os.environ["RTKIT_STATE_DIR"] + "/bad"):
            raise ValueError("bad")

    def on_execute(self, context):
        path = os.environ["RTKIT_STATE_DIR"] + "/lived"
        if not os.path.exists(path):
            open(path, "w").close()
            raise ValueError("first life")


def FrailInit(manager):
    manager.register_factory(Frail)
'''


def all_states(tree: Tree) -> set[str]:
    return {each.state for each in tree.snapshot().components}


def kill(tree: Tree, slave: str) -> None:
    (pid,) = (each.pid for each in tree.snapshot().processes if each.name == slave)
    os.kill(pid, signal.SIGKILL)


def has_restarts(tree: Tree, instance: str, count: int) -> bool:
    told = facts_of(tree, instance)
    is_over = not told.zombie and not told.restart_status.returning
    return is_over and told.restart_status.restarts == count


def is_at_work(tree: Tree, instance: str, restarts: int) -> bool:
    told = tree.snapshot().component(instance)  # none while it is made again in its place
    if told is None:
        return False
    is_over = (
        not told.zombie
        and told.restart_status.restarts == restarts
        and not told.restart_status.returning
    )
    return is_over and told.state == "Active"


def apply(tree: Tree, *actions: Any) -> None:
    for result in tree.apply(actions):
        result.raise_for_error()


def test_a_killed_slave_is_back_as_it_was(manager: Any, tree: Tree) -> None:
    """Connected, configured, active; others are untouched, and it is told how often and why.

    By what watches as it happens, and by the next manager, too.
    """
    ends = (PortRef("S", "distance"), PortRef("C", "distance"))
    apply(
        tree,
        Create("Sensor?instance_name=S&manager_name=s"),
        Create("Controller?instance_name=C&manager_name=c&rtkit.restart=on-failure"),
        Connect(ConnectorProfile("wire", "wire", ends)),
        SetParameters("C", "default", {"gain": "2.5"}),
        ChangeState("S", "0", Transition.ACTIVATE),
        ChangeState("C", "0", Transition.ACTIVATE),
    )
    other = next(each for each in tree.snapshot().processes if each.name == "s")
    watching = manager.open("rtwatch --json -v -f SUPERVISION -n 4 /localhost/C.rtc")
    assert "listening" in watching.stderr.readline()
    for count in (1, 2):
        kill(tree, "c")
        until(partial(is_at_work, tree, "C", count), f"restart {count}")
        told = facts_of(tree, "C")
        assert told.sets["default"]["gain"] == "2.5"
        assert [wire.connector_id for wire in tree.snapshot().connectors] == ["wire"]
    assert next(each for each in tree.snapshot().processes if each.name == "s") == other
    shown = manager.ok("rtls -l /localhost/C.rtc")
    assert "(made again 2 times, for signal 9)" in shown
    assert re.search(
        r"Restarts +made again 2 times, for signal 9", manager.ok("rtcat /localhost/C.rtc")
    )
    told = jsonrecords.checked(manager.end_of(watching).out)
    assert [each["event"] for each in told] == ["RETURNING", "MADE_AGAIN"] * 2
    assert [each["restart"]["count"] for each in told[1::2]] == [1, 2]
    os.kill(tree.snapshot().pid, signal.SIGKILL)
    manager.ok("rtmgr start")
    (entry,) = jsonrecords.checked(manager.ok("rtls --json /localhost/C.rtc"))
    assert (entry["restarts"], entry["restarted_for"]) == (2, "signal 9")
    assert "(made again 2 times, for signal 9)" in manager.ok("rtls -l /localhost/C.rtc")
    manager.ok("rtexit /localhost/C.rtc")
    assert "C.rtc" not in manager.ok("rtls /localhost")


def test_error_is_answered_in_place_and_who_fails_always_is_given_up(
    manager: Any, tree: Tree
) -> None:
    (manager.modules / "Frail.py").write_text(FRAIL)
    options = "&rtkit.restart=on-failure&rtkit.restart.delay=0.01"
    apply(
        tree,
        Create(f"Frail?instance_name=F&manager_name=f{options}"),
        ChangeState("F", "0", Transition.ACTIVATE),
    )
    before = next(each.pid for each in tree.snapshot().processes if each.name == "f")
    until(partial(is_at_work, tree, "F", 1), "its second life")
    told = facts_of(tree, "F")
    assert "first life" in told.restart_status.why
    assert next(each.pid for each in tree.snapshot().processes if each.name == "f") == before
    bad = Path(manager.environment["RTKIT_STATE_DIR"]) / "bad"
    bad.touch()
    kill(tree, "f")
    until(lambda: "given up" in facts_of(tree, "F").zombie, "the end of patience")
    assert "given up after 5 restarts within 60 s" in manager.ok("rtls -l /localhost")
    bad.unlink()
    apply(tree, Create(f"Frail?instance_name=F&manager_name=f{options}"))
    assert facts_of(tree, "F").state == "Inactive"


def test_a_profile_says_what_is_made_again(manager: Any, tree: Tree) -> None:
    """Nonsense in it is refused with its line; what is critical stops the rest.

    After a restart there is nothing that a plan would do.
    """
    text = Path(SYSTEM).read_text()
    mark = 'value="Motor?manager_name=motor&amp;instance_name=Motor0"/>'
    assert mark in text
    said = '\n      <rtsExt:Properties rtsExt:name="{}" rtsExt:value="{}"/>'
    good = manager.folder / "good.xml"
    policy = said.format("rtkit.restart", "always") + said.format("rtkit.critical", "yes")
    good.write_text(text.replace(mark, mark + policy))
    bad = manager.folder / "bad.xml"
    bad.write_text(text.replace(mark, mark + said.format("rtkit.restart", "now and then")))
    status, _, err = manager.run(f"rtresurrect {bad}")
    assert status == 1
    assert re.search(r"bad\.xml:\d+: .*not one of never, on-failure, always: now and then", err)
    assert not tree.snapshot().components
    manager.ok(f"rtresurrect {good}")
    assert manager.run(f"rtstart {good}").status == 0
    assert all_states(tree) == {"Active"}
    manager.ok(f"rtmgr {MANAGER} -s manager.restart=on-failure")
    kill(tree, "controller")
    until(partial(is_at_work, tree, "Controller0", 1), "the controller")
    assert manager.run(f"rtplan --detailed-exitcode --state active {good}").status == 0
    kill(tree, "motor")
    until(lambda: has_restarts(tree, "Motor0", 1), "the motor")
    until(
        lambda: {each.state for each in tree.snapshot().components} == {"Inactive"},
        "the standstill",
    )
    manager.ok("rtcryo -o saved.xml")
    assert "rtkit.critical" in (manager.folder / "saved.xml").read_text()


def test_what_the_manager_says_holds_for_all(manager: Any, tree: Tree) -> None:
    manager.ok(f"rtmgr {MANAGER} -s manager.restart=always -s manager.restart.t=never")
    bad = manager.run(f"rtmgr {MANAGER} -s manager.restart=perhaps")
    assert "not one of never, on-failure, always: perhaps" in bad.err
    apply(
        tree,
        Create("ConsoleIn?instance_name=A&manager_name=s"),
        Create("ConsoleIn?instance_name=B&manager_name=t"),
    )
    for slave in "st":
        kill(tree, slave)
    until(lambda: has_restarts(tree, "A", 1), "A")
    assert facts_of(tree, "B").zombie == "signal 9"


SICK = '''
import os
import time
from rtkit.component import Component, OutPort, TimedLong


class Sick(Component):
    """Writes 100 values a second until the file `sick` lies there: then none, or it hangs."""

    rate = 100.0
    out = OutPort(TimedLong)

    def on_execute(self, context):
        path = os.environ["RTKIT_STATE_DIR"] + "/sick"
        if not os.path.exists(path):
            self.out.write(TimedLong())
        elif self.options.get("hangs"):
            os.unlink(path)
            time.sleep(1000)


def SickInit(manager):
    manager.register_factory(Sick)
'''


def test_who_is_not_well_is_shown_or_made_again(manager: Any, tree: Tree) -> None:
    (manager.modules / "Sick.py").write_text(SICK)
    sick = Path(manager.environment["RTKIT_STATE_DIR"]) / "sick"
    apply(
        tree,
        Create("Sick?instance_name=A&manager_name=a&rtkit.health.rate.out=10-1000:degrade"),
        ChangeState("A", "0", Transition.ACTIVATE),
    )
    sick.touch()
    until(lambda: "out carries" in facts_of(tree, "A").restart_status.degraded, "a low rate")
    assert "(degraded: out carries" in manager.ok("rtls -l /localhost/A.rtc")
    sick.unlink()
    until(lambda: not facts_of(tree, "A").restart_status.degraded, "the usual rate")
    stuck = "&hangs=1&rtkit.health.stuck=0.2:restart"
    apply(
        tree,
        Create(f"Sick?instance_name=B&manager_name=b{stuck}"),
        ChangeState("B", "0", Transition.ACTIVATE),
    )
    sick.touch()
    until(partial(is_at_work, tree, "B", 1), "the end of a callback that hangs")
    assert facts_of(tree, "B").restart_status.why.startswith("B was stuck in on_execute since ")
