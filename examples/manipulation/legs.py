"""Legs: the way of one body, the hand or a load, among places that are taken; solved ones are kept.

A leg is a plan in the cross-section of three dimensions (x, y, turn). Its answer is used again
while nothing on its way has changed: no place of the way is taken now, and no place was freed
through which a cheaper one could lead.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from manipulation.knowledge import Cells, Pose, cells_of, swept
from manipulation.language import Place
from rtkit.errors import Impossible
from rtkit.planner import Command, Condition, Problem, plan

STEPS = {"left": (-1, 0), "right": (1, 0), "down": (0, -1), "up": (0, 1)}
TURN = "turn"
Risks = tuple[tuple[Place, float], ...]


class Question(NamedTuple):
    """What a leg is asked for.

    Attributes:
        shape: Of the body.
        turn: The price of a quarter turn; 0 where it is not turned.
        goal: Place, and turn or None for any.
    """

    shape: tuple[Place, ...]
    step: float
    turn: float
    risks: Risks
    start: Pose
    goal: tuple[int, int, int | None]


@dataclass(frozen=True)
class Leg:
    """Answer to a question: the poses after each step; no poses and no cost where there is no way.

    Attributes:
        blocked: What was taken when it was found.
    """

    poses: tuple[Pose, ...]
    cost: float | None
    blocked: Cells


@dataclass
class Search:
    """What one evaluation looked at, for pictures."""

    question: Question
    expanded: list[Pose] = field(default_factory=list)
    leg: Leg | None = None


class Legs:
    """Plans legs, and remembers them.

    An *evaluation* is one search in a cross-section, whether it finds a way or not.

    Attributes:
        evaluations: How many searches there were.
        remembered: How many answers were taken from memory instead.
        searches: The searches since this list was emptied.
    """

    def __init__(self, width: int, height: int) -> None:
        self._width, self._height = width, height
        self.known: dict[Question, Leg] = {}
        self.evaluations = 0
        self.remembered = 0
        self.searches: list[Search] = []

    def find(self, question: Question, blocked: Cells) -> Leg:
        """Return the cheapest way, from memory where that still holds."""
        known = self.known.get(question)
        if known is not None and _still_holds(question, known, blocked):
            self.remembered += 1
            return known
        self.evaluations += 1
        search = Search(question)
        try:
            found = plan(self._problem(question, blocked, search), _heuristic(question))
            leg = Leg(tuple(step.after[0] for step in found.steps), found.cost, blocked)
        except Impossible:
            leg = Leg((), None, blocked)
        search.leg = leg
        self.searches.append(search)
        self.known[question] = leg
        return leg

    def _problem(self, question: Question, blocked: Cells, search: Search) -> Problem:
        poses = [
            (x, y, turned)
            for x in range(1, self._width + 1)
            for y in range(1, self._height + 1)
            for turned in (0, 1)
        ]
        free = frozenset(self._inside()) - blocked
        fits = {pose for pose in poses if cells_of(question.shape, pose) <= free}
        domain = fits | {question.start}
        commands = [_move(word, *step) for word, step in STEPS.items()]
        if question.turn:
            commands.append(_turn(question, free))
        risks = dict(question.risks)

        def price(command: Command, _before: Any, after: Any) -> float:
            if command.name == TURN:
                return question.turn
            return question.step + risks.get(after[0][:2], 0)

        def offered(state: Any) -> Iterable[Command]:
            search.expanded.append(state[0])
            return commands

        x, y, turned = question.goal

        def is_goal(state: Any) -> bool:
            pose = state[0]
            return pose[:2] == (x, y) and turned in (None, pose[2])

        return Problem({"pose": domain}, (question.start,), is_goal, offered, price)

    def _inside(self) -> Iterable[Place]:
        return ((x, y) for x in range(1, self._width + 1) for y in range(1, self._height + 1))


def _move(word: str, dx: int, dy: int) -> Command:
    return Command(word, lambda s: ((s[0][0] + dx, s[0][1] + dy, s[0][2]),))


def _turn(question: Question, free: Cells) -> Command:
    room = Condition("there is room", lambda s: swept(question.shape, s[0]) <= free)
    return Command(TURN, lambda s: ((s[0][0], s[0][1], 1 - s[0][2]),), (room,))


def _heuristic(question: Question) -> Any:
    x, y, turned = question.goal

    def estimate(state: Any) -> float:
        pose = state[0]
        turn = question.turn if turned not in (None, pose[2]) else 0
        far: int = abs(pose[0] - x) + abs(pose[1] - y)
        return question.step * far + turn

    return estimate


def _still_holds(question: Question, leg: Leg, blocked: Cells) -> bool:
    freed = leg.blocked - blocked
    if leg.cost is None:
        return not freed
    taken = blocked - leg.blocked
    if taken and not taken.isdisjoint(passed(question, leg)):
        return False
    return all(_least_through(question, place) >= leg.cost for place in freed)


def passed(question: Question, leg: Leg) -> Cells:
    """Return all places that a body occupies on its way, but for those at its start."""
    cells: set[Place] = set()
    before = question.start
    for pose in leg.poses:
        is_turn = pose[2] != before[2]
        cells |= swept(question.shape, before) if is_turn else cells_of(question.shape, pose)
        before = pose
    return frozenset(cells)


def _least_through(question: Question, place: Place) -> float:
    """Return what a way costs at least on which the body occupies a place."""
    reach = max(abs(dx) + abs(dy) for dx, dy in question.shape)
    if question.turn:
        reach *= 2  # a turn passes the whole box
    x, y = place
    steps = 0
    for end in (question.start, question.goal):
        steps += max(0, abs(end[0] - x) + abs(end[1] - y) - reach)
    return question.step * steps


def risks_of(costs: Mapping[Place, float]) -> Risks:
    """Return risks in the form that questions have."""
    return tuple(sorted((place, cost) for place, cost in costs.items() if cost))
