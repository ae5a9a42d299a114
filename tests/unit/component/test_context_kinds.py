"""Contexts that are event-driven or ticked from outside; several at once; foreign participants."""

from __future__ import annotations

import pytest

from rtkit.component import Component, InPort, OutPort, Parameter, TimedLong
from rtkit.component.contexts.context import ExecutionContext
from rtkit.component.contexts.owned_contexts import kind_named, wanted_contexts
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, ReturnCode, Transition
from rtkit.rtc.profiles import ConnectorProfile

OK = (ReturnCode.OK, "")


class Reader(Component):
    """Reads one value in a cycle."""

    into = InPort(TimedLong)
    gain = Parameter(1)

    def __init__(self, instance, options=None):
        super().__init__(instance, options)
        self.cycles = []
        self.reads = True

    def on_execute(self, context):
        value = self.into.read() if self.reads and self.into.is_new() else None
        self.cycles.append((context, value.data if value else None))


class Writer(Component):
    """Writes."""

    out = OutPort(TimedLong)


def made(options, instance="R"):
    reader = Reader(instance, options)
    reader.initialize()
    return reader


def event_driven():
    reader = made({"execution_contexts": "EventDriven"})
    return reader, reader.contexts["0"]


def connected(reader, **properties):
    """Return what writes to the port of the reader."""
    wire = ConnectorProfile("c", "c", (), {k.replace("__", "."): v for k, v in properties.items()})
    out = OutPort(TimedLong, "out")
    out.attach("c", reader.into.open(wire, lambda sink: out.replace("c", sink)))
    reader.into.renew("c")
    return lambda number: out.write(TimedLong(data=number))


def settle(context):
    """Do what a pacer does."""
    rounds = 0
    while context.is_due:
        context.tick()
        rounds += 1
        assert rounds < 100, "it never comes to rest"


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("PeriodicExecutionContext", ExecutionKind.PERIODIC),
        ("periodic", ExecutionKind.PERIODIC),
        ("EventDrivenExecutionContext", ExecutionKind.EVENT_DRIVEN),
        ("EventDriven", ExecutionKind.EVENT_DRIVEN),
        ("ExtTrigExecutionContext", ExecutionKind.OTHER),
        ("exttrig", ExecutionKind.OTHER),
        ("SimulatorExecutionContext", ExecutionKind.OTHER),
        ("OpenHRPExecutionContext", ExecutionKind.OTHER),
    ],
)
def test_types_and_their_kinds(name, kind):
    assert kind_named(name) is kind


def test_several_contexts_with_kinds_and_rates_of_their_own():
    options = {
        "execution_contexts": "Periodic(fast), PeriodicExecutionContext(slow),ExtTrig(sim),"
        "EventDrivenExecutionContext",
        "ec.fast.rate": "500",
        "ec.PeriodicExecutionContext.rate": "2",
    }
    found = [(c.id, c.kind.value, c.rate) for c in wanted_contexts(options, 10.0)]
    assert found == [
        ("fast", "PERIODIC", 500.0),
        ("slow", "PERIODIC", 2.0),
        ("sim", "OTHER", 0.0),
        ("3", "EVENT_DRIVEN", 0.0),
    ]


def test_the_general_rate_is_for_periodic_contexts_only():
    options = {"execution_contexts": "ExtTrig,Periodic", "exec_cxt.periodic.rate": "7"}
    assert [c.rate for c in wanted_contexts(options, 10.0)] == [0.0, 7.0]


def test_active_in_one_and_inactive_in_another():
    reader = made({"execution_contexts": "ExtTrig(a),ExtTrig(b)"})
    a, b = reader.contexts.values()
    assert a.activate_component(reader) is ReturnCode.OK
    assert (a.state_of(reader), b.state_of(reader)) == (
        LifeCycleState.ACTIVE,
        LifeCycleState.INACTIVE,
    )
    for context in (a, b):
        answers = []
        context.request_tick(lambda *answer, answers=answers: answers.append(answer))
        context.serve_requests()
        assert answers == [OK]
    assert reader.cycles == [("a", None)]


def test_a_tick_comes_after_what_was_asked_before_it():
    reader = made({"execution_contexts": "ExtTrig"})
    context, order = reader.contexts["0"], []
    context.request(reader, Transition.ACTIVATE, lambda *_: order.append("active"))
    context.request_tick(lambda *_: order.append(list(reader.cycles)))
    context.request(reader, Transition.DEACTIVATE, lambda *_: order.append("inactive"))
    context.request_tick(lambda *_: order.append(list(reader.cycles)))
    context.tick()
    assert order == ["active", [("0", None)], "inactive", [("0", None)]]


def test_a_context_ticked_from_outside_does_nothing_by_itself():
    reader = made({"execution_contexts": "ExtTrig"})
    context = reader.contexts["0"]
    context.activate_component(reader)
    connected(reader)(1)
    assert not context.is_due
    for _ in range(3):
        context.tick()
    assert reader.cycles == []


def test_it_takes_settings_over_without_a_cycle():
    reader = made({"execution_contexts": "ExtTrig"})
    context = reader.contexts["0"]
    context.activate_component(reader)
    reader.configuration.set("default", {"gain": "5"})
    reader.configuration.activate("default")
    assert context.is_due
    context.tick()
    assert (reader.gain, reader.cycles) == (5, [])
    assert not context.is_due


def test_ticks_are_for_contexts_that_are_not_periodic_and_run():
    answers = []
    periodic = made({}).contexts["0"]
    periodic.request_tick(lambda *answer: answers.append(answer))
    stopped = made({"execution_contexts": "ExtTrig(x)"}).contexts["x"]
    stopped.stop()
    stopped.request_tick(lambda *answer: answers.append(answer))
    for context in (periodic, stopped):
        context.serve_requests()
    assert [code for code, _ in answers] == [
        ReturnCode.UNSUPPORTED,
        ReturnCode.PRECONDITION_NOT_MET,
    ]
    assert "is periodic" in answers[0][1]
    assert "x is not running" in answers[1][1]


def test_activation_is_an_event():
    reader, context = event_driven()
    assert not context.is_due
    context.activate_component(reader)
    settle(context)
    assert reader.cycles == [("0", None)]


def test_each_value_is_worked_on_even_if_they_come_in_one_burst():
    reader, context = event_driven()
    context.activate_component(reader)
    settle(context)
    write = connected(reader)
    reader.cycles.clear()
    for number in range(5):
        write(number)
    settle(context)
    assert reader.cycles == [("0", number) for number in range(5)]


def test_a_value_that_nobody_reads_makes_one_cycle():
    reader, context = event_driven()
    context.activate_component(reader)
    settle(context)
    write = connected(reader)
    reader.reads = False
    reader.cycles.clear()
    write(1)
    settle(context)
    assert len(reader.cycles) == 1


def test_values_that_came_before_activation_are_worked_on_after_it():
    reader, context = event_driven()
    write, woken = connected(reader), []
    context.wake = lambda: woken.append(True)
    for number in range(3):
        write(number)
    assert not woken, "a component at rest costs nothing"
    context.activate_component(reader)
    settle(context)
    assert [value for _, value in reader.cycles] == [0, 1, 2]


def test_a_value_wakes_the_pacer():
    reader, context = event_driven()
    context.activate_component(reader)
    settle(context)
    woken = []
    context.wake = lambda: woken.append(True)
    connected(reader)(1)
    assert woken == [True]
    assert not context.is_idle


def test_without_an_event_driven_context_a_value_goes_straight_to_its_buffer():
    reader = made({})
    wire = ConnectorProfile("c", "c", ())
    sink = reader.into.open(wire)
    assert type(sink).__name__ == "builtin_function_or_method"


def test_a_connector_made_before_the_component_is_attached_is_heard_too():
    reader, host = made({"execution_contexts": "none"}), Writer("W", {})
    host.initialize()
    write = connected(reader)
    write(1)
    context = ExecutionContext("e", ExecutionKind.EVENT_DRIVEN, 0.0, "W")
    context.start()
    assert context.add_component(reader) is ReturnCode.OK
    context.activate_component(reader)
    settle(context)
    write(2)
    settle(context)
    assert reader.cycles == [("W/e", 1), ("W/e", 2)]
    context.remove_component(reader)
    settle(context)
    write(3)
    assert not context.is_due
    assert reader.into.read().data == 3


def test_a_closed_connector_stays_closed_when_who_listens_changes():
    reader, context = event_driven()
    write = connected(reader)
    reader.into.close("c")
    context.remove_component(reader)
    context.add_component(reader)
    context.activate_component(reader)
    settle(context)
    assert reader.into.connectors == ()
    write(1)
    assert not reader.into.is_new()


def test_a_context_of_another_is_known_by_owner_and_id():
    guest, host = made({}, "G"), made({"execution_contexts": "Periodic(x)"}, "H")
    context = host.contexts["x"]
    told = []
    context.changed = told.append
    assert context.add_component(guest) is ReturnCode.OK
    assert told == [host, guest]
    assert [c.handle_for(guest) for c in guest.participations] == ["0", "H/x"]
    assert guest.participation("H/x") is context
    assert guest.participation("0") is guest.contexts["0"]
    with pytest.raises(NotFound, match="no part in execution context x"):
        guest.participation("x")
    assert context.profile_for(guest).id == "H/x"
    assert context.profile_for(host).id == "x"
    context.activate_component(guest)
    context.tick()
    assert guest.cycles == [("H/x", None)]
    told.clear()
    context.remove_component(guest)
    assert told == [guest, guest, host]
    assert guest.participations == (guest.contexts["0"],)


def test_who_owns_a_context_that_ends_leaves_no_guest_in_it_and_no_request_unanswered():
    guest, host = made({}, "G"), made({}, "H")
    context, done = host.contexts["0"], []
    context.add_component(guest)
    context.activate_component(guest)
    context.submit(lambda: done.append(True))
    host.finalize()
    assert guest.participations == (guest.contexts["0"],)
    assert done == [True]


def test_only_a_periodic_context_has_a_rate():
    context = made({"execution_contexts": "ExtTrig"}).contexts["0"]
    assert context.set_rate(5.0) is ReturnCode.UNSUPPORTED
    assert context.rate == 0.0


@pytest.mark.parametrize("text", ["ExtTrig(a", "ExtTrig(a),Periodic(a)"])
def test_contexts_that_cannot_be_told_apart(text):
    with pytest.raises((Malformed, Refused)):
        wanted_contexts({"execution_contexts": text}, 1.0)
