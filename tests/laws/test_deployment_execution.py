"""Whatever a plan says and whatever happens: no order and no precondition is ever violated."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from hypothesis import given, settings
from hypothesis import strategies as st

from rtkit.deployment.actions import ChangeState, Result
from rtkit.deployment.conditions import OrderTarget, StartCondition, sequence_of
from rtkit.deployment.execution import StartExecution
from rtkit.deployment.layered_plan import PlannedAction
from rtkit.deployment.start_schedule import (
    ScheduledAction,
    StartPlan,
    WatchedComponent,
    arrange,
    expected_order,
)
from rtkit.rtc.enums import ReturnCode, Transition

NO = Result(ReturnCode.ERROR, "refused", "no luck")
FAR = 1e9
PATIENCE_S = 0.5
states = st.sampled_from(["Inactive", "Active", "Error", "zombie (signal 9)", "missing"])
moments = st.integers(0, 400).map(lambda ms: ms / 1000)
transitions = st.sampled_from([Transition.ACTIVATE, Transition.DEACTIVATE])


@st.composite
def plans(draw: st.DrawFn) -> StartPlan:
    """Return a plan without circles: in some order, each waits for earlier ones only."""
    count = draw(st.integers(1, 7))
    order = draw(st.permutations(range(count)))
    times = st.sampled_from([0, 0, 1, 10, 50, 200])
    orders: dict[OrderTarget, tuple[StartCondition, ...]] = {}
    for place, number in enumerate(order):
        entries = []
        for _ in range(draw(st.integers(0, 3))):
            sequence = draw(st.integers(0, 3))
            if place and draw(st.booleans()):
                first = OrderTarget(str(order[draw(st.integers(0, place - 1))]), 0)
                entries.append(StartCondition(sequence, 0, first, draw(st.booleans()), draw(times)))
            else:
                entries.append(StartCondition(sequence, draw(times)))
        orders[OrderTarget(str(number), 0)] = tuple(entries)
    transition = draw(transitions)
    turns = [turn(draw, str(number), transition) for number in range(count)]
    return arrange(transition, turns, orders)


def turn(draw: st.DrawFn, name: str, transition: Transition) -> ScheduledAction:
    is_required = transition is Transition.ACTIVATE and draw(st.booleans())
    is_blocked = draw(st.integers(0, 5)) == 0
    action = None if is_blocked else ChangeState(name, "0", transition)
    step = PlannedAction(name, action, is_required, "missing" if is_blocked else "")
    return ScheduledAction(OrderTarget(name, 0), name, WatchedComponent(name, "0"), step)


class Behaviour(NamedTuple):
    """What an action comes to: after how long, whether well, and when its state is reached."""

    delay_s: float
    is_good: bool
    lag_s: float


behaviours = st.builds(
    Behaviour, moments, st.sampled_from([True, True, True, False]), st.just(0.0) | moments
)
disturbances = st.lists(st.tuples(moments, st.integers(0, 6), states), max_size=4)


class Simulation:
    """Runs a plan against components that take their time, fail, and are disturbed."""

    def __init__(
        self,
        plan: StartPlan,
        behaviours: list[Behaviour],
        disturbed: list[tuple[float, int, str]],
        timeout_s: float | None = None,
    ) -> None:
        self.plan = plan
        self.now = 0.0
        self.execution = StartExecution(plan, 0.0, timeout_s, PATIENCE_S)
        goal = plan.transition is Transition.ACTIVATE
        self.goal, before = ("Active", "Inactive") if goal else ("Inactive", "Active")
        self.states = {turn.target: before for turn in plan.turns}
        self.behaviours = behaviours
        self.begun: dict[OrderTarget, float] = {}
        self.answers: dict[OrderTarget, tuple[float, bool]] = {}
        self.reports: list[str] = []
        self.armed_at = FAR
        self.unmet: dict[tuple[int, StartCondition], float] = {}
        self._numbers = iter(range(10_000))
        self._events: list[tuple[float, int, object]] = []
        for moment, number, state in disturbed:
            self.later(moment, (OrderTarget(str(number), 0), state))

    def later(self, moment: float, event: object) -> None:
        heapq.heappush(self._events, (moment, next(self._numbers), event))

    def run(self) -> None:
        for _ in range(1000):
            if self.execution.is_over:
                return
            self.act()
            self.check_times()
            if not self.execution.is_over:
                self.pass_time()
        raise AssertionError("it never ends")

    def act(self) -> None:
        immediate = {turn.target for turn in self.plan.immediate}
        is_done = not self.execution.running and not self.execution.failure
        if is_done and not immediate & {t.target for t in self.execution.waiting}:
            self.armed_at = min(self.armed_at, self.now)
        watched = {turn.target: self.states[turn.target] for turn in self.execution.watched}
        self.execution.saw(watched)
        for turn in self.execution.ready(self.now):
            self.check(turn, watched)
            self.begun[turn.target] = self.now
            behaviour = self.behaviours[int(turn.target.instance)]
            if behaviour.is_good:
                reached = self.now + behaviour.delay_s + behaviour.lag_s
                self.later(reached, (turn.target, self.goal))
            self.later(self.now + behaviour.delay_s, turn)
        self.reports += self.execution.reports()

    def pass_time(self) -> None:
        moment = self.execution.next_moment()
        event = self._events[0][0] if self._events else FAR
        alarm = FAR if moment is None else moment
        assert min(event, alarm) < FAR, "nobody would ever wake it"
        self.now = max(self.now, min(event, alarm))
        while self._events and self._events[0][0] <= self.now:
            self.happen(heapq.heappop(self._events)[2])

    def happen(self, event: object) -> None:
        if isinstance(event, ScheduledAction):
            is_good = self.behaviours[int(event.target.instance)].is_good
            self.answers[event.target] = (self.now, is_good)
            self.execution.answered(event, Result() if is_good else NO, self.now)
            self.reports += self.execution.reports()
        else:
            assert isinstance(event, tuple)
            target, state = event
            if target in self.states:
                self.states[target] = state

    def check(self, turn: ScheduledAction, watched: Mapping[OrderTarget, str]) -> None:
        """Judge the beginning of an action by the meaning of its conditions."""
        assert turn.step.action is not None
        assert turn.target not in self.begun
        if not turn.is_delayed:
            assert set(self.begun) == set(self.answers), "two immediate ones at a time"
            assert all(
                sequence_of(other.conditions) <= sequence_of(turn.conditions)
                for other in self.plan.immediate
                if other.target in self.begun
            )
            return
        over = {t.target for t in self.plan.turns} - {t.target for t in self.execution.waiting}
        assert {t.target for t in self.plan.immediate} <= over
        for condition in turn.conditions:
            assert self.now >= self.armed_at + condition.wait_ms / 1000
            first = condition.preceding
            if first is None:
                continue
            if condition.is_sync and self.goal == "Active":
                assert watched[first] == "Active"
            elif condition.is_sync:
                assert watched[first] != "Active"
            elif self.goal == "Active":
                assert first in self.begun
            else:
                assert first in over

    def check_times(self) -> None:
        """A plan that goes on waits for nothing longer than it may."""
        unmet = {}
        for turn in self.execution.waiting if self.armed_at < FAR else ():
            for condition in turn.conditions:
                if condition.timeout_ms and not self.is_met(condition):
                    key = (turn.id, condition)
                    unmet[key] = self.unmet.get(key, self.now)
                    is_late = self.now >= unmet[key] + condition.timeout_ms / 1000
                    assert bool(self.execution.failure) or not is_late
        self.unmet = unmet

    def is_met(self, condition: StartCondition) -> bool:
        first = condition.preceding
        if first is None:
            return True
        if condition.is_sync:
            return (self.states[first] == "Active") == (self.goal == "Active")
        is_over = first not in {turn.target for turn in self.execution.waiting}
        return first in self.begun or (is_over and self.goal != "Active")

    def failures(self) -> Iterator[ScheduledAction]:
        """Yield the actions that went wrong by themselves."""
        for turn in self.plan.turns:
            answer = self.answers.get(turn.target)
            if answer is not None and not answer[1]:
                yield turn


simulations = st.builds(
    Simulation, plans(), st.lists(behaviours, min_size=7, max_size=7), disturbances
)


@given(simulations)
@settings(max_examples=400, deadline=None)
def test_nothing_is_done_before_its_time_and_everything_is_told(simulation):
    simulation.run()
    execution = simulation.execution
    assert set(simulation.begun) == set(simulation.answers), "not answered"
    waiting = {turn.target for turn in execution.waiting}
    assert not waiting & set(simulation.begun)
    failed = list(simulation.failures())
    if any(turn.step.is_required for turn in failed):
        assert execution.failure
    if not execution.failure:
        assert not waiting
        not_begun = [t for t in simulation.plan.turns if t.target not in simulation.begun]
        assert len(simulation.reports) == len(failed) + len(not_begun)
        assert not any(t.step.is_required for t in (*failed, *not_begun))


@given(simulations, moments)
@settings(max_examples=200, deadline=None)
def test_a_bound_on_the_whole_is_kept(simulation, timeout_s):
    bounded = Simulation(simulation.plan, simulation.behaviours, [], timeout_s)
    bounded.run()
    assert all(moment < timeout_s for moment in bounded.begun.values())
    assert set(bounded.begun) == set(bounded.answers)
    longest = max(behaviour.delay_s for behaviour in simulation.behaviours)
    assert bounded.now <= timeout_s + longest


@given(plans())
@settings(max_examples=200, deadline=None)
def test_when_all_goes_well_all_is_done_as_expected(plan):
    turns = [
        ScheduledAction(
            t.target,
            t.name,
            t.watched,
            PlannedAction(t.name, ChangeState(t.name, "0", plan.transition)),
        )
        for t in sorted(plan.turns, key=lambda turn: turn.target)
    ]
    patient = {
        t.target: tuple(
            StartCondition(c.sequence, c.wait_ms, c.preceding, c.is_sync) for c in t.conditions
        )
        for t in plan.turns
    }
    prompt = arrange(plan.transition, turns, patient)
    simulation = Simulation(prompt, [Behaviour(0.0, True, 0.0)] * 7, [])
    simulation.run()
    assert not simulation.execution.failure
    assert simulation.reports == []
    order = expected_order(prompt)
    assert set(simulation.begun) == set(order)
    begun = [simulation.begun[target] for target in order]
    assert begun == sorted(begun)


@given(plans())
@settings(max_examples=100, deadline=None)
def test_lines_number_all_actions_once_immediate_ones_first(plan):
    assert [turn.id for turn in plan.turns] == list(range(1, len(plan.turns) + 1))
    assert [line.split("}")[0] for line in plan.lines()] == [f"{{{t.id}" for t in plan.turns]
    places = [sequence_of(turn.conditions) for turn in plan.immediate]
    assert places == sorted(places)
    assert not any(c.is_delaying for turn in plan.immediate for c in turn.conditions)
    assert all(any(c.is_delaying for c in turn.conditions) for turn in plan.delayed)
