"""Executes a start or stop as a functional core: takes results and states, returns actions to send.

Time is an argument: monotonic seconds. A condition on a state is judged by the state seen last,
even if the condition held before: an action that waits for a component which died meanwhile
keeps waiting.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rtkit.deployment.actions import Result
from rtkit.deployment.conditions import OrderTarget, StartCondition
from rtkit.deployment.plan_watch import DONE, FAILED
from rtkit.deployment.start_schedule import ScheduledAction, StartPlan, words
from rtkit.rtc.enums import LifeCycleState, Transition

_MOST_PENDING = 3


class StepEnd(NamedTuple):
    """The end of a step, as `PlanWatch.step` receives it."""

    text: str
    state: str
    took_s: float | None
    why: str


class StartExecution:
    """A start or stop under way.

    Attributes:
        plan: Plan that is carried out.
        failure: Why it was broken off; empty as long as it was not.
    """

    def __init__(
        self, plan: StartPlan, now: float, timeout_s: float | None = None, patience_s: float = 10.0
    ) -> None:
        """Begin at time `now` [s].

        Args:
            plan: Plan that is to be carried out.
            now: The time [s].
            timeout_s: Bound on the whole [s]; None for none.
            patience_s: How long nothing may happen that conditions without a time-out wait for,
                as long as there is no bound on the whole [s].
        """
        self.plan = plan
        self.failure = ""
        self._is_start = plan.transition is Transition.ACTIVATE
        self._names = plan.names
        self._queue = deque(plan.immediate)
        self._waiting = {turn.id: turn for turn in plan.delayed}
        self._running: dict[int, ScheduledAction] = {}
        self._begun: set[OrderTarget] = set()
        self._over: set[OrderTarget] = set()
        self._states: Mapping[OrderTarget, str] = {}
        self._armed_at: float | None = None
        self._asked_at = self._moved_at = now
        self._unmet_since: dict[tuple[int, StartCondition], float] = {}
        self._reports: list[str] = []
        self._ends: list[StepEnd] = []
        self._timeout_s = timeout_s
        self._patience_s = patience_s
        self._deadline = now + timeout_s if timeout_s is not None else None

    @property
    def is_over(self) -> bool:
        """Return whether nothing is under way and nothing will be begun."""
        return not self._running and (bool(self.failure) or not self.waiting)

    @property
    def running(self) -> tuple[ScheduledAction, ...]:
        """The actions that were begun and not answered."""
        return tuple(self._running.values())

    @property
    def waiting(self) -> tuple[ScheduledAction, ...]:
        """The actions that were not begun."""
        return (*self._queue, *self._waiting.values())

    @property
    def watched(self) -> tuple[ScheduledAction, ...]:
        """The actions whose state counts at present: to be read before `ready`."""
        if self.failure or self._queue or (self._armed_at is None and self._running):
            return ()
        entries = ((c.preceding, c.is_sync) for _, c in self._entries())
        targets = {target for target, is_sync in entries if is_sync}
        return tuple(turn for turn in self.plan.turns if turn.target in targets)

    def saw(self, states: Mapping[OrderTarget, str]) -> None:
        """Take what is seen of all that is `watched`."""
        self._states = states

    def ready(self, now: float) -> list[ScheduledAction]:
        """Return what is to be sent now, in this order; from now on it counts as sent."""
        begun: list[ScheduledAction] = []
        self._asked_at = now
        if self._deadline is not None and now >= self._deadline and not self.is_over:
            self._too_late(f"not finished within {self._timeout_s:g} s")
        elif self._queue:
            begun = self._next_immediate(now)
        elif self._armed_at is not None or not self._running:
            self._armed_at = now if self._armed_at is None else self._armed_at
            begun = self._next_delayed(now)
            self._judge(now)
        return begun

    def answered(self, turn: ScheduledAction, result: Result, now: float) -> None:
        """Take the outcome of an action that was begun."""
        del self._running[turn.id]
        self._over.add(turn.target)
        self._moved_at = now
        if result.ok:
            self._ends.append(StepEnd(turn.step.text, DONE, result.took_s, ""))
        else:
            self._failed(turn, turn.step.failure_text(result.why))

    def cancel(self, why: str) -> None:
        """Begin nothing more; what was begun is still waited for."""
        self.failure = self.failure or why
        self._unmet_since.clear()

    def reports(self) -> list[str]:
        """Return what failed without ending the plan, since the last call."""
        reports, self._reports = self._reports, []
        return reports

    def ends(self) -> list[StepEnd]:
        """Return what was done or failed since the last call."""
        ends, self._ends = self._ends, []
        return ends

    def next_moment(self) -> float | None:
        """Return when `ready` is to be called again though nothing happened; None for never.

        It may have passed already: what was not yet due when `ready` was called last counts.
        """
        if self.failure:
            return None
        moments = [] if self._deadline is None else [self._deadline]
        if self._armed_at is not None:
            waits = (self._moment(c) for turn in self._waiting.values() for c in turn.conditions)
            moments += [moment for moment in waits if moment > self._asked_at]
            limits = [self._limit(entry) for entry in self._unmet_since if entry[1].timeout_ms]
            moments += [*limits, *self._end_of_patience()]
        elif not self._queue and not self._running and self._waiting:
            moments.append(self._asked_at)
        return min(moments, default=None)

    def _next_immediate(self, now: float) -> list[ScheduledAction]:
        while self._queue and not self._running and not self.failure:
            turn = self._queue.popleft()
            if self._begin(turn, now):
                return [turn]
        return []

    def _next_delayed(self, now: float) -> list[ScheduledAction]:
        begun: list[ScheduledAction] = []
        is_moving = True
        while is_moving and not self.failure:
            is_moving = False
            for turn in list(self._waiting.values()):
                vain = next((c for c in turn.conditions if self._is_vain(c)), None)
                if self.failure or not (vain or self._is_due(turn, now)):
                    continue
                is_moving = True
                del self._waiting[turn.id]
                if vain is not None:
                    self._over.add(turn.target)
                    why = words(vain, self._names)
                    self._failed(turn, f"Preceding condition cannot be met: {why}, of {turn.name}")
                elif self._begin(turn, now):
                    begun.append(turn)
        return begun

    def _begin(self, turn: ScheduledAction, now: float) -> bool:
        self._moved_at = now
        if turn.step.action is None:
            self._over.add(turn.target)
            self._failed(turn, turn.step.blocked)
            return False
        self._running[turn.id] = turn
        self._begun.add(turn.target)
        return True

    def _failed(self, turn: ScheduledAction, why: str) -> None:
        self._ends.append(StepEnd(turn.step.text, FAILED, None, why))
        if turn.step.is_required:
            self.cancel(f"Required action failed: {why}")
        else:
            self._reports.append(f"Action failed: {why}")

    # conditions

    def _entries(self) -> Iterator[tuple[int, StartCondition]]:
        """Yield what the actions that were not begun wait for, other than a time."""
        for turn in self._waiting.values():
            for condition in turn.conditions:
                if condition.preceding is not None:
                    yield turn.id, condition

    def _is_due(self, turn: ScheduledAction, now: float) -> bool:
        return all(now >= self._moment(c) and self._is_met(c) for c in turn.conditions)

    def _is_met(self, condition: StartCondition) -> bool:
        first = condition.preceding
        if first is None:
            return True
        if not condition.is_sync:
            return first in self._begun or (first in self._over and not self._is_start)
        state = self._states.get(first)
        if self._is_start:
            return state == LifeCycleState.ACTIVE
        # One that failed or died is at rest too; the others must not run on because of it.
        return state is not None and not state.startswith(LifeCycleState.ACTIVE)

    def _is_vain(self, condition: StartCondition) -> bool:
        """Return whether a condition waits for an action that was found impossible."""
        first = condition.preceding
        is_asking = first is not None and not condition.is_sync and self._is_start
        return is_asking and first in self._over and first not in self._begun

    # time

    def _judge(self, now: float) -> None:
        """Note since when conditions are not met; end a plan that waited long enough."""
        if self.failure:
            return
        known, self._unmet_since = self._unmet_since, {}
        for entry in self._entries():
            if not self._is_met(entry[1]):
                self._unmet_since[entry] = known.get(entry, now)
        for entry in self._unmet_since:
            number, condition = entry
            if condition.timeout_ms and now >= self._limit(entry):
                self.cancel(
                    "Error executing plan: Preceding condition timed out:"
                    f" action {{{number}}} waited {condition.timeout_ms}ms"
                    f" for: {self._described(condition)}"
                )
                return
        if any(now >= moment for moment in self._end_of_patience()):
            self._too_late(f"nothing has happened for {self._patience_s:g} s")

    def _moment(self, condition: StartCondition) -> float:
        assert self._armed_at is not None
        return self._armed_at + condition.wait_ms / 1000

    def _limit(self, entry: tuple[int, StartCondition]) -> float:
        return self._unmet_since[entry] + entry[1].timeout_ms / 1000

    def _end_of_patience(self) -> list[float]:
        """Return when a plan without bound ends because nothing happens; nothing while it does."""
        if self._deadline is not None or self._running or self._armed_at is None:
            return []
        if not self._waiting:
            return []
        return [max(self._moved_at, self._armed_at + self.plan.last_moment_s) + self._patience_s]

    def _too_late(self, how: str) -> None:
        pending = [f"action {{{turn.id}}} is under way" for turn in self._running.values()]
        pending += [
            f"action {{{number}}} waits for: {self._described(condition)}"
            for number, condition in self._unmet_since
        ]
        more = [f"and {len(pending) - _MOST_PENDING} more"] if len(pending) > _MOST_PENDING else []
        details = ", ".join([*pending[:_MOST_PENDING], *more])
        self.cancel(f"Error executing plan: {how}" + (f"; {details}" if details else ""))

    def _described(self, condition: StartCondition) -> str:
        assert condition.preceding is not None
        state = self._states.get(condition.preceding, "not seen")
        how = f"it is {state}" if condition.is_sync else "not sent"
        return f"{words(condition, self._names)} ({how})"
