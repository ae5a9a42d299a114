"""Composites: who drives whom, which ports are shown, states together, nested and undone."""

from __future__ import annotations

import pytest

from rtkit.component import Component, InPort, OutPort, TimedLong
from rtkit.component.composite import (
    GroupingComposite,
    PeriodicECSharedComposite,
    PeriodicStateSharedComposite,
)
from rtkit.component.describe import describe
from rtkit.errors import NotFound, Refused
from rtkit.rtc.enums import LifeCycleState, ReturnCode, Transition

ACTIVE, INACTIVE, ERROR = LifeCycleState.ACTIVE, LifeCycleState.INACTIVE, LifeCycleState.ERROR


class Part(Component):
    """Notes what is called."""

    into = InPort(TimedLong)
    out = OutPort(TimedLong)
    notes: list

    fail = ""

    def _note(self, what):
        self.notes.append(f"{self.instance} {what}")
        if self.fail == what:
            raise ValueError(what)

    def on_activated(self, context):
        self._note("activated")

    def on_deactivated(self, context):
        self._note("deactivated")

    def on_execute(self, context):
        self._note("execute")


class House:
    """The components of one process, with contexts that serve what is asked at once."""

    def __init__(self):
        self.components = {}
        self.notes = []

    def make(self, cls, instance, **options):
        made = cls(instance, options)
        made.notes = self.notes
        made.report = self.notes.append
        made.initialize()
        self.components[instance] = made
        for context in made.contexts.values():
            context.wake = context.serve_requests
        if hasattr(made, "arrange"):
            made.resolve = self.find
            assert self.arrange(made) is None
        return made

    def find(self, instance):
        if instance not in self.components:
            raise NotFound(f"no component named {instance}")
        return self.components[instance]

    def arrange(self, composite):
        outcomes = []
        composite.arrange(outcomes.append)
        (outcome,) = outcomes
        return outcome

    def set(self, composite, **values):
        composite.configuration.set("default", values)
        composite.configuration.activate("default")
        composite.configuration.update()
        return self.arrange(composite)

    def states(self, composite):
        return {
            each.instance: composite.driver.state_of(each) for each in composite.driver.participants
        }


@pytest.fixture
def house():
    made = House()
    for name in ("A", "B", "C"):
        made.make(Part, name)
    return made


def test_members_are_driven_by_its_context_in_their_order(house):
    whole = house.make(PeriodicECSharedComposite, "W", members="B, A,B")
    a, b = house.find("A"), house.find("B")
    assert whole.member_components == (b, a)
    assert (a.composite, house.find("C").composite) == (whole, None)
    assert whole.contexts["0"].participants == (whole, b, a)
    assert not a.contexts["0"].is_running
    assert house.find("C").contexts["0"].is_running
    whole.driver.activate_component(whole)
    whole.driver.tick()
    assert house.notes == ["B activated", "A activated", "B execute", "A execute"]
    assert set(house.states(whole).values()) == {ACTIVE}
    whole.driver.deactivate_component(whole)
    assert set(house.states(whole).values()) == {INACTIVE}


def test_a_member_is_not_activated_on_its_own_meanwhile(house):
    house.make(PeriodicECSharedComposite, "W", members="A")
    a = house.find("A")
    code, why = a.contexts["0"].perform(a, Transition.ACTIVATE)
    assert code is ReturnCode.PRECONDITION_NOT_MET
    assert why == "precondition not met (a member of W changes its state with that)"


def test_who_joins_while_active_comes_to_rest_first_and_works_on_in_an_active_composite(house):
    a, b = house.find("A"), house.find("B")
    a.contexts["0"].activate_component(a)
    whole = house.make(PeriodicECSharedComposite, "W", members="A")
    assert house.notes == ["A activated", "A deactivated"]
    assert house.states(whole)["A"] is INACTIVE
    whole.driver.activate_component(whole)
    house.notes.clear()
    assert house.set(whole, members="B,A") is None
    assert house.notes == ["B activated"]
    assert whole.driver.participants == (whole, b, a)


def test_who_leaves_is_driven_by_its_own_context_again(house):
    whole = house.make(PeriodicECSharedComposite, "W", members="A,B")
    whole.driver.activate_component(whole)
    house.notes.clear()
    assert house.set(whole, members="B") is None
    a = house.find("A")
    assert house.notes == ["A deactivated"]
    assert (a.composite, a.participations) == (None, (a.contexts["0"],))
    assert a.contexts["0"].is_running
    assert house.set(whole, members="") is None
    assert whole.member_components == ()
    assert whole.driver.participants == (whole,)


def test_ports_of_members_are_shown_under_their_names(house):
    whole = house.make(PeriodicECSharedComposite, "W", members="A,B", exported_ports="A.out,B.into")
    a, b = house.find("A"), house.find("B")
    assert whole.ports == {"A.out": a.out, "B.into": b.into}
    described = describe(whole)
    assert [(port.name, port.port_type.value) for port in described.ports] == [
        ("A.out", "DataOutPort"),
        ("B.into", "DataInPort"),
    ]
    assert (described.composite_type, described.members) == ("PeriodicECShared", ("A", "B"))
    assert describe(a).composite == "W"
    assert [port.name for port in describe(a).ports] == ["into", "out"]
    assert whole.is_arranged
    assert house.set(whole, exported_ports="A.into") is None
    assert list(whole.ports) == ["A.into"]
    assert house.set(whole, members="", exported_ports="") is None
    assert whole.ports == {}


def test_a_shown_port_stays_the_member_s_to_listen_at(house):
    house.make(Part, "E", execution_contexts="EventDriven")
    event = house.find("E")
    whole = house.make(GroupingComposite, "W", members="E", exported_ports="E.into")
    heard = []
    event.into.listen(lambda: heard.append(True))
    whole.take_part(event.contexts["0"])
    assert event.into._listener is not None
    assert not whole.has_changes
    assert whole.read_count == 0


@pytest.mark.parametrize(
    ("values", "error", "why"),
    [
        ({"members": "A,Nobody"}, NotFound, "no component named Nobody"),
        ({"members": "A", "exported_ports": "A.none"}, NotFound, "Port not found: A.none"),
        ({"members": "A", "exported_ports": "B.out"}, NotFound, "Port not found: B.out"),
        ({"members": "W"}, Refused, "W cannot be a member of itself"),
        ({"members": "Other"}, Refused, "W cannot be a member of itself: Other"),
        ({"members": "C"}, Refused, "C is a member of Third already"),
    ],
)
def test_what_cannot_be_changes_nothing(house, values, error, why):
    whole = house.make(PeriodicECSharedComposite, "W", members="B", exported_ports="B.out")
    house.make(PeriodicECSharedComposite, "Other", members="W")
    house.make(PeriodicECSharedComposite, "Third", members="C")
    outcome = house.set(whole, **values)
    assert isinstance(outcome, error)
    assert why in str(outcome)
    assert [member.instance for member in whole.member_components] == ["B"]
    assert list(whole.ports) == ["B.out"]
    assert not whole.is_arranged


def test_without_a_context_it_drives_nobody(house):
    with pytest.raises(AssertionError, match="no execution context to drive"):
        house.make(PeriodicECSharedComposite, "W", members="A", execution_contexts="none")
    assert house.find("A").contexts["0"].is_running


def test_activation_is_of_all_or_of_none(house):
    whole = house.make(PeriodicECSharedComposite, "W", members="A,B,C")
    house.find("B").fail = "activated"
    code, why = whole.driver.perform(whole, Transition.ACTIVATE)
    assert code is ReturnCode.ERROR
    assert "member B: on_activated failed: ValueError: activated" in why
    assert house.states(whole) == {"W": ERROR, "A": INACTIVE, "B": ERROR, "C": INACTIVE}
    assert house.notes == ["A activated", "B activated", "A deactivated"]
    house.find("B").fail = ""
    assert whole.driver.perform(whole, Transition.RESET) == (ReturnCode.OK, "")
    assert set(house.states(whole).values()) == {INACTIVE}
    assert whole.cause == ""


def test_a_member_that_fails_is_reset_with_the_composite_and_works_on(house):
    whole = house.make(PeriodicECSharedComposite, "W", members="A,B")
    whole.driver.activate_component(whole)
    house.find("A").fail = "execute"
    whole.driver.tick()
    assert house.states(whole) == {"W": ACTIVE, "A": ERROR, "B": ACTIVE}
    house.find("A").fail = ""
    house.notes.clear()
    assert whole.driver.perform(whole, Transition.RESET) == (ReturnCode.OK, "")
    assert house.notes == ["A activated"]
    assert set(house.states(whole).values()) == {ACTIVE}


def test_with_shared_state_all_leave_their_work_when_one_fails(house):
    whole = house.make(PeriodicStateSharedComposite, "W", members="A,B")
    whole.driver.activate_component(whole)
    house.find("B").fail = "execute"
    whole.driver.tick()
    assert house.states(whole) == {"W": ERROR, "A": INACTIVE, "B": ERROR}
    assert "member B is in Error: ValueError: execute" in whole.cause


def test_with_shared_state_a_member_may_leave_while_the_others_work(house):
    whole = house.make(PeriodicStateSharedComposite, "W", members="A,B")
    whole.driver.activate_component(whole)
    (own,) = house.find("A").contexts.values()
    own.wake = lambda: None  # its thread is busy
    whole.configuration.set("default", {"members": "B"})
    whole.configuration.activate("default")
    whole.configuration.update()
    outcomes = []
    whole.arrange(outcomes.append)
    whole.driver.tick()
    assert (house.states(whole), outcomes) == ({"W": ACTIVE, "B": ACTIVE}, [])
    own.serve_requests()
    assert outcomes == [None]
    assert whole.is_arranged


def test_a_group_leaves_contexts_and_states_alone(house):
    whole = house.make(GroupingComposite, "W", members="A,B", exported_ports="A.out")
    a = house.find("A")
    assert a.contexts["0"].is_running
    assert whole.contexts["0"].participants == (whole,)
    whole.driver.activate_component(whole)
    assert house.notes == []
    assert list(whole.ports) == ["A.out"]
    assert house.set(whole, members="", exported_ports="") is None
    assert a.composite is None


def nested(house):
    inner = house.make(PeriodicECSharedComposite, "Inner", members="A,B", exported_ports="A.out")
    outer = house.make(
        PeriodicECSharedComposite, "Outer", members="Inner,C", exported_ports="Inner.A.out"
    )
    return inner, outer


def test_nested_composites_are_driven_by_the_outermost_depth_first(house):
    inner, outer = nested(house)
    order = [each.instance for each in outer.driver.participants]
    assert order == ["Outer", "Inner", "A", "B", "C"]
    assert inner.driver is outer.driver is outer.contexts["0"]
    assert not inner.contexts["0"].is_running
    assert inner.contexts["0"].participants == (inner,)
    outer.driver.activate_component(outer)
    assert house.notes == ["A activated", "B activated", "C activated"]
    assert set(house.states(outer).values()) == {ACTIVE}
    assert outer.ports == {"Inner.A.out": house.find("A").out}
    outer.driver.deactivate_component(outer)
    assert set(house.states(outer).values()) == {INACTIVE}


def test_a_nested_one_that_is_changed_changes_who_the_outermost_drives(house):
    inner, outer = nested(house)
    house.make(Part, "D")
    outer.driver.activate_component(outer)
    assert house.set(inner, members="B,D", exported_ports="") is None
    order = [each.instance for each in outer.driver.participants]
    assert order == ["Outer", "Inner", "B", "D", "C"]
    assert house.states(outer)["D"] is ACTIVE
    assert outer.ports == {}, "a port that the inner one shows no more"
    assert house.find("A").contexts["0"].is_running


def test_a_nested_one_that_leaves_drives_its_members_again(house):
    inner, outer = nested(house)
    assert house.set(outer, members="C", exported_ports="") is None
    assert inner.driver is inner.contexts["0"]
    assert [each.instance for each in inner.driver.participants] == ["Inner", "A", "B"]
    assert [each.instance for each in outer.driver.participants] == ["Outer", "C"]
    inner.driver.activate_component(inner)
    assert house.states(inner) == {"Inner": ACTIVE, "A": ACTIVE, "B": ACTIVE}


def test_a_failure_deep_inside_is_reset_from_outside(house):
    _, outer = nested(house)
    outer.driver.activate_component(outer)
    house.find("B").fail = "execute"
    outer.driver.tick()
    house.find("B").fail = ""
    assert house.states(outer)["B"] is ERROR
    assert outer.driver.perform(outer, Transition.RESET) == (ReturnCode.OK, "")
    assert set(house.states(outer).values()) == {ACTIVE}


def test_one_that_ends_is_expelled_with_its_ports_and_a_composite_dissolves(house):
    inner, outer = nested(house)
    outcomes = []
    inner.expel(house.find("A"), outcomes.append)
    assert outcomes == [None]
    assert [each.instance for each in inner.member_components] == ["B"]
    assert inner.ports == {}
    assert not inner.is_arranged
    outer.dissolve(outcomes.append)
    assert outer.driver.participants == (outer,)
    assert outer.ports == {}
    for name in ("A", "C"):
        assert house.find(name).contexts["0"].is_running
