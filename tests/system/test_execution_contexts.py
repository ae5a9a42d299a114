"""Execution contexts of all kinds on real processes: what ticks when, and who drives whom."""

from __future__ import annotations

import re
from typing import Any

import pytest

from rtkit.deployment import actions as act
from rtkit.errors import NotFound, Refused, RtkitError
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree

KEEPS_MANAGER = True
DIARY = """
import os
from rtkit.component import Component, InPort, OutPort, TimedLong


class Diary(Component):
    into = InPort(TimedLong)
    out = OutPort(TimedLong)

    def note(self, *words):
        fd = os.open(os.environ["RTKIT_STATE_DIR"] + "/diary", os.O_WRONLY)
        os.write(fd, (" ".join(map(str, words)) + "\\n").encode())
        os.close(fd)

    def on_execute(self, context):
        value = self.into.read() if self.into.is_new() else None
        self.note(self.instance, context, value.data if value else "-")

    def on_deactivated(self, context):
        self.note(self.instance, context, "deactivated")


class Caller(Component):
    rate = 500.0
    out = OutPort(TimedLong)

    def on_activated(self, context):
        for number in range(3):
            self.out.write(TimedLong(data=number))


def DiaryInit(manager):
    manager.register_factory(Diary)
    manager.register_factory(Caller)
"""


@pytest.fixture
def tree(tree: Tree, manager: Any) -> Tree:
    (manager.modules / "Diary.py").write_text(DIARY)
    tree.perform(act.Load("Diary.py"))
    return tree


def make(tree: Tree, instance: str, options: str = "", type_name: str = "Diary") -> str:
    more = f"&{options}" if options else ""
    return tree.perform(act.Create(f"{type_name}?instance_name={instance}{more}"))


def change(tree: Tree, instance: str, transition: Transition, context: str = "0") -> None:
    tree.perform(act.ChangeState(instance, context, transition))


def wire(tree: Tree, one: str, other: str) -> None:
    ends = (PortRef(*one.split(".")), PortRef(*other.split(".")))
    tree.perform(act.Connect(ConnectorProfile(one + other, "w", ends)))


@pytest.mark.parametrize("place", ["", "manager_name=far"])
def test_event_driven_has_a_cycle_for_each_value_that_comes(
    tree: Tree, notes: Any, place: str
) -> None:
    make(tree, "E", "execution_contexts=EventDriven")
    make(tree, "C", place, "Caller")
    wire(tree, "C.out", "E.into")
    change(tree, "E", Transition.ACTIVATE)
    assert notes.next(1) == ["E 0 -"]
    change(tree, "C", Transition.ACTIVATE)
    assert notes.next(3) == ["E 0 0", "E 0 1", "E 0 2"]
    change(tree, "E", Transition.DEACTIVATE)
    assert notes.next(1) == ["E 0 deactivated"]
    assert notes.nothing()


def test_ticks_from_outside(tree: Tree, notes: Any) -> None:
    make(tree, "T", "execution_contexts=ExtTrig(sim),Periodic(idle)&ec.idle.rate=50")
    change(tree, "T", Transition.ACTIVATE, "sim")
    for _ in range(3):
        tree.perform(act.Tick("T", "sim"))
    assert notes.next(3) == ["T sim -"] * 3
    assert notes.nothing()
    with pytest.raises(Refused, match="idle is periodic, it ticks by itself: T"):
        tree.perform(act.Tick("T", "idle"))
    with pytest.raises(Refused, match="has no rate: its kind is OTHER"):
        tree.perform(act.SetRate("T", "sim", 5.0))
    tree.perform(act.SetRate("T", "idle", 20.0))
    facts = tree.snapshot().component("T")
    assert facts is not None
    assert [(c.id, c.kind, c.rate, c.state) for c in facts.contexts] == [
        ("sim", ExecutionKind.OTHER, 0.0, LifeCycleState.ACTIVE),
        ("idle", ExecutionKind.PERIODIC, 20.0, LifeCycleState.INACTIVE),
    ]


def test_a_participant_of_a_context_of_another(manager: Any, tree: Tree, notes: Any) -> None:
    make(tree, "Owner", "execution_contexts=ExtTrig(x)")
    make(tree, "Guest", "execution_contexts=none")
    make(tree, "Far", "manager_name=far")
    tree.perform(act.Attach("Owner", "x", "Guest"))
    shown = manager.ok("rtcat -ll /localhost/Owner.rtc")
    assert re.search(r"Kind +Other\n.*\n.*Owner +Owner\n +-Participants\n +Guest\n", shown), shown
    change(tree, "Guest", Transition.ACTIVATE, "Owner/x")
    tree.perform(act.Tick("Owner", "x"))
    tree.perform(act.Tick("Guest", "Owner/x"))
    assert notes.next(2) == ["Guest Owner/x -"] * 2
    refusals: list[tuple[type[RtkitError], str, act.Action]] = [
        (Refused, "takes part in execution context x", act.Attach("Owner", "x", "Guest")),
        (Refused, "Far is in far, Owner in manager", act.Attach("Owner", "x", "Far")),
        (Refused, "Owner owns execution context x", act.Detach("Owner", "x", "Owner")),
        (NotFound, "no execution context y", act.Attach("Owner", "y", "Guest")),
        (NotFound, "No", act.Attach("Owner", "x", "No")),
    ]
    for error, why, action in refusals:
        with pytest.raises(error, match=why):
            tree.perform(action)
    tree.perform(act.Detach("Owner", "x", "Guest"))
    assert notes.next(1) == ["Guest Owner/x deactivated"]
    with pytest.raises(NotFound, match="takes no part"):
        tree.perform(act.Detach("Owner", "x", "Guest"))
    guest = tree.snapshot().component("Guest")
    assert guest is not None
    assert guest.contexts == ()


def test_who_is_deleted_leaves_the_contexts_of_others(tree: Tree, notes: Any) -> None:
    make(tree, "Owner", "execution_contexts=ExtTrig(x)")
    for guest in ("One", "Two"):
        make(tree, guest)
        tree.perform(act.Attach("Owner", "x", guest))
        change(tree, guest, Transition.ACTIVATE, "Owner/x")
    tree.perform(act.Delete("One"))
    assert notes.next(1) == ["One Owner/x deactivated"]
    owner = tree.snapshot().component("Owner")
    assert owner is not None
    assert owner.contexts[0].participants == ("Two",)
    tree.perform(act.Delete("Owner"))
    assert notes.next(1) == ["Two Owner/x deactivated"]
    two = tree.snapshot().component("Two")
    assert two is not None
    assert [context.id for context in two.contexts] == ["0"]
