"""Events about one component, found in the last events of a manager."""

from __future__ import annotations

import json

import pytest
from fake_manager import FakeManager

from rtkit.deployment import actions as act
from rtkit.deployment.batch import Batch
from rtkit.deployment.facts import ComponentFacts
from rtkit.errors import Malformed
from rtkit.manager.core import events as ev
from rtkit.manager.core.event_ring import EventRing
from rtkit.manager.core.history import PastEvent, history, to_text
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, Transition
from rtkit.rtc.profiles import ConnectorProfile, ExecutionContextProfile, PortRef, TypeProfile
from rtkit.rtc.serde import encode


def reported(state: LifeCycleState, cause: str = "", key: int = 1, instance: str = "A0"):
    context = ExecutionContextProfile("0", ExecutionKind.PERIODIC, 10.0, instance, state=state)
    facts = ComponentFacts(instance, TypeProfile("A"), "", contexts=(context,), cause=cause)
    return ev.ContainerReported(key, {"facts": encode(facts)})


def asked(*actions: act.Action) -> ev.BatchRequested:
    return ev.BatchRequested(Batch(actions, True, 1.0), 0)


def words(*items: ev.Event) -> list[tuple[str, str, str]]:
    found = list(history(((float(at), item) for at, item in enumerate(items)), "A0"))
    assert [each.at for each in found] == sorted(each.at for each in found)
    return [each[1:] for each in found]


WIRE = ConnectorProfile("id", "w", (PortRef("A0", "out"), PortRef("B", "in")))
OTHER = ConnectorProfile("id2", "w", (PortRef("C", "out"), PortRef("B", "in")))


def test_a_life():
    assert words(
        asked(act.Create("A?x=1&instance_name=A0"), act.Create("A?instance_name=A01")),
        reported(LifeCycleState.INACTIVE),
        reported(LifeCycleState.ACTIVE, instance="A01"),
        asked(act.Connect(WIRE), act.Connect(OTHER)),
        asked(act.ChangeState("A0", "0", Transition.ACTIVATE)),
        reported(LifeCycleState.ACTIVE),
        reported(LifeCycleState.ERROR, "ValueError: x (A.py:1 in on_execute)"),
        ev.SlaveEnded(2, "signal 9"),
        ev.SlaveEnded(1, "signal 11 at A.py:2 in f"),
        reported(LifeCycleState.ACTIVE, key=3),
        ev.ContainerReported(3, {"gone": "A0"}),
    ) == [
        ("ASKED", "", "create A?x=1&instance_name=A0"),
        ("APPEARED", "", "A"),
        ("ASKED", "", "connect A0:out B:in"),
        ("ASKED", "", "activate in 0"),
        ("ACTIVE", "0", ""),
        ("ERROR", "0", "ValueError: x (A.py:1 in on_execute)"),
        ("ZOMBIE", "", "signal 11 at A.py:2 in f"),
        ("APPEARED", "", "A"),
        ("ACTIVE", "0", ""),
        ("VANISHED", "", ""),
    ]


def test_what_changed_in_a_profile_is_told_with_its_composite():
    def member_of(composite: str) -> ev.Event:
        facts = ComponentFacts("A0", TypeProfile("A"), "", composite=composite)
        return ev.ContainerReported(1, {"facts": encode(facts)})

    assert words(member_of(""), member_of("Both"), member_of(""))[1:] == [
        ("COMPONENT_PROFILE", "composite", "Both"),
        ("COMPONENT_PROFILE", "composite", ""),
    ]


@pytest.mark.parametrize(
    ("event", "told"),
    [
        (ev.SlaveStopped(1, True), ("NOT_ANSWERING", "", "stopped")),
        (ev.SlaveStopped(1, False), ("ANSWERS", "", "stopped")),
        (ev.SlaveStopped(2, True), None),
        (ev.CallbackStuck(1, "A0", "stuck in f", True), ("NOT_ANSWERING", "", "stuck in f")),
        (ev.CallbackStuck(1, "B", "stuck in f", True), None),
        (asked(act.SetParameters("A0", "s", {"a": "1"})), ("ASKED", "", "set s: a=1")),
        (asked(act.ActivateSet("A0", "s")), ("ASKED", "", "activate set s")),
        (asked(act.SetRate("A0", "0", 5.0)), ("ASKED", "", "rate 5 Hz in 0")),
        (
            asked(act.SetContext("A0", "0", {"priority": "9"})),
            ("ASKED", "", "context 0: priority=9"),
        ),
        (asked(act.Delete("A0")), ("ASKED", "", "exit")),
        (asked(act.Delete("B")), None),
        (asked(act.Tick("A0", "0")), None),
        (ev.ContainerReported(1, {"facts": {"instance": "A0"}}), None),
        (ev.ContainerReported(1, {"facts": 3}), None),
    ],
)
def test_what_happens_to_a_living_one(event, told):
    assert words(reported(LifeCycleState.INACTIVE), event)[1:] == ([told] if told else [])


def test_events_are_dated():
    text = to_text([PastEvent(99.5, "ACTIVE", "0", "x")], 100.0, 1000.0)
    assert json.loads(text) == [[999.5, "ACTIVE", "0", "x"]]


def test_the_ring_gives_what_may_be_about_an_instance():
    ring = EventRing(FakeManager().shell.core)
    both = [reported(LifeCycleState.ACTIVE), reported(LifeCycleState.ACTIVE, instance="B")]
    for at, event in enumerate((*both, ev.SlaveEnded(1, "signal 9"))):
        ring.record(event, float(at))
    items = ring.about("A0")
    ring.record(ev.SlaveEnded(1, "signal 10"), 9.0)  # later: the events were captured
    assert [each.event for each in history(items(), "A0")] == ["APPEARED", "ACTIVE", "ZOMBIE"]


def test_rubbish_from_a_process_is_passed_over():
    with pytest.raises(Malformed):
        FakeManager().shell.core.handle(ev.ContainerReported(0, {"facts": {}}), 0.0)
    assert words(ev.ContainerReported(0, {"facts": {}})) == []
