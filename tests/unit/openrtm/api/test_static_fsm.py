"""State machines whose states are classes: transitions, history, data, events of ports."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from rtkit.component import TimedLong
from rtkit.component.fsm import EventPort
from rtkit.errors import Refused
from rtkit.openrtm.api.event_port import EventInPort
from rtkit.openrtm.api.static_fsm import (
    FSM_SUBSTATE,
    FSM_TOPSTATE,
    Event,
    Link,
    Machine,
    State,
    deephistory,
)
from rtkit.openrtm.corba.twins import twin_of
from rtkit.openrtm.loading.names import shared_module
from rtkit.rtc.profiles import ConnectorProfile


class Noting(Link):
    """A state whose actions are noted by its component."""

    def note(self, what: str) -> None:
        self._rtComponent.notes.append(f"{type(self).__name__} {what}")


@FSM_TOPSTATE
class Top(Noting):
    class Data:
        def __init__(self) -> None:
            self.count = 0

    def onInit(self):
        self.note("init")
        self.set_state(State(Idle))

    def onEntry(self):
        self.note("entry")

    def onExit(self):
        self.note("exit")

    def go(self, *values):
        self.data(Top).count += 1
        self.note(f"go {values}")

    def stop(self):
        self.set_state(State(Idle))

    def inner(self):
        self.note("inner")

    def back(self):
        self.set_state(State(Work))

    def anew(self):
        self.set_state_direct(State(Work))


@FSM_SUBSTATE(Top)
class Idle(Noting):
    def onEntry(self):
        self.note("entry")

    def onExit(self):
        self.note("exit")

    def go(self, *values):
        self.set_state(State(Work), *values)
        self.dispatch(Event(Top.go, *values))


@deephistory
@FSM_SUBSTATE(Top)
class Work(Noting):
    def onInit(self, *values):
        self.note(f"init {values}")

    def onEntry(self):
        self.note("entry")

    def onExit(self):
        self.note("exit")

    def inner(self):
        self.set_state(State(Inner))

    def again(self):
        self.set_state(State(Work))


@FSM_SUBSTATE(Work)
class Middle(Noting):
    def later(self):
        self.defer(Event(Top.inner))
        self.set_state(State(Inner))


@FSM_SUBSTATE(Middle)
class Inner(Noting):
    def onEntry(self):
        self.note("entry")

    def inner(self):
        self.note("inner")

    def back(self):
        self.set_state(State(Middle))

    def bad(self):
        self.set_state(State(Bad))


@FSM_SUBSTATE(Top)
class Bad(Noting):
    def onEntry(self):
        self.set_state(State(Idle))


class Driven:
    """A machine, and what its states have noted."""

    def __init__(self) -> None:
        self.notes: list[str] = []
        self.machine = Machine(Top, self)

    def send(self, *names: str) -> list[str]:
        """Return what is noted of events with these names."""
        self.notes.clear()
        for name in names:
            self.machine.dispatch(Event(SimpleNamespace(__name__=name)))
        return self.notes


@pytest.fixture
def driven():
    return Driven()


def test_a_machine_begins_where_the_outermost_state_leads(driven):
    assert driven.notes == ["Top entry", "Top init", "Idle entry"]
    assert driven.machine.is_current(Top)
    assert driven.machine.is_current_direct(Idle)
    assert not driven.machine.is_current_direct(Top)
    assert driven.machine.getComp() is driven


def test_an_event_is_dispatched_again_in_the_new_state_with_its_values(driven):
    driven.notes.clear()
    driven.machine.dispatch(Event(Top.go, 1, 2))
    assert driven.notes == ["Idle exit", "Work entry", "Work init (1, 2)", "Work go (1, 2)"]
    assert driven.machine.data_of(Top).count == 1


def test_a_state_handles_what_one_within_it_does_not(driven):
    assert driven.send("inner") == ["Idle inner"]
    driven.machine.dispatch(Event(Top.go))
    assert driven.send("inner") == ["Inner entry"]
    assert driven.send("inner") == ["Inner inner"]


def test_actions_are_not_inherited_from_the_state_around(driven):
    driven.send("go", "inner")
    assert driven.machine.is_current_direct(Inner)
    assert driven.send("stop") == ["Work exit", "Idle entry"]


def test_deep_history_leads_back_to_the_innermost_state(driven):
    driven.send("go", "inner", "stop")
    assert driven.send("back") == ["Idle exit", "Work entry", "Inner entry"]
    driven.send("stop")
    assert driven.send("anew") == ["Idle exit", "Work entry", "Work init ()"]


def test_a_state_that_is_set_within_itself_is_left_and_entered(driven):
    driven.send("go")
    assert driven.send("again") == ["Work exit", "Work entry", "Work init ()"]
    driven.send("inner")
    assert driven.send("back") == []
    assert driven.machine.is_current_direct(Middle)


def test_an_event_may_wait_for_the_next_transition(driven):
    driven.send("go", "inner", "back")
    assert driven.send("later") == ["Inner entry", "Inner inner"]


def test_no_state_is_set_on_the_way(driven):
    driven.send("go", "inner")
    with pytest.raises(Refused, match="state Idle cannot be set in onEntry or onExit"):
        driven.send("bad")
    assert driven.machine.is_current_direct(Bad)
    assert driven.send("stop") == ["Idle entry"]


def test_data_is_of_the_machine(driven):
    other = Driven()
    driven.send("go")
    assert (driven.machine.data_of(Top).count, other.machine.data_of(Top).count) == (1, 0)
    state = driven.machine.object_of(Inner)
    assert state[Top] is driven.machine.object_of(Top)
    assert state.data() is state.data(Inner)
    assert state.data() is not state.data(Top)


def test_the_end_leaves_all_states_and_ignores_events(driven):
    driven.send("go", "inner")
    driven.notes.clear()
    driven.machine.shutdown()
    assert driven.notes == ["Work exit", "Top exit"]
    assert driven.send("go") == []


def test_the_names_of_another_library_are_those_of_this_machine():
    for name in ("StaticFSM", "StaticFSM_pyfsm"):
        module = shared_module(f"OpenRTM_aist.{name}")
        assert module.Machine is Machine
    assert shared_module("OpenRTM_aist.EventPort_pyfsm").EventInPort is EventInPort


def test_events_of_a_port_are_handled_when_they_are_run(driven):
    port: Any = EventInPort("event", driven.machine)
    assert isinstance(port.port, EventPort)
    port.bindEvent0("stop", Top.stop)
    twin = twin_of(TimedLong)
    port.bindEvent1("go", Top.go, twin(None, 0))
    for name, value in (("go", TimedLong(data=7)), ("stop", b"anything")):
        port.port.open(ConnectorProfile(name, name, ()))(value)
    driven.notes.clear()
    assert driven.machine.is_current_direct(Idle)
    driven.machine.run_event()
    assert driven.notes[1] == "Work entry"
    assert "data=7" in driven.notes[2]
    assert driven.notes[-2:] == ["Work exit", "Idle entry"]
