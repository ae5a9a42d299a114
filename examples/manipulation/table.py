"""A simulated plotting table: jaws that travel, turn, grip and feel; things where they really lie.

Everything is geometry of `rtkit.world`: discs of the jaws and of what they hold run into polygons,
and stop there. Above things nothing is felt. Metres, radians, seconds; the middle of place (x y) is
at x and y times `CELL`.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from manipulation.execution import CELL
from manipulation.knowledge import UNIT, cells_of
from manipulation.language import Place
from manipulation.orders import Order, Report
from rtkit.world import Polygon, Pose, Scene, moved

_HAND, _LOAD, _THING = 0.025, 0.026, 0.018
"""Radius of the empty jaws, of each place of a load, half the width of a thing [m]."""
CAPTURE = 0.02
"""How far from their middle the jaws grip, along each axis [m]."""
_ALIGNED = math.radians(20)
_SIDES = ("ahead", "left", "behind", "right")


@dataclass
class Body:
    """A thing as it really is.

    Attributes:
        at: Where the middle of its own place lies [m].
        turned: Its direction [rad].
    """

    at: tuple[float, float]
    shape: tuple[Place, ...] = UNIT
    turned: float = 0.0
    is_bar: bool = False

    def polygons(self) -> list[Polygon]:
        """Return what it fills, in its own frame: squares, and what joins neighbours."""
        pairs = [(one, two) for one in self.shape for two in self.shape if _are_joined(one, two)]
        return [_box(one, two, _THING) for one, two in pairs]


def _are_joined(one: Place, two: Place) -> bool:
    return one <= two and abs(one[0] - two[0]) + abs(one[1] - two[1]) <= 1


def _box(one: Place, two: Place, half: float) -> Polygon:
    left, low = one[0] * CELL - half, one[1] * CELL - half
    right, high = two[0] * CELL + half, two[1] * CELL + half
    return Polygon([(left, low), (right, low), (right, high), (left, high)])


@dataclass
class Table:
    """The table: its walls, the things on it, and the jaws.

    Attributes:
        speed: Of travel [m/s].
        turning: Of turns [rad/s].
        pose: Of the jaws.
        held: The thing between the jaws; empty for none.
    """

    width: int
    height: int
    walls: frozenset[Place]
    things: dict[str, Body]
    pose: Pose
    speed: float = 0.2
    turning: float = 2.0
    held: str = ""
    is_closed: bool = False
    order: Order | None = None
    report: Report = field(default_factory=Report)

    def __post_init__(self) -> None:
        w, h = self.width * CELL, self.height * CELL
        room = [(0.5 * CELL, 0.5 * CELL), (w + 0.5 * CELL, 0.5 * CELL)]
        room += [(w + 0.5 * CELL, h + 0.5 * CELL), (0.5 * CELL, h + 0.5 * CELL)]
        around = Polygon([(-w, -h), (3 * w, -h), (3 * w, 3 * h), (-w, 3 * h)], [room])
        blocks = [_box(wall, wall, CELL / 2) for wall in sorted(self.walls)]
        self.scene = Scene([around, *blocks])
        self._below: set[str] = set()
        for name in self.things:
            self._put(name)
        self._tell("idle")

    def take(self, order: Order) -> None:
        """Begin an order; one that was begun, or is an older one, changes nothing."""
        if order.number > self.report.number:
            self.order = order
            self._below = self._under()
            self._tell("busy", number=order.number)

    def tick(self, seconds: float) -> Report:
        """Go on with the order for some time; return what the sensors tell now."""
        order = self.order
        if order is None:
            return self.report
        if order.kind == "grip":
            self._grip()
        elif order.kind == "release":
            self._release()
        elif order.kind in ("travel", "over", "turn"):
            self._travel(order, seconds)
        else:
            self._end("refused")
        return self.report

    # motion

    def drive(self, vx: float, vy: float, omega: float, seconds: float) -> None:
        """Move the jaws with a twist of their own frame [m/s, rad/s].

        Empty ones go above things and walls; what they hold goes up to the first contact.
        """
        if self.order is None and (vx or vy or omega):
            self._below = self._under()
            cos, sin = math.cos(self.pose.theta), math.sin(self.pose.theta)
            by_hand = Order(kind="travel" if self.held else "over")
            self._advance(cos * vx - sin * vy, sin * vx + cos * vy, omega, seconds, by_hand)

    def _travel(self, order: Order, seconds: float) -> None:
        turn = math.remainder(order.theta - self.pose.theta, math.tau)
        if abs(turn) > 1e-9:
            spent = min(seconds, abs(turn) / self.turning)
            left = abs(turn) - self.turning * spent
            if not self._advance(0.0, 0.0, math.copysign(self.turning, turn), spent, order):
                return
            if left > 1e-9:
                self._tell("busy")
                return
            seconds -= spent
        dx, dy = order.x - self.pose.x, order.y - self.pose.y
        far = math.hypot(dx, dy)
        if far > 1e-9:
            spent = min(seconds, far / self.speed)
            vx, vy = dx / far * self.speed, dy / far * self.speed
            if not self._advance(vx, vy, 0.0, spent, order):
                return
        if math.hypot(order.x - self.pose.x, order.y - self.pose.y) < 1e-6:
            self._end("done")
        else:
            self._tell("busy")

    def _advance(self, vx: float, vy: float, omega: float, seconds: float, order: Order) -> bool:
        """Move the jaws and what they hold up to the first contact; tell whether they got there."""
        first, side, met = seconds, "", (0.0, 0.0)
        if order.kind != "over":
            for centre, radius in self._discs():
                start = Pose(*centre, 0.0)
                rx, ry = centre[0] - self.pose.x, centre[1] - self.pose.y
                twist = (vx - omega * ry, vy + omega * rx, omega)
                contact = self.scene.contact(start, radius, twist, seconds)
                if contact is not None and contact.time < first:
                    first = contact.time
                    at = moved(start, *twist, first)
                    met = (at.x - contact.normal[0] * radius, at.y - contact.normal[1] * radius)
                    side = self._side(contact.normal)
        cos, sin = math.cos(self.pose.theta), math.sin(self.pose.theta)
        self.pose = moved(self.pose, cos * vx + sin * vy, cos * vy - sin * vx, omega, first)
        self._carry()
        if side:
            self._end("touched", contact=side, contact_x=met[0], contact_y=met[1])
            return False
        self._show_left()
        return True

    def _discs(self) -> list[tuple[tuple[float, float], float]]:
        if not self.held:
            return [((self.pose.x, self.pose.y), _HAND)]
        body = self.things[self.held]
        frame = Pose(*body.at, body.turned)
        return [(frame.of((dx * CELL, dy * CELL)), _LOAD) for dx, dy in body.shape]

    def _side(self, normal: tuple[float, float]) -> str:
        bearing = math.atan2(-normal[1], -normal[0]) - self.pose.theta
        return _SIDES[round(math.remainder(bearing, math.tau) / (math.pi / 2)) % 4]

    def _carry(self) -> None:
        if self.held:
            body = self.things[self.held]
            body.at = (self.pose.x, self.pose.y)
            body.turned = self._grasp + self.pose.theta

    # what the jaws stand above is not felt until they have left it

    def _under(self) -> set[str]:
        below = {name for name in self.things if name != self.held and self._overlaps(name)}
        for name in below - self._below:
            self._lift(name)
        return below

    def _overlaps(self, name: str) -> bool:
        alone = Scene(_placed(self.things[name]))
        return any(alone.distance(centre) < radius - 1e-6 for centre, radius in self._discs())

    def _show_left(self) -> None:
        for name in [each for each in self._below if not self._overlaps(each)]:
            self._below.remove(name)
            self._put(name)

    def _put(self, name: str) -> None:
        body = self.things[name]
        for number, polygon in enumerate(body.polygons()):
            self.scene.add(f"{name}/{number}", polygon, Pose(*body.at, body.turned))

    def _lift(self, name: str) -> None:
        for number in range(len(self.things[name].polygons())):
            self.scene.remove(f"{name}/{number}")

    # jaws

    def _grip(self) -> None:
        self.is_closed = True
        if self.held:
            self._end("done")
            return
        near = [(self._off(body), name) for name, body in self.things.items()]
        within = [(off, name) for off, name in near if off <= CAPTURE and self._is_along(name)]
        if not within:
            self.is_closed = False  # they felt nothing, and open again
            self._end("empty")
            return
        self.held = min(within)[1]
        body = self.things[self.held]
        if self.held in self._below:
            self._below.remove(self.held)
        else:
            self._lift(self.held)
        self._grasp = body.turned - self.pose.theta
        self._carry()
        self._end("done")

    def _off(self, body: Body) -> float:
        dx, dy = body.at[0] - self.pose.x, body.at[1] - self.pose.y
        cos, sin = math.cos(self.pose.theta), math.sin(self.pose.theta)
        return max(abs(cos * dx + sin * dy), abs(cos * dy - sin * dx))

    def _is_along(self, name: str) -> bool:
        body = self.things[name]
        apart = math.remainder(body.turned - self.pose.theta, math.pi)
        return not body.is_bar or abs(apart) <= _ALIGNED

    def _release(self) -> None:
        self.is_closed = False
        if self.held:
            # The jaws are still around it: it is felt again once they have left it.
            self._below.add(self.held)
            self.held = ""
        self._end("done")

    def _end(self, outcome: str, **felt: Any) -> None:
        self.order = None
        self._tell(outcome, **felt)

    def _tell(self, outcome: str, **more: Any) -> None:
        pose = self.pose
        self.report = Report(
            number=more.pop("number", self.report.number),
            outcome=outcome,
            x=pose.x,
            y=pose.y,
            theta=pose.theta,
            is_closed=self.is_closed,
            is_gripping=bool(self.held),
            **more,
        )


def _placed(body: Body) -> list[Polygon]:
    return [polygon.at(Pose(*body.at, body.turned)) for polygon in body.polygons()]


def table_of(site: Mapping[str, Any], *, seed: int = 0, displaced: float = 0.5) -> Table:
    """Return the table of a site: each thing up to `displaced` places from where it is told.

    Things do not overlap each other nor walls, and each is nearer to its own place than to that
    of another, so that no search for one finds the other.
    """
    chance = random.Random(seed)
    walls = frozenset((x, y) for x, y in site.get("walls", ()))
    bodies: dict[str, Body] = {}
    told = {f"thing{n}": each for n, each in enumerate(site["things"], 1)}
    for name, each in told.items():
        shape = tuple((dx, dy) for dx, dy in each.get("shape", UNIT))
        others = [other["at"] for other in site["things"] if other is not each]
        most = each.get("displaced", displaced) * CELL
        for _ in range(1000):
            off = (chance.uniform(-most, most), chance.uniform(-most, most))
            x, y = each["at"]
            body = Body(
                (x * CELL + off[0], y * CELL + off[1]), shape, is_bar=each.get("bar", False)
            )
            if _has_room(body, (x, y), walls, bodies, others, site):
                break
        else:
            body = Body((x * CELL, y * CELL), shape, is_bar=each.get("bar", False))
        bodies[name] = body
    hand = site.get("hand", (1, 1))
    return Table(
        site["width"], site["height"], walls, bodies, Pose(hand[0] * CELL, hand[1] * CELL, 0.0)
    )


def _has_room(
    body: Body,
    place: Place,
    walls: frozenset[Place],
    bodies: Mapping[str, Body],
    others: list[list[int]],
    site: Mapping[str, Any],
) -> bool:
    own = cells_of(body.shape, (*place, 0))
    neighbours = [(x + dx, y + dy) for x, y in own for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
    solid = [
        _box(cell, cell, CELL / 2)
        for cell in neighbours
        if cell in walls or not (1 <= cell[0] <= site["width"] and 1 <= cell[1] <= site["height"])
    ]
    scene = Scene([*solid, *(polygon for other in bodies.values() for polygon in _placed(other))])
    frame = Pose(*body.at, 0.0)
    centres = [frame.of((dx * CELL, dy * CELL)) for dx, dy in body.shape]
    if any(scene.distance(centre) < _LOAD for centre in centres):
        return False
    reach = CELL / 3 + CAPTURE + 0.002
    return all(
        max(abs(body.at[0] - x * CELL), abs(body.at[1] - y * CELL)) > reach for x, y in others
    )
