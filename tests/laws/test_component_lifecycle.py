"""Laws of the life cycle: whatever is asked in whatever order, the invariants hold."""

from __future__ import annotations

import itertools

from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from rtkit.component import Component, Parameter
from rtkit.component.contexts.lifecycle import TABLE, LifeCycleEvent
from rtkit.component.contexts.period import NANOSECONDS, Period
from rtkit.rtc.enums import LifeCycleState, ReturnCode, Transition

FAILING = ["", "on_activated", "on_execute", "on_state_update", "on_deactivated", "on_reset"]
FAILING += ["on_aborting", "on_error", "on_rate_changed"]


class Probe(Component):
    """Notes its calls and fails where it is told to."""

    gain = Parameter(0)

    def __init__(self, instance):
        super().__init__(instance)
        self.calls = []
        self.failing = ""
        self.report = lambda text: None

    def _note(self, name):
        self.calls.append((name, self.gain))
        if name == self.failing:
            raise RuntimeError(name)

    def on_activated(self, context):
        self._note("on_activated")

    def on_deactivated(self, context):
        self._note("on_deactivated")

    def on_aborting(self, context):
        self._note("on_aborting")

    def on_error(self, context):
        self._note("on_error")

    def on_reset(self, context):
        self._note("on_reset")

    def on_execute(self, context):
        self._note("on_execute")

    def on_state_update(self, context):
        self._note("on_state_update")

    def on_rate_changed(self, context):
        self._note("on_rate_changed")


# Which callback may follow which, for one component in one context; "" is the beginning.
INACTIVE_NEXT = {"on_activated"}
ACTIVE_NEXT = {"on_execute", "on_state_update", "on_deactivated", "on_aborting"}
ERROR_NEXT = {"on_error", "on_reset"}
FOLLOWERS = {
    "": INACTIVE_NEXT,
    "on_activated": ACTIVE_NEXT,
    "on_execute": {"on_state_update", "on_aborting"},
    "on_state_update": ACTIVE_NEXT,
    "on_deactivated": INACTIVE_NEXT,
    "on_aborting": ERROR_NEXT,
    "on_error": ERROR_NEXT,
    "on_reset": ERROR_NEXT | INACTIVE_NEXT,
}


class LifeCycleMachine(RuleBasedStateMachine):
    def __init__(self):
        super().__init__()
        self.probes = [Probe("Probe0"), Probe("Probe1")]
        for probe in self.probes:
            probe.initialize()
        (self.context,) = self.probes[0].contexts.values()
        self.context.add_component(self.probes[1])
        self.asked = self.answered = 0
        self.told = {}
        self.context.changed = self.hear

    def hear(self, component):
        before = self.told.get(component, LifeCycleState.INACTIVE)
        now = self.told[component] = self.context.state_of(component)
        assert now is before or now in TABLE[before].values()

    @rule(who=st.integers(0, 1), what=st.sampled_from(Transition))
    def ask(self, who, what):
        self.asked += 1
        self.context.request(self.probes[who], what, self.answer)

    def answer(self, code, why):
        self.answered += 1
        assert isinstance(code, ReturnCode)
        if code is ReturnCode.OK:
            # A component rests whatever its callback does; the failure is told beside the success.
            assert not why or why.startswith("on_deactivated failed: ")
        else:
            assert why

    @rule(who=st.integers(0, 1), where=st.sampled_from(FAILING))
    def fail(self, who, where):
        self.probes[who].failing = where

    @rule(who=st.integers(0, 1), value=st.integers(0, 9))
    def configure(self, who, value):
        self.probes[who].configuration.set("default", {"gain": str(value)})
        self.probes[who].configuration.activate("default")

    @rule(rate=st.sampled_from([0.0, 5.0]))
    def change_rate(self, rate):
        self.context.set_rate(rate)

    @rule()
    def tick(self):
        was_idle = self.context.is_idle
        before = [(len(p.calls), self.context.state_of(p)) for p in self.probes]
        marks = [len(p.calls) for p in self.probes]
        self.context.tick()
        if was_idle:
            assert before == [(len(p.calls), self.context.state_of(p)) for p in self.probes]
        assert self.answered == self.asked
        for probe, mark in zip(self.probes, marks, strict=True):
            cycle = [c for c in probe.calls[mark:] if c[0] in ("on_execute", "on_state_update")]
            assert len({gain for _, gain in cycle}) <= 1
            assert [name for name, _ in cycle] in (
                [],
                ["on_execute"],
                ["on_execute", "on_state_update"],
            )

    @rule()
    def pause(self):
        assert self.context.stop() is ReturnCode.OK
        assert self.answered == self.asked
        self.context.tick()
        assert self.context.start() is ReturnCode.OK

    @invariant()
    def states_are_told_and_causes_kept(self):
        for probe in self.probes:
            state = self.context.state_of(probe)
            assert self.told.get(probe, LifeCycleState.INACTIVE) is state
            assert state is not LifeCycleState.CREATED
            assert bool(probe.cause) == (state is LifeCycleState.ERROR)

    @invariant()
    def callbacks_come_in_an_order_that_the_table_allows(self):
        for probe in self.probes:
            last = ""
            for name, _ in probe.calls:
                if name == "on_rate_changed":
                    continue
                # A rate that the component cannot take puts it into Error from Inactive too.
                assert name in FOLLOWERS[last] or name == "on_aborting", (last, name)
                last = name


LifeCycleMachine.TestCase.settings = settings(max_examples=80, stateful_step_count=40)
TestLifeCycle = LifeCycleMachine.TestCase


def test_every_state_can_be_reached_and_left():
    reached, frontier = set(), {LifeCycleState.CREATED}
    while frontier:
        reached |= frontier
        frontier = {new for old in frontier for new in TABLE[old].values()} - reached
    assert reached == set(LifeCycleState)
    assert {event for row in TABLE.values() for event in row} == set(LifeCycleEvent)


@given(
    rate=st.floats(0.1, 10_000),
    lasting=st.lists(st.integers(0, 3 * NANOSECONDS), min_size=1, max_size=60),
)
def test_deadlines_stay_on_the_grid_and_never_burst(rate, lasting):
    start = 1_000_000_007
    period = Period(rate, start)
    now = start
    deadlines = [period.deadline_ns]
    for last in lasting:
        now = max(now, period.deadline_ns) + last
        deadlines.append(period.advance(now))
        assert deadlines[-1] >= now
        steps = (deadlines[-1] - start) * rate / NANOSECONDS
        assert abs(steps - round(steps)) <= 1e-6 * max(1.0, steps) + rate / NANOSECONDS
    assert all(a < b for a, b in itertools.pairwise(deadlines))
    due = round((deadlines[-1] - start) * rate / NANOSECONDS)
    assert due == len(lasting) + period.skipped
