"""Taking objects to places on a grid: functions of commands over cross-sections.

A state is the place of the hand and of each object. Walking changes only the hand, carrying the
hand and the object: each leg is a shortest path in a cross-section of two dimensions.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial, reduce
from itertools import chain, permutations

from rtkit.planner import Command, Condition, Evaluator, Function, Problem, State, minimise

Place = tuple[int, int]
Least = Callable[[Place], float]
"""What work costs at least that begins with the hand at a place."""
HAND = "hand"
_STEPS = {"left": (-1, 0), "right": (1, 0), "down": (0, -1), "up": (0, 1)}
_HALF = ((0, 0),)
_WALK, _CARRY = 1, 2


@dataclass
class Site:
    """A grid with walls, and objects that occupy places relative to their own.

    Attributes:
        start: Where the hand and the objects are at first.
        shapes: Places that an object occupies, relative to its own; only its own if not told.
        evaluator: Plans and counts the legs.
    """

    width: int
    height: int
    walls: frozenset[Place]
    start: Mapping[str, Place]
    shapes: Mapping[str, tuple[Place, ...]] = field(default_factory=dict)
    evaluator: Evaluator = field(default_factory=Evaluator)

    def __post_init__(self) -> None:
        self.objects = [name for name in self.start if name != HAND]
        grid = [(x, y) for x in range(1, self.width + 1) for y in range(1, self.height + 1)]
        self._places = frozenset(grid) - self.walls
        self._index = {name: number for number, name in enumerate(self.start)}
        self._walks = {name: self._problem(None, name) for name in [HAND, *self.objects]}
        self._carries = {name: self._problem(name, name) for name in self.objects}
        self._site = (self.width, self.height, tuple(sorted(self.walls)))
        self.state: State = tuple(self.start.values())

    def walk(self, place: Place) -> Function:
        """Return the walk of the empty hand to a place."""
        key = partial(self._key, place, None, HAND)
        return self.evaluator.leg(self._walks[HAND], [HAND], {HAND: place}, key=key)

    def take(self, name: str, place: Place) -> Function:
        """Return the walk to an object and the carrying of it to a place."""
        number = self._index[name]

        def reach(state: State) -> Function:
            at = state[number]
            key = partial(self._key, at, None, name)
            return self.evaluator.leg(self._walks[name], [HAND], {HAND: at}, key=key)

        to_object = Function(lambda state: reach(state)(state))
        key = partial(self._key, place, name, name)
        carry = self.evaluator.leg(self._carries[name], [HAND, name], {name: place}, key=key)
        return to_object.followed_by(carry)

    def take_all(
        self,
        names: Collection[str],
        region: Collection[Place],
        then: Function,
        *,
        least: Least | None = None,
    ) -> Function:
        """Return the cheapest taking of all these away, in any order, into a fuzzy region.

        `least` is what follows costs at least; with it the most promising order and places of all
        are tried first, until no other can be better.
        """
        if least is not None:
            return self._take_best_first(names, region, then, least)
        if not names:
            return then

        def first(choice: tuple[str, Place]) -> Function:
            name, place = choice
            rest = [other for other in names if other != name]
            return self.take(name, place).followed_by(self.take_all(rest, region, then))

        return minimise([(name, place) for name in names for place in region], first)

    def _take_best_first(
        self, names: Collection[str], region: Collection[Place], then: Function, least: Least
    ) -> Function:
        orders, places = permutations(names), list(permutations(region, len(names)))
        choices = [tuple(zip(order, to, strict=True)) for order in orders for to in places]

        def all_of(choice: tuple[tuple[str, Place], ...]) -> Function:
            takes = [self.take(name, place) for name, place in choice]
            return reduce(Function.followed_by, [*takes, then])

        def bound(state: State, choice: tuple[tuple[str, Place], ...]) -> float:
            hand, cost = state[self._index[HAND]], 0
            for name, place in choice:
                at = state[self._index[name]]
                cost += _WALK * _distance(hand, at) + _CARRY * _distance(at, place)
                hand = place
            return cost + least(hand)

        return minimise(choices, all_of, bound)

    def _key(self, place: Place, carried: str | None, ignored: str, state: State) -> Hashable:
        """Return all that a way to a place depends on: alike objects may stand for each other."""
        others = [other for other in self.objects if other != ignored]
        blocked = [self._cells(other, state[self._index[other]]) for other in others]
        cells = tuple(sorted(set(chain.from_iterable(blocked))))
        moved = (self.shapes.get(carried, _HALF), state[self._index[carried]]) if carried else ()
        return (self._site, cells, moved, state[self._index[HAND]], place)

    def _cells(self, name: str, place: Place) -> Iterator[Place]:
        for dx, dy in self.shapes.get(name, _HALF):
            yield (place[0] + dx, place[1] + dy)

    def _problem(self, carried: str | None, ignored: str) -> Problem:
        """Return walking (to an object that does not block), or carrying of an object."""
        commands = [self._command(word, step, carried, ignored) for word, step in _STEPS.items()]
        cost = _CARRY if carried else _WALK
        costs = {command.name: cost for command in commands}
        variables = dict.fromkeys(self.start, self._places)
        return Problem(variables, self.start, {}, commands, costs)

    def _command(self, word: str, step: Place, carried: str | None, ignored: str) -> Command:
        hand = self._index[HAND]
        moved = {hand} | ({self._index[carried]} if carried else set())
        others = [(name, self._index[name]) for name in self.objects if name != ignored]

        def after(place: Place) -> Place:
            return (place[0] + step[0], place[1] + step[1])

        def is_free(state: State) -> bool:
            place = after(state[hand])
            cells = set(self._cells(carried, place)) if carried else {place}
            if not cells <= self._places:
                return False
            return not any(cells.intersection(self._cells(o, state[n])) for o, n in others)

        return Command(
            f"{'carry ' + carried if carried else 'walk'} {word}",
            lambda s: tuple(after(p) if n in moved else p for n, p in enumerate(s)),
            (Condition("the place is free", is_free),),
        )


def _distance(one: Place, other: Place) -> int:
    return abs(one[0] - other[0]) + abs(one[1] - other[1])


def switch_site() -> Site:
    """Two objects that are to change places, and a wall between them."""
    walls = frozenset([(5, 1), (5, 2), (5, 3)])
    return Site(8, 5, walls, {HAND: (1, 1), "A": (3, 4), "B": (7, 4)})


def switch(site: Site, x: Place, y: Place) -> Function:
    """Return the switch with A put down at x meanwhile, the empty hand waiting at y."""
    a, b = site.start["A"], site.start["B"]
    return (
        site.take("A", x)
        .followed_by(site.walk(y))
        .followed_by(site.take("B", a))
        .followed_by(site.take("A", b))
    )


def doorway_site(evaluator: Evaluator) -> Site:
    """A doorway two places high in which two objects stand; the tall A is to pass it."""
    walls = frozenset((6, y) for y in range(1, 7)) - {(6, 3), (6, 4)}
    start = {HAND: (2, 3), "A": (3, 3), "B1": (6, 4), "B2": (6, 3)}
    return Site(11, 6, walls, start, {"A": ((0, 0), (0, 1))}, evaluator)


REGION = ((5, 1), (5, 6), (4, 1), (4, 6))
"""Where what blocks the doorway may be put."""


def pass_doorway(site: Site, *, bounded: bool = False) -> Function:
    """Return the taking of A through the doorway, what blocks it put away before if need be."""
    to = (9, 3)
    direct = site.take("A", to)

    def least(hand: Place) -> float:
        at = site.start["A"]
        return _WALK * _distance(hand, at) + _CARRY * _distance(at, to)

    cleared = site.take_all(["B1", "B2"], REGION, direct, least=least if bounded else None)
    return Function(lambda state: direct(state) or cleared(state))
