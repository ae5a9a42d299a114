"""Start schedule: the actions of a start or stop in order, with the conditions of each, as data.

The states of components are told here as these conditions and waiting commands see them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from heapq import heapify, heappop, heappush

from rtkit.deployment.conditions import NO_ORDERS, Orders, OrderTarget, StartCondition, sequence_of
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.layered_plan import Check, PlannedAction
from rtkit.fast_dataclass import dataclass, replace
from rtkit.rtc.enums import Transition

MISSING = "missing"
"""State of a component that is not there."""


@dataclass(frozen=True, slots=True)
class WatchedComponent:
    """A component in one of its execution contexts, as its manager knows them."""

    instance: str
    context: str


def seen(facts: ComponentFacts | None, context: str) -> str:
    """Return the state of a component in one context; more words when it is not just that."""
    if facts is None:
        return MISSING
    if facts.zombie:
        return f"zombie ({facts.zombie})"
    state = next((each.state.value for each in facts.contexts if each.id == context), "")
    if not state:
        return f"without execution context {context}"
    return f"{state} ({facts.trouble})" if facts.trouble else state


def look(
    targets: Sequence[WatchedComponent], component: Callable[[str], ComponentFacts | None]
) -> tuple[str, ...]:
    """Return what is to be seen of each target; `component` finds facts by instance name."""
    return tuple(seen(component(each.instance), each.context) for each in targets)


@dataclass(frozen=True, slots=True)
class ScheduledAction:
    """One action of a start or stop.

    Attributes:
        id: Its number, from 1; 0 as long as it has none.
        name: The component as users know it, with the context where it has several.
        watched: Where its state is seen.
        conditions: All of them must hold.
    """

    target: OrderTarget
    name: str
    watched: WatchedComponent
    step: PlannedAction
    conditions: tuple[StartCondition, ...] = ()
    id: int = 0

    @property
    def is_delayed(self) -> bool:
        """Return whether it waits for more than those before it."""
        return any(condition.is_delaying for condition in self.conditions)


@dataclass(frozen=True, slots=True)
class StartPlan:
    """The actions of a start or stop.

    Attributes:
        transition: Transition that every action asks for.
        immediate: Done first, one after the other.
        delayed: Done after those, each when its conditions hold.
        checks: Conditions that must hold before anything is done.
    """

    transition: Transition
    immediate: tuple[ScheduledAction, ...]
    delayed: tuple[ScheduledAction, ...] = ()
    checks: tuple[Check, ...] = ()

    @property
    def turns(self) -> tuple[ScheduledAction, ...]:
        """Every action, in order."""
        return self.immediate + self.delayed

    @property
    def steps(self) -> tuple[PlannedAction, ...]:
        """The same without what they wait for."""
        return tuple(turn.step for turn in self.turns)

    @property
    def names(self) -> dict[OrderTarget, str]:
        """The component of each action as users know it."""
        return {turn.target: turn.name for turn in self.turns}

    @property
    def has_conditions(self) -> bool:
        """Return whether the profile states anything of the order."""
        return any(turn.conditions for turn in self.turns)

    @property
    def last_moment_s(self) -> float:
        """Return when the last wait or time-out is over, in the delayed part [s]."""
        return max((max(c.wait_ms, c.timeout_ms) / 1000 for _, c in self._entries()), default=0.0)

    def lines(self) -> Iterator[str]:
        """Yield the plan as a dry run shows it."""
        for check in self.checks:
            yield check.text + (" (Required)" if check.is_required else "")
        for turn in self.turns:
            yield turn.step.line

    def warnings(self) -> Iterator[str]:
        """Yield the dependencies on actions that may never come about."""
        if self.transition is not Transition.ACTIVATE:
            return
        turns = {turn.target: turn for turn in self.turns}
        for turn, condition in self._entries():
            first = turns[condition.preceding] if condition.preceding is not None else None
            if first is not None and not first.step.is_required:
                yield (
                    f"action {{{turn.id}}} depends on the optional action {{{first.id}}},"
                    f" which may never be done: {words(condition, self.names)}"
                )

    def _entries(self) -> Iterator[tuple[ScheduledAction, StartCondition]]:
        return ((turn, condition) for turn in self.delayed for condition in turn.conditions)


def words(condition: StartCondition, names: Mapping[OrderTarget, str]) -> str:
    """Return what a condition waits for; empty when it is a place in the order only."""
    if condition.preceding is not None:
        name = names[condition.preceding]
        return f"Sync to {name}" if condition.is_sync else f"After {name}'s action"
    return f"Wait {condition.wait_ms}ms" if condition.wait_ms else ""


def arrange(
    transition: Transition,
    turns: Iterable[ScheduledAction],
    orders: Orders = NO_ORDERS,
    checks: tuple[Check, ...] = (),
) -> StartPlan:
    """Number the actions (given in the order of who waits for nothing) and split them."""
    given = [replace(turn, conditions=orders.get(turn.target, ())) for turn in turns]
    given.sort(key=lambda turn: (turn.is_delayed, sequence_of(turn.conditions)))
    names = {turn.target: turn.name for turn in given}
    numbered = [_numbered(turn, number, names) for number, turn in enumerate(given, 1)]
    immediate = tuple(turn for turn in numbered if not turn.is_delayed)
    return StartPlan(transition, immediate, tuple(numbered[len(immediate) :]), checks)


def _numbered(
    turn: ScheduledAction, number: int, names: Mapping[OrderTarget, str]
) -> ScheduledAction:
    brackets = _brackets(turn.conditions, names)
    text = f"{{{number}}} {brackets}{turn.step.text}"
    return replace(turn, id=number, step=replace(turn.step, text=text))


def _brackets(conditions: Sequence[StartCondition], names: Mapping[OrderTarget, str]) -> str:
    """Return all conditions of an action, those of one place together."""
    grouped: dict[int, list[str]] = {}
    for condition in conditions:
        what = words(condition, names)
        grouped.setdefault(condition.sequence, []).extend([what] if what else [])
    parts = [
        f"Order {sequence}" + (f"/{', '.join(what)}" if what else "")
        for sequence, what in grouped.items()
    ]
    return f"[{', '.join(parts)}] " if parts else ""


def expected_order(plan: StartPlan) -> list[OrderTarget]:
    """Return the order in which the actions would be done if none took any time."""
    moments: dict[OrderTarget, float] = {}
    left = {turn.target: set(_preceding(turn)) for turn in plan.turns}
    followers: dict[OrderTarget, list[ScheduledAction]] = {}
    for turn in plan.turns:
        for target in left[turn.target]:
            followers.setdefault(target, []).append(turn)
    # A time below all others keeps those that wait for nothing in front.
    ready = [(-1.0, turn.id, turn) for turn in plan.immediate]
    ready += [(_moment(t, moments), t.id, t) for t in plan.delayed if not left[t.target]]
    heapify(ready)
    while ready:
        moment, _, turn = heappop(ready)
        moments[turn.target] = moment
        for follower in followers.get(turn.target, ()):
            left[follower.target].discard(turn.target)
            if not left[follower.target]:
                heappush(ready, (_moment(follower, moments), follower.id, follower))
    return list(moments)


def _preceding(turn: ScheduledAction) -> Iterator[OrderTarget]:
    return (c.preceding for c in turn.conditions if c.preceding is not None)


def _moment(turn: ScheduledAction, moments: Mapping[OrderTarget, float]) -> float:
    waits = [condition.wait_ms / 1000 for condition in turn.conditions]
    return max([*waits, *(moments[target] for target in _preceding(turn))], default=0.0)
