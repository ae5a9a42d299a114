"""The site as it is known: walls, things with their places, named places and regions, prices.

What is known is apart from what is: only the table (`table.py`) knows where things really lie.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, NamedTuple

from manipulation.language import Place, Target, text_of
from rtkit.errors import Malformed, NotFound

Pose = tuple[int, int, int]
"""Place and quarter turns (0 or 1) of a body."""
Cells = frozenset[Place]
UNIT: tuple[Place, ...] = ((0, 0),)
NEAR = 2
"""How many steps are near."""


def cells_of(shape: Iterable[Place], pose: Pose) -> Cells:
    """Return the places that a body of a shape occupies; a quarter turn is counterclockwise."""
    x, y, turned = pose
    if turned:
        return frozenset((x - dy, y + dx) for dx, dy in shape)
    return frozenset((x + dx, y + dy) for dx, dy in shape)


def swept(shape: Iterable[Place], pose: Pose) -> Cells:
    """Return the places that a quarter turn of a body passes: the box around both its poses."""
    x, y, turned = pose
    cells = cells_of(shape, pose) | cells_of(shape, (x, y, 1 - turned))
    columns, rows = [c for c, _ in cells], [r for _, r in cells]
    return frozenset(
        (column, row)
        for column in range(min(columns), max(columns) + 1)
        for row in range(min(rows), max(rows) + 1)
    )


class Prices(NamedTuple):
    """What things cost: a step of the empty hand, a step with a load, a quarter turn."""

    move: float = 1.0
    carry: float = 2.0
    turn: float = 3.0


@dataclass
class Thing:
    """A thing on the table, as it is known.

    Attributes:
        shape: Places that it occupies relative to its own, at no turn.
        pose: Where it is thought to be.
        found: How far from the middle of its place it was felt to lie [places]; None: not yet.
        is_bar: It may be turned, and the jaws must be turned as it is to grip it.
        is_named: The operator has named it; else it was found by touch.
        empty: Spots relative to its place where the jaws felt nothing [places].
    """

    pose: Pose
    shape: tuple[Place, ...] = UNIT
    found: tuple[float, float] | None = None
    is_bar: bool = False
    is_named: bool = True
    empty: list[tuple[float, float]] = field(default_factory=list)


@dataclass
class Site:
    """What is known of the table.

    Attributes:
        hand: Place and turn of the jaws.
        holding: The thing in the jaws; empty for none.
        risks: What entering a place of a region costs more.
    """

    width: int
    height: int
    walls: set[Place] = field(default_factory=set)
    hand: Pose = (1, 1, 0)
    holding: str = ""
    things: dict[str, Thing] = field(default_factory=dict)
    places: dict[str, Place] = field(default_factory=dict)
    regions: dict[str, tuple[Place, ...]] = field(default_factory=dict)
    prices: Prices = field(default_factory=lambda: Prices())
    risks: dict[str, float] = field(default_factory=dict)

    @property
    def state(self) -> tuple[Pose, ...]:
        """Return where the hand and the things are, in order."""
        return (self.hand, *(thing.pose for thing in self.things.values()))

    def names(self) -> list[str]:
        """Return all names that are given."""
        return [*self.things, *self.places, *self.regions]

    def is_inside(self, place: Place) -> bool:
        """Return whether there is such a place."""
        return 1 <= place[0] <= self.width and 1 <= place[1] <= self.height

    def risk_at(self, place: Place) -> float:
        """Return what entering a place costs more."""
        return sum(cost for name, cost in self.risks.items() if place in self.regions[name])

    def set_price(self, name: str, value: float) -> None:
        """Set a price, or the risk of a region.

        Raises:
            Malformed: It is not greater than 0 (a risk: not below 0).
            NotFound: There is no such price or region.
        """
        if name in Prices._fields:
            if not 0 < value < float("inf"):
                raise Malformed(f"a price is a number greater than 0: {value:g}")
            self.prices = self.prices._replace(**{name: value})
        elif name in self.regions:
            if not 0 <= value < float("inf"):
                raise Malformed(f"a risk is a number not below 0: {value:g}")
            self.risks[name] = value
        else:
            raise NotFound(self.missing(name, [*Prices._fields, *self.regions]))

    def price_between(self, before: Pose, now: Pose) -> float:
        """Return what one step costs, for the hand as it is."""
        step = self.prices.carry if self.holding else self.prices.move
        far = abs(now[0] - before[0]) + abs(now[1] - before[1])
        turn = self.prices.turn if now[2] != before[2] else 0.0
        return far * (step + self.risk_at(now[:2])) + turn

    def blocked(self, poses: Mapping[str, Pose], ignored: Iterable[str] = ()) -> Cells:
        """Return the places taken by walls and by things at these poses."""
        taken = set(self.walls)
        for name, thing in self.things.items():
            if name not in ignored:
                taken |= cells_of(thing.shape, poses[name])
        return frozenset(taken)

    def add(self, name: str, thing: Thing) -> None:
        """Make a thing known.

        Raises:
            Malformed: The name is taken, or something else is known to be there.
        """
        self._check_name(name)
        self._check_cells(cells_of(thing.shape, thing.pose))
        self.things[name] = thing

    def add_region(self, name: str, places: tuple[Place, ...]) -> None:
        """Make a region known, or one place if there is only one.

        Raises:
            Malformed: The name is taken, or there is no such place.
        """
        self._check_name(name)
        self._check_inside(places)
        self.regions[name] = places

    def add_place(self, name: str, place: Place) -> None:
        """Give a place a name.

        Raises:
            Malformed: The name is taken, or there is no such place.
        """
        self._check_name(name)
        self._check_inside([place])
        self.places[name] = place

    def add_walls(self, places: Iterable[Place]) -> None:
        """Make walls known.

        Raises:
            Malformed: There is no such place, or something else is there.
        """
        self._check_cells(places)
        self.walls |= {*places}

    def forget(self, name: str) -> None:
        """Forget a name.

        Raises:
            NotFound: There is none.
            Malformed: It is held.
        """
        if name == self.holding and name:
            raise Malformed(f"{name} is in the jaws")
        for group in (self.things, self.places, self.regions):
            if name in group:
                del group[name]
                self.risks.pop(name, None)
                return
        raise NotFound(self.missing(name))

    def rename(self, old: str, new: str) -> None:
        """Name a thing that was found.

        Raises:
            Malformed: The name is taken.
        """
        self._check_name(new)
        self.things = {new if name == old else name: each for name, each in self.things.items()}
        self.things[new].is_named = True
        if self.holding == old:
            self.holding = new

    def thing(self, name: str) -> str:
        """Return the name of a thing.

        Raises:
            NotFound: There is no such thing.
        """
        if name not in self.things:
            raise NotFound(self.missing(name, self.things))
        return name

    def missing(self, name: str, among: Iterable[str] = ()) -> str:
        """Return what is told of a name that nothing has."""
        near = get_close_matches(name, [*(among or self.names())], 1)
        return f"nothing is called {name}{f' (did you mean {near[0]}?)' if near else ''}"

    def anchor(self, name: str, poses: Mapping[str, Pose]) -> tuple[Place, ...]:
        """Return the places of a thing, a named place or a region.

        Raises:
            NotFound: Nothing has that name.
        """
        if name in self.things:
            return tuple(sorted(cells_of(self.things[name].shape, poses[name])))
        if name in self.places:
            return (self.places[name],)
        if name in self.regions:
            return self.regions[name]
        raise NotFound(self.missing(name))

    def resolve(self, target: Target, poses: Mapping[str, Pose]) -> tuple[Place, ...]:
        """Return the places that satisfy a goal; walls never do.

        Raises:
            NotFound: Nothing has the name in it.
            Malformed: There is no such place.
        """
        if target.relation == "at":
            assert target.place is not None
            self._check_inside([target.place])
            return (target.place,)
        if target.relation in ("in", "was"):
            if target.name in self.things:
                return (poses[target.name][:2],)
            return self.anchor(target.name, poses)
        around = self.anchor(target.name, poses)
        grid = [(x, y) for y in range(1, self.height + 1) for x in range(1, self.width + 1)]
        fits = _RELATIONS[target.relation]
        return tuple(
            place
            for place in grid
            if place not in self.walls
            and place not in around
            and any(fits(place[0] - x, place[1] - y) for x, y in around)
        )

    def _check_name(self, name: str) -> None:
        if name in self.names():
            raise Malformed(f"{name} is a name already: forget {name} first")
        if not name or name == "it" or set(name) & set('();="'):
            raise Malformed(f"cannot be a name: {name!r}")

    def _check_inside(self, places: Iterable[Place]) -> None:
        for place in places:
            if not self.is_inside(place):
                raise Malformed(
                    f"{text_of(place)} is off the table: (1 1) to ({self.width} {self.height})"
                )

    def _check_cells(self, places: Iterable[Place]) -> None:
        self._check_inside(places)
        poses = {name: thing.pose for name, thing in self.things.items()}
        taken = self.blocked(poses) & {*places}
        for place in sorted(taken):
            raise Malformed(f"{text_of(place)} is taken")


_RELATIONS: dict[str, Any] = {
    "near": lambda dx, dy: abs(dx) + abs(dy) <= NEAR,
    "beside": lambda dx, dy: abs(dx) + abs(dy) == 1,
    "left of": lambda dx, dy: -NEAR <= dx < 0 and dy == 0,
    "right of": lambda dx, dy: 0 < dx <= NEAR and dy == 0,
    "above": lambda dx, dy: dx == 0 and 0 < dy <= NEAR,
    "below": lambda dx, dy: dx == 0 and -NEAR <= dy < 0,
}
