"""Ways to do a task: each choice that a sentence leaves open is tried, and what it costs is told.

A task is a list of goals. A goal that only things block is reached by putting those away first,
each of which may be blocked again; nothing is put away for the sake of what is put away for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, permutations
from typing import NamedTuple

from manipulation.knowledge import UNIT, Pose, Site, cells_of
from manipulation.language import TURNS, Call, Go, PickUp, Place, Take, Target, Task, body_of
from manipulation.legs import Legs, Question, risks_of
from rtkit.errors import LimitReached, Malformed, Refused

CRITERIA = ("move", "carry", "turn", "risk")
_MOST_WAYS = 3000
Goal = Go | PickUp | Take
"""A goal whose target names no parameter and no past any more."""


class PlanStep(NamedTuple):
    """One command for the manipulator.

    Attributes:
        kind: ``travel``, ``over`` (above things), ``turn``, ``grip`` or ``release``.
        name: The thing that is gripped, carried or released; empty otherwise.
        criterion: What its price counts as.
    """

    kind: str
    pose: Pose
    name: str = ""
    criterion: str = ""
    price: float = 0.0
    risk: float = 0.0


class View(NamedTuple):
    """Where the hand and the things are, and what is held, at one point of a plan."""

    hand: Pose
    things: tuple[tuple[str, Pose], ...]
    holding: str

    @property
    def poses(self) -> dict[str, Pose]:
        """Return where each thing is."""
        return dict(self.things)

    def moved(self, hand: Pose, holding: str, poses: Mapping[str, Pose] | None = None) -> View:
        """Return it with the hand and some things elsewhere."""
        poses = poses or {}
        return View(hand, tuple((n, poses.get(n, pose)) for n, pose in self.things), holding)


class Part(NamedTuple):
    """A goal with the steps that reach it.

    Attributes:
        of: Which goal of the task it serves.
    """

    goal: Goal
    steps: tuple[PlanStep, ...]
    after: View
    of: int = 0


class Way(NamedTuple):
    """One way to do a task."""

    parts: tuple[Part, ...]

    @property
    def steps(self) -> tuple[PlanStep, ...]:
        """Return all its steps."""
        return tuple(step for part in self.parts for step in part.steps)

    @property
    def costs(self) -> dict[str, float]:
        """Return what it costs by criterion."""
        costs = dict.fromkeys(CRITERIA, 0.0)
        for step in self.steps:
            if step.criterion:
                costs[step.criterion] += step.price
            costs["risk"] += step.risk
        return costs

    @property
    def cost(self) -> float:
        """Return what it costs."""
        return sum(self.costs.values())

    def __str__(self) -> str:
        return "; ".join(str(part.goal) for part in self.parts)


class Blocked(Refused):
    """Things block the way, and no region is named for them; the message names the fewest."""


def view_of(site: Site) -> View:
    """Return the site as it is now."""
    poses = tuple((name, thing.pose) for name, thing in site.things.items())
    return View(site.hand, poses, site.holding)


def goals_of(
    task: Task, site: Site, definitions: Mapping[str, tuple[tuple[str, ...], str]]
) -> list[Goal]:
    """Return the goals of a task: calls are replaced by what they are defined as.

    ``where NAME was`` is where it is now, when the task is given; ``it`` is what was picked up.

    Raises:
        Malformed: A sentence in it cannot be understood.
        NotFound: Nothing has a name in it.
    """
    poses = {name: thing.pose for name, thing in site.things.items()}
    parameters = {name: each[0] for name, each in definitions.items()}
    left: list[Task] = [task]
    goals: list[Goal] = []
    held = site.holding
    while left:
        first = left.pop(0)
        if isinstance(first, Call):
            words, body = definitions[first.name]
            left = body_of(body, words, first.arguments, parameters) + left
            continue
        if isinstance(first, PickUp):
            held = site.thing(first.name)
            goals.append(first)
            continue
        target = first.target
        if target.relation == "was":
            site.thing(target.name)
            target = Target("at", poses[target.name][:2], "", target.turn)
        site.resolve(target, poses)
        if isinstance(first, Take):
            if first.name == "it" and not held:
                raise Malformed("nothing is held: what is 'it'?")
            held = site.thing(held if first.name == "it" else first.name)
            if first.into and first.into not in site.regions:
                raise Malformed(f"{first.into} is no region")
            first = first._replace(name=held)
            if target.turn and not site.things[held].is_bar:
                raise Malformed(f"{held} is no bar: it is not turned")
            held = ""
        elif target.turn:
            raise Malformed("the hand turns for bars only")
        goals.append(first._replace(target=target))
    return goals


class Ways:
    """Finds the ways to do tasks.

    Args:
        site: What is known.
        legs: Plans the legs.
        weights: What each criterion counts, where it is not to count as much as it costs.
    """

    def __init__(self, site: Site, legs: Legs, weights: Mapping[str, float] | None = None) -> None:
        self._site, self._legs = site, legs
        self._weights = weights or {}
        self._left = _MOST_WAYS
        costs = {
            place: site.risk_at(place) * self._weights.get("risk", 1)
            for places in site.regions.values()
            for place in places
        }
        self._risks = risks_of(costs)

    def all(self, goals: Sequence[Goal], view: View) -> list[Way]:
        """Return all ways that differ in what is left open, the cheapest first.

        Raises:
            Blocked: Things block the way, and no region is named for them.
            Refused: There is none; the message states where it ends.
            LimitReached: There are too many.
        """
        self._reason = ""
        ways = [Way(tuple(parts)) for parts in self._sequence(goals, 0, view, frozenset())]
        if not ways:
            raise Refused(self._reason or "there is no way")
        return sorted(ways, key=lambda way: (way.cost, len(way.steps)))

    def _sequence(
        self, goals: Sequence[Goal], of: int, view: View, busy: frozenset[str]
    ) -> Iterator[list[Part]]:
        if not goals:
            self._left -= 1
            if self._left < 0:
                raise LimitReached(f"more than {_MOST_WAYS} ways: name places, not regions")
            yield []
            return
        for first in self._ways_to(goals[0], of, view, busy):
            for rest in self._sequence(goals[1:], of + (not busy), first[-1].after, busy):
                yield [*first, *rest]

    def _ways_to(
        self, goal: Goal, of: int, view: View, busy: frozenset[str]
    ) -> Iterator[list[Part]]:
        """Yield the ways to a goal: direct ones, or where there is none those that clear it."""
        concrete = self._concrete(goal, view)
        direct = [part for each in concrete if (part := self.direct(each, view)) is not None]
        for part in direct:
            yield [part._replace(of=of)]
        if not direct and not self._reason_of_hand(goal, view):
            yield from self._cleared(goal, concrete, of, view, busy)

    def _concrete(self, goal: Goal, view: View) -> list[Goal]:
        if isinstance(goal, PickUp):
            return [goal]
        places = self._site.resolve(goal.target, view.poses)
        into = {"into": ""} if isinstance(goal, Take) else {}
        turn = goal.target.turn
        return [goal._replace(target=Target("at", each, "", turn), **into) for each in places]

    def _reason_of_hand(self, goal: Goal, view: View) -> str:
        if isinstance(goal, Go) or view.holding in ("", goal.name):
            return ""
        self._reason = f"{view.holding} is in the jaws: leave it first"
        return self._reason

    def _cleared(
        self, goal: Goal, concrete: list[Goal], of: int, view: View, busy: frozenset[str]
    ) -> Iterator[list[Part]]:
        moved = {"" if isinstance(goal, Go) else goal.name, view.holding}
        others = [name for name in view.poses if name not in busy | moved]
        self._reason = self._reason or f"there is no way to {goal}"
        for number in range(1, len(others) + 1):
            found = [
                (each, subset)
                for each in concrete
                for subset in combinations(others, number)
                if self.direct(each, view, subset) is not None
            ]
            if found:
                break
        else:
            return
        into = goal.into if isinstance(goal, Take) else ""
        if not into:
            sets = dict.fromkeys(" and ".join(subset) for _, subset in found)
            raise Blocked(f"in the way to {goal}: {', or '.join(sets)}")
        for each, subset in found:
            yield from self._in_any_order(each, subset, into, of, view, busy)

    def _in_any_order(
        self,
        goal: Goal,
        subset: tuple[str, ...],
        into: str,
        of: int,
        view: View,
        busy: frozenset[str],
    ) -> Iterator[list[Part]]:
        own = "" if isinstance(goal, Go) else goal.name
        down: list[Part] = []
        if view.holding:  # the hand is needed: what it holds is put down here
            here = Take(view.holding, Target("at", view.hand[:2]))
            part = self.direct(here, view)
            if part is None:
                return
            down, view = [part._replace(of=of)], part.after
        for order in permutations(subset):
            takes = [Take(name, Target("in", None, into), into) for name in order]
            for parts in self._sequence(takes, of, view, busy | {*subset, own}):
                last = self.direct(goal, parts[-1].after)
                if last is not None:
                    yield [*down, *(p._replace(of=of) for p in parts), last._replace(of=of)]

    # one goal

    def direct(self, goal: Goal, view: View, without: Sequence[str] = ()) -> Part | None:
        """Return the cheapest way to a goal that names its place, as if some things were away."""
        if isinstance(goal, Go):
            assert goal.target.place is not None
            return self._go(goal, goal.target.place, view, without)
        if view.holding not in ("", goal.name):
            self._reason_of_hand(goal, view)
            return None
        thing = self._site.things[goal.name]
        pose = view.poses[goal.name]
        place = goal.target.place if isinstance(goal, Take) else None
        turned = TURNS.get(goal.target.turn) if isinstance(goal, Take) else None
        if place == pose[:2] and turned in (None, pose[2]) and not view.holding:
            return Part(goal, (), view)
        steps: list[PlanStep] = []
        if view.holding != goal.name:
            wanted = (*pose[:2], pose[2] if thing.is_bar else None)
            turn = self._price("turn") if thing.is_bar else 0.0
            ways = self._leg(UNIT, "move", turn, view, view.hand, wanted, {goal.name, *without})
            if ways is None:
                return None
            steps += self._walked(view, ways, goal.name)
            hand = ways[-1] if ways else view.hand
            steps.append(PlanStep("grip", hand, goal.name))
            view = view.moved(hand, goal.name)
        if place is not None:
            return self._carried(goal, place, view, steps, without)
        return Part(goal, tuple(steps), view)

    def _carried(
        self, goal: Goal, place: Place, view: View, steps: list[PlanStep], without: Sequence[str]
    ) -> Part | None:
        thing, name = self._site.things[view.holding], view.holding
        turn = self._price("turn") if thing.is_bar else 0.0
        turned = TURNS.get(goal.target.turn) if isinstance(goal, Take) else None
        pose, wanted = view.poses[name], (*place, turned)
        way = self._leg(thing.shape, "carry", turn, view, pose, wanted, {name, *without})
        if way is None:
            return None
        steps = [*steps, *self._stepped(pose, way, "carry", name)]
        last = way[-1] if way else pose
        hand = (*last[:2], last[2] if thing.is_bar else view.hand[2])
        holding = name
        if isinstance(goal, Take):
            steps.append(PlanStep("release", hand, name))
            holding = ""
        return Part(goal, tuple(steps), view.moved(hand, holding, {name: last}))

    def _go(self, goal: Go, place: Place, view: View, without: Sequence[str]) -> Part | None:
        if view.holding:
            return self._carried(goal, place, view, [], without)
        way = self._leg(UNIT, "move", 0.0, view, view.hand, (*place, None), {*without})
        if way is None:
            return None
        after = view.moved(way[-1] if way else view.hand, "")
        return Part(goal, tuple(self._stepped(view.hand, way, "move")), after)

    def _leg(
        self,
        shape: tuple[Place, ...],
        criterion: str,
        turn: float,
        view: View,
        start: Pose,
        goal: tuple[int, int, int | None],
        ignored: set[str],
    ) -> tuple[Pose, ...] | None:
        blocked = self._site.blocked(view.poses, ignored)
        turns = (0, 1) if turn else (start[2],)
        fits = (cells_of(shape, (*goal[:2], t)) for t in turns if goal[2] in (None, t))
        if not any(cells.isdisjoint(blocked) and self._all_inside(cells) for cells in fits):
            return None  # it does not fit there: nothing to search for
        question = Question(shape, self._price(criterion), turn, self._risks, start, goal)
        leg = self._legs.find(question, blocked)
        return None if leg.cost is None else leg.poses

    def _all_inside(self, cells: frozenset[Place]) -> bool:
        return all(self._site.is_inside(place) for place in cells)

    def _price(self, criterion: str) -> float:
        price: float = getattr(self._site.prices, criterion)
        return price * self._weights.get(criterion, 1)

    def _walked(self, view: View, way: Sequence[Pose], name: str) -> list[PlanStep]:
        """Return a walk to a thing: what enters its places goes above it."""
        own = cells_of(self._site.things[name].shape, view.poses[name])
        return [
            step._replace(kind="over", name=name)
            if step.kind == "travel" and step.pose[:2] in own
            else step
            for step in self._stepped(view.hand, way, "move")
        ]

    def _stepped(
        self, start: Pose, way: Sequence[Pose], criterion: str, name: str = ""
    ) -> list[PlanStep]:
        steps = []
        for before, after in zip([start, *way], way, strict=False):
            if before[2] != after[2]:
                steps.append(PlanStep("turn", after, name, "turn", self._site.prices.turn))
                continue
            price = getattr(self._site.prices, criterion)
            risk = self._site.risk_at(after[:2])
            steps.append(PlanStep("travel", after, name, criterion, price, risk))
        return steps


class Alternative(NamedTuple):
    """A way that is offered: its letter, the way, and what it is best in."""

    letter: str
    way: Way
    best_in: tuple[str, ...]

    def __str__(self) -> str:
        costs = {name: cost for name, cost in self.way.costs.items() if cost}
        told = ", ".join(f"{name} {cost:g}" for name, cost in costs.items())
        best = f"; least {' and '.join(self.best_in)}" if self.best_in else ""
        return f"{self.letter}: cost {self.way.cost:g} ({told}{best}): {self.way}"


def alternatives(
    site: Site, legs: Legs, goals: Sequence[Goal], most: int = 9
) -> tuple[list[Alternative], list[str]]:
    """Return the ways that differ in what is left open or in costs, and which are tied.

    Raises:
        Blocked: Things block the way, and no region is named for them.
        Refused: There is none.
        LimitReached: There are too many.
    """
    view = view_of(site)
    found = Ways(site, legs).all(goals, view)
    if all(str(way) == str(found[0]) for way in found):
        seen = [found[0].costs]
        for criterion in CRITERIA:
            if found[0].costs[criterion]:
                weights = {criterion: 1000.0}
                way = Ways(site, legs, weights).all(goals, view)[0]
                is_better = way.costs[criterion] < found[0].costs[criterion]
                if is_better and way.costs not in seen:
                    seen.append(way.costs)
                    found.append(way)
        found.sort(key=lambda way: way.cost)
    shown = found[:most]
    least = {name: min(way.costs[name] for way in shown) for name in CRITERIA}
    offered = []
    for letter, way in zip("abcdefghi", shown, strict=False):
        best = tuple(
            name
            for name in CRITERIA
            if way.costs[name] == least[name] and any(o.costs[name] > least[name] for o in shown)
        )
        offered.append(Alternative(letter, way, best))
    tied = [each.letter for each in offered if each.way.cost == offered[0].way.cost]
    return offered, tied if len(tied) > 1 else []
