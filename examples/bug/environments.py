"""Environments: worlds with a start and a goal, read from JSON, and what geometry says of them."""

from __future__ import annotations

import heapq
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, pairwise
from math import hypot, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rtkit.errors import InvalidDocument, Malformed

if TYPE_CHECKING:
    from rtkit.world import Scene

    from .assembly import Assembly

Point = tuple[float, float]
Ring = tuple[Point, ...]
SHIPPED = Path(__file__).parent / "worlds.json"
_EPS = 1e-9
_KEYS = frozenset(
    ("start", "goal", "obstacles", "reachable", "body_radius", "goal_margin", "note", "heading")
)


@dataclass(frozen=True)
class Environment:
    """A world with its task.

    Attributes:
        name: Its name.
        start: Where the robot begins [m].
        goal: Where it is to go [m].
        obstacles: The rings of each: outer, then holes [m].
        reachable: The right answer; None where it is not told.
        body_radius: Of the robot [m].
        goal_margin: How near is there [m].
        note: What it is for.
        heading: Of the robot at the start [rad].
    """

    name: str
    start: Point
    goal: Point
    obstacles: tuple[tuple[Ring, ...], ...] = ()
    reachable: bool | None = None
    body_radius: float = 0.10
    goal_margin: float = 0.30
    note: str = ""
    heading: float = 0.0

    @cached_property
    def scene(self) -> Scene:
        """Its walls."""
        from rtkit.world import Polygon, Scene

        return Scene([Polygon(outer, holes) for outer, *holes in self.obstacles])


def shipped() -> dict[str, Environment]:
    """Return the worlds that ship with this example, by their names."""
    return read_environments(SHIPPED.read_text("utf-8"), SHIPPED.name)


def read_environments(document: str | Mapping[str, Any], name: str) -> dict[str, Environment]:
    """Return the environments of a document by their names.

    Args:
        document: Text of JSON, or what it says.
        name: Of the file, for messages.

    Raises:
        InvalidDocument: It does not fit; the message has the place.
    """
    if isinstance(document, str):
        try:
            document = json.loads(document)
        except ValueError as error:
            raise InvalidDocument(f"{name}: {error}") from None
    if not isinstance(document, Mapping) or not document:
        raise InvalidDocument(f"{name}: an object of environments by their names is needed")
    return {key: _environment(key, value, f"{name}: {key}") for key, value in document.items()}


def _environment(name: str, value: Any, at: str) -> Environment:
    if not isinstance(value, Mapping):
        raise InvalidDocument(f"{at}: an object is needed, not {_shown(value)}")
    for key in value:
        if key not in _KEYS:
            raise InvalidDocument(f"{at}.{key}: no such key; there are {', '.join(sorted(_KEYS))}")
    for key in ("start", "goal", "obstacles"):
        if key not in value:
            raise InvalidDocument(f"{at}: {key} is missing")
    obstacles = value["obstacles"]
    if not isinstance(obstacles, Sequence) or isinstance(obstacles, str):
        raise InvalidDocument(f"{at}.obstacles: a list is needed, not {_shown(obstacles)}")
    reachable = value.get("reachable")
    if reachable is not None and not isinstance(reachable, bool):
        raise InvalidDocument(f"{at}.reachable: true or false is needed, not {_shown(reachable)}")
    made = Environment(
        name=name,
        start=_point(value["start"], f"{at}.start"),
        goal=_point(value["goal"], f"{at}.goal"),
        obstacles=tuple(_rings(each, f"{at}.obstacles[{i}]") for i, each in enumerate(obstacles)),
        reachable=reachable,
        body_radius=_length(value, "body_radius", 0.10, at),
        goal_margin=_length(value, "goal_margin", 0.30, at),
        note=str(value.get("note", "")),
        heading=_number(value.get("heading", 0.0), f"{at}.heading"),
    )
    if (gap := made.scene.distance(made.start)) < made.body_radius:
        raise InvalidDocument(
            f"{at}.start: the body of {made.body_radius:g} m is in a wall: {gap:.3g} m from it"
        )
    return made


def _rings(value: Any, at: str) -> tuple[Ring, ...]:
    from rtkit.world import Polygon

    if not isinstance(value, Mapping) or "outer" not in value:
        raise InvalidDocument(f"{at}: an object with a ring, outer, is needed")
    for key in value:
        if key not in ("outer", "holes"):
            raise InvalidDocument(f"{at}.{key}: no such key; there are holes, outer")
    holes = value.get("holes", ())
    if not isinstance(holes, Sequence) or isinstance(holes, str):
        raise InvalidDocument(f"{at}.holes: a list is needed, not {_shown(holes)}")
    places = [f"{at}.outer", *(f"{at}.holes[{i}]" for i in range(len(holes)))]
    rings = []
    for ring, place in zip((value["outer"], *holes), places, strict=True):
        if not isinstance(ring, Sequence) or isinstance(ring, str):
            raise InvalidDocument(f"{place}: a list of corners is needed, not {_shown(ring)}")
        rings.append(tuple(_point(each, f"{place}[{i}]") for i, each in enumerate(ring)))
        try:
            Polygon(rings[-1])
        except Malformed as error:
            raise InvalidDocument(f"{place}: {error}") from None
        if len(rings) > 1 and not _is_in(rings[-1], rings[:-1]):
            raise InvalidDocument(f"{place}: a hole is inside of outer, and touches no other ring")
    return tuple(rings)


def _is_in(hole: Ring, rings: Sequence[Ring]) -> bool:
    """Return whether a ring lies in what the outer one and the holes before it leave solid."""
    from rtkit.world import Polygon, Scene

    solid = Scene([Polygon(rings[0], rings[1:])])
    edges = [edge for ring in rings for edge in _edges(ring)]
    return all(solid.distance(corner) < -_EPS for corner in hole) and not any(
        _crosses(*one, *other) for one in _edges(hole) for other in edges
    )


def _point(value: Any, at: str) -> Point:
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 2:
        raise InvalidDocument(f"{at}: a pair of metres is needed, not {_shown(value)}")
    return _number(value[0], at), _number(value[1], at)


def _number(value: Any, at: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise InvalidDocument(f"{at}: a number is needed, not {_shown(value)}")
    return float(value)


def _length(value: Mapping[str, Any], key: str, default: float, at: str) -> float:
    found = _number(value.get(key, default), f"{at}.{key}")
    if found <= 0:
        raise InvalidDocument(f"{at}.{key}: more than 0 m is needed, not {found:g}")
    return found


def _shown(value: Any) -> str:
    text = json.dumps(value, default=str)
    return text if len(text) <= 40 else f"{text[:37]}..."


def shortest(environment: Environment) -> float | None:
    """Return the length of the shortest path of a point robot [m]; None where there is none."""
    corners = {p for rings in environment.obstacles for ring in rings for p in ring}
    nodes = [environment.start, environment.goal, *sorted(corners)]
    edges = [edge for rings in environment.obstacles for ring in rings for edge in _edges(ring)]
    ways: dict[int, list[tuple[int, float]]] = {at: [] for at in range(len(nodes))}
    for a, b in combinations(range(len(nodes)), 2):
        if _is_free(nodes[a], nodes[b], edges, environment.scene):
            length = hypot(nodes[a][0] - nodes[b][0], nodes[a][1] - nodes[b][1])
            ways[a].append((b, length))
            ways[b].append((a, length))
    queue, done = [(0.0, 0)], set()
    while queue:
        length, at = heapq.heappop(queue)
        if at == 1:
            return length
        if at not in done:
            done.add(at)
            for other, more in ways[at]:
                heapq.heappush(queue, (length + more, other))
    return None


def bound(environment: Environment, assembly: Assembly) -> float | None:
    """Return the published bound of a point robot's path [m]; None where there is none.

    It is D, and of each obstacle that counts so many times its perimeter: one number, or that
    number for each crossing of the m-line, or for each local minimum of the distance to the goal.
    """
    if not assembly.bound:
        return None
    start, goal = environment.start, environment.goal
    far = hypot(goal[0] - start[0], goal[1] - start[1])
    total = far
    for rings in environment.obstacles:
        edges = [edge for ring in rings for edge in _edges(ring)]
        crossings = sum(_crosses(start, goal, *edge) for edge in edges)
        is_met = min(_gap(goal, *edge) for edge in edges) <= far
        if not (crossings if assembly.bound.over == "m-line" else is_met):
            continue
        perimeter = max(sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in _edges(r)) for r in rings)
        minima = sum(_minima(goal, ring) for ring in rings)
        total += perimeter * (
            assembly.bound.each
            + assembly.bound.crossing * crossings
            + assembly.bound.minimum * minima
        )
    return total


def _edges(ring: Ring) -> list[tuple[Point, Point]]:
    return [(ring[at - 1], ring[at]) for at in range(len(ring))]


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _crosses(p: Point, q: Point, a: Point, b: Point) -> bool:
    """Return whether an edge crosses a segment; one that ends on it counts for one of its ends."""
    return (_turn(p, q, a) > 0) != (_turn(p, q, b) > 0) and (_turn(a, b, p) > 0) != (
        _turn(a, b, q) > 0
    )


def _foot(p: Point, a: Point, b: Point) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    along = ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (dx * dx + dy * dy)
    return min(max(along, 0.0), 1.0)


def _gap(p: Point, a: Point, b: Point) -> float:
    at = _foot(p, a, b)
    return hypot(a[0] + at * (b[0] - a[0]) - p[0], a[1] + at * (b[1] - a[1]) - p[1])


def _minima(goal: Point, ring: Ring) -> int:
    """Count the local minima of the distance to the goal along a ring."""
    edges = _edges(ring)
    inside = sum(0 < _foot(goal, a, b) < 1 for a, b in edges)
    corners = sum(
        _foot(goal, *edges[at - 1]) == 1 and _foot(goal, *edges[at]) == 0
        for at in range(len(edges))
    )
    return inside + corners


def _is_free(p: Point, q: Point, edges: list[tuple[Point, Point]], scene: Scene) -> bool:
    """Return whether a point may go straight from one place to another, also along walls."""
    if p == q:
        return True
    cuts = {0.0, 1.0}
    for a, b in edges:
        pa, pb, ap, aq = _turn(p, q, a), _turn(p, q, b), _turn(a, b, p), _turn(a, b, q)
        if ap * aq < -_EPS and pa * pb < -_EPS:
            return False
        if ap * aq <= 0 and ap != aq:
            cuts.add(ap / (ap - aq))
        for corner, side in ((a, pa), (b, pb)):
            if abs(side) < _EPS:
                cuts.add(_foot(corner, p, q))
    at = sorted(cuts)
    middles = [(one + two) / 2 for one, two in pairwise(at) if two - one > _EPS]
    return all(
        scene.distance((p[0] + m * (q[0] - p[0]), p[1] + m * (q[1] - p[1]))) > -_EPS
        for m in middles
    )
