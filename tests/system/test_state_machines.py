"""Components with a state machine on real processes: moved by events, looked at, changed."""

from __future__ import annotations

from typing import Any

import pytest

from rtkit.deployment import actions as act
from rtkit.errors import NotFound, Refused
from rtkit.profile.scxml import read_scxml, write_scxml
from rtkit.resources import resource
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree

KEEPS_MANAGER = True
FILE = resource("profiles", "systems", "microwave.xml")
LISTENER = """
import os
from rtkit.component import Component, InPort, TimedLong


class Listener(Component):
    execution_type = "EventDrivenExecutionContext"
    minutes = InPort(TimedLong)

    def on_execute(self, context):
        for value in self.minutes.read_all():
            fd = os.open(os.environ["RTKIT_STATE_DIR"] + "/diary", os.O_WRONLY)
            os.write(fd, b"%d\\n" % value.data)
            os.close(fd)


def ListenerInit(manager):
    manager.register_factory(Listener)
"""


def activate(tree: Tree, instance: str) -> None:
    tree.perform(act.ChangeState(instance, "0", Transition.ACTIVATE))


def oven(tree: Tree) -> Any:
    facts = tree.snapshot().component("Microwave0")
    assert facts is not None
    return facts


def test_events_move_it_from_another_process(manager: Any, tree: Tree, notes: Any) -> None:
    (manager.modules / "Listener.py").write_text(LISTENER)
    assert manager.run(f"rtresurrect {FILE}") == (0, "", "")
    tree.perform(act.Create("Listener?instance_name=L&manager_name=oven"))
    ends = (PortRef("Microwave0", "left"), PortRef("L", "minutes"))
    tree.perform(act.Connect(ConnectorProfile("l", "l", ends)))
    for instance in ("L", "Microwave0"):
        activate(tree, instance)
    assert oven(tree).fsm_state == "Operational.Idle"
    activate(tree, "MicrowaveKeys0")
    assert notes.next(8) == ["1", "2", "2", "1", "1", "1", "1", "0"]
    tree.perform(act.ChangeState("Microwave0", "0", Transition.DEACTIVATE))
    assert oven(tree).fsm_state == "Operational.Idle"
    assert manager.ok("rtls -l /localhost/Microwave0.rtc").split()[:4] == [
        "Inactive",
        "2/2",
        "1/1",
        "1/1",
    ]


def test_structure_and_events_are_looked_at_and_changed(tree: Tree) -> None:
    tree.perform(act.Create("Microwave?instance_name=Microwave0"))
    facts = oven(tree)
    text = write_scxml("Microwave", facts.fsm_states)
    assert text.startswith("<scxml")
    assert read_scxml(text.encode()).states == facts.fsm_states
    assert facts.fsm_events["minute"] == "RTC::TimedLong"
    activate(tree, "Microwave0")
    states = {"On": {"toggle": "Off"}, "Off": {"toggle": "On"}}
    tree.perform(act.SetStructure("Microwave0", states))
    events = {"toggle": "TimedShort", "toggle2": "TimedString"}
    tree.perform(act.SetEventProfiles("Microwave0", events))
    facts = oven(tree)
    assert (facts.fsm_states, facts.fsm_state) == (states, "On")
    assert facts.fsm_events == {"toggle": "RTC::TimedShort", "toggle2": "RTC::TimedString"}
    with pytest.raises(NotFound, match="event x: no data type Nothing"):
        tree.perform(act.SetEventProfiles("Microwave0", {"x": "Nothing"}))
    with pytest.raises(ValueError, match="event go leads to no state: B"):
        tree.perform(act.SetStructure("Microwave0", {"A": {"go": "B"}}))
    assert oven(tree).fsm_states == states


def test_what_is_no_event_and_what_has_no_machine(manager: Any, tree: Tree) -> None:
    tree.perform(act.Create("Microwave?instance_name=Microwave0&manager_name=oven"))
    tree.perform(act.Create("SeqOut?instance_name=S"))
    with pytest.raises(Refused, match="S has no state machine"):
        tree.perform(act.SetStructure("S", {"A": {}}))
    port = "/localhost/Microwave0.rtc:event"
    outcome = manager.run(f"rtcon /localhost/S.rtc:Long {port}")
    assert outcome.status == 1
    assert "which event it is; say fsm_event_name=NAME" in outcome.err
    outcome = manager.run(f"rtcon -p fsm_event_name=stop /localhost/S.rtc:Short {port}")
    assert "event stop carries RTC::TimedLong, not RTC::TimedShort" in outcome.err
    manager.ok(f"rtcon -p fsm_event_name=stop /localhost/S.rtc:Long {port}")
