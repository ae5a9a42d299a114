"""Scene: walls that stand and objects that are added, moved and removed, asked for distances."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from rtkit.errors import NotFound, Refused
from rtkit.world.contact import NO_DISCS, TOLERANCE, Contact, Edges, first_contact
from rtkit.world.shapes import Point, Polygon, Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_WIDEST = math.pi / 2
"""The widest cone that is looked at as a whole [rad]."""


class Scene:
    """Solid polygons, and objects with names, which are polygons at a pose.

    Args:
        polygons: The walls that stay.

    Attributes:
        version: Grows with each change of the objects.
    """

    def __init__(self, polygons: Iterable[Polygon] = ()) -> None:
        self.version = 0
        self._walls = tuple(polygons)
        self._objects: dict[str, tuple[Polygon, Pose]] = {}
        self._rebuild()

    @property
    def walls(self) -> tuple[Polygon, ...]:
        """The polygons that stay."""
        return self._walls

    @property
    def objects(self) -> Mapping[str, Pose]:
        """The pose of each object by its name."""
        return {name: pose for name, (_, pose) in self._objects.items()}

    def add(self, name: str, polygon: Polygon, pose: Pose = Pose()) -> None:  # noqa: B008
        """Add an object, its polygon drawn in its own frame.

        Raises:
            Refused: There is one of that name.
        """
        if name in self._objects:
            raise Refused(f"the scene has an object {name} already")
        self._objects[name] = (polygon, pose)
        self._rebuild()

    def move(self, name: str, pose: Pose) -> None:
        """Put an object elsewhere; what is in its way does not stop it.

        Raises:
            NotFound: There is no such object.
        """
        self._objects[name] = (self.shape(name), pose)
        self._rebuild()

    def remove(self, name: str) -> None:
        """Take an object out.

        Raises:
            NotFound: There is no such object.
        """
        self.shape(name)
        del self._objects[name]
        self._rebuild()

    def shape(self, name: str) -> Polygon:
        """Return the polygon of an object in its own frame.

        Raises:
            NotFound: There is no such object.
        """
        if name not in self._objects:
            raise NotFound(f"the scene has no object {name}")
        return self._objects[name][0]

    def distance(self, point: Sequence[float]) -> float:
        """Return the distance of a point from the nearest wall [m], below 0 inside of a solid.

        Where nothing is, it is infinite.
        """
        gap = self.gap(point)
        return -gap if self._solids_at(point) else gap

    def gap(self, point: Sequence[float]) -> float:
        """Return the distance of a point from the nearest edge [m], inside of a solid, too."""
        return math.sqrt(float(self._squares(point)[1].min(initial=math.inf)))

    def nearest(self, point: Sequence[float]) -> Point:
        """Return the place on a wall that is nearest to a point [m].

        Raises:
            NotFound: There is no wall.
        """
        if not len(self._edges.length):
            raise NotFound("the scene is empty")
        places, squares = self._squares(point)
        row = int(squares.argmin())
        x, y = self._edges.begin[row] + places[row] * self._edges.along[row]
        return float(x), float(y)

    def touched(self, point: Sequence[float], radius: float = 0.0) -> tuple[str, ...]:
        """Return the names of the objects that a disc, or a point, touches or lies in.

        Args:
            point: Its centre [m].
            radius: Of the disc [m]; 0 for a point.
        """
        if not self._objects:
            return ()
        near = self._squares(point)[1] <= (radius + TOLERANCE) ** 2
        rows = {*self._solid_of[near].tolist(), *self._solids_at(point)}
        first = len(self._walls)
        return tuple(name for at, name in enumerate(self._objects, first) if at in rows)

    def rays(
        self,
        point: Sequence[float],
        bearings: Sequence[float],
        reach: float,
        discs: Floats = NO_DISCS,
    ) -> Floats:
        """Return how far rays get from a point outside of the solids, at most `reach` [m].

        Args:
            point: Where they begin [m].
            bearings: Their directions in the frame of the world [rad].
            reach: What is returned where nothing is [m].
            discs: What else stops them, from outside: x, y and radius in each row [m].
        """
        angles = np.asarray(bearings, dtype=np.float64)
        edges = self._edges
        away = edges.begin - (point[0], point[1])
        height = (away * edges.normal).sum(1)  # of the wall over the point, against its normal
        ahead = (away * edges.along).sum(1)
        rise, slide = _along(angles, edges.normal), _along(angles, edges.along)
        # Only what is met from its free side stops a ray: one that begins at a wall may leave it.
        with np.errstate(all="ignore"):
            length = height / rise
        place = length * slide - ahead
        hit = (rise < 0) & (length > -TOLERANCE) & (length < reach)
        hit &= (place >= -TOLERANCE) & (place <= edges.length + TOLERANCE)
        found: Floats = np.where(hit, length, reach).min(1, initial=reach)
        if len(discs):
            away = discs[:, :2] - (point[0], point[1])
            middle, outside = _along(angles, away), (away * away).sum(1) - discs[:, 2] ** 2
            with np.errstate(invalid="ignore"):
                length = middle - np.sqrt(middle * middle - outside)
            hit = (outside >= 0) & (middle > 0) & (length < reach)
            found = np.minimum(found, np.where(hit, length, reach).min(1))
        return np.maximum(found, 0.0, out=found)

    def cone(self, point: Sequence[float], bearing: float, width: float, reach: float) -> float:
        """Return the distance of the nearest place on any wall inside of a cone [m].

        It is exact: no rays are drawn.

        Args:
            point: The tip of the cone, outside of the solids [m].
            bearing: Of its middle, in the frame of the world [rad].
            width: Between its two sides [rad].
            reach: What is returned where nothing is [m].
        """
        return float(self.cones(point, (bearing,), width, reach)[0])

    def cones(
        self, point: Sequence[float], bearings: Sequence[float], width: float, reach: float
    ) -> Floats:
        """Return for several cones of one width and one tip what `cone` returns for each [m]."""
        angles = np.asarray(bearings, dtype=np.float64)
        parts = max(1, math.ceil(width / _WIDEST))
        part = width / parts
        first = angles - (width - part) / 2
        found = self._narrow_cones(point, first, part)
        for more in range(1, parts):
            found = np.minimum(found, self._narrow_cones(point, first + more * part, part))
        return np.minimum(found, reach)

    def contact(
        self,
        pose: Pose,
        radius: float,
        twist: tuple[float, float, float],
        dt: float,
        discs: Floats = NO_DISCS,
    ) -> Contact | None:
        """Return the first contact of a disc, or a point, that moves along its arc; None if free.

        Args:
            pose: Where it begins.
            radius: Of the disc [m]; 0 for a point.
            twist: Speed ahead and to the left [m/s], turning [rad/s].
            dt: How long it is to move [s].
            discs: What else is in the way: x, y and radius in each row [m].
        """
        if not len(self._edges.length) and not len(discs):
            return None
        return first_contact(self._edges, pose, radius, twist, dt, discs)

    def object_of(self, contact: Contact) -> str:
        """Return the name of the object that was met; empty for a wall or a disc."""
        at = int(self._solid_of[contact.edge]) - len(self._walls) if contact.edge >= 0 else -1
        return "" if at < 0 else list(self._objects)[at]

    def _narrow_cones(self, point: Sequence[float], bearings: Floats, width: float) -> Floats:
        edges = self._edges
        begin = edges.begin - (point[0], point[1])
        foot = -(begin * edges.along).sum(1)
        height = -(begin * edges.normal).sum(1)
        low, high = np.zeros((len(bearings), 1)), edges.length[None, :]
        # A point at a wall sees it only where one of the sides of the cone leads into it.
        leads_in = np.zeros((len(bearings), len(edges.length)), dtype=bool)
        for side, bound in (
            (bearings - width / 2, math.pi / 2),
            (bearings + width / 2, -math.pi / 2),
            (bearings, 0.0),
        ):
            leads_in |= _along(side, edges.normal) < -TOLERANCE
            at, slope = _along(side + bound, begin), _along(side + bound, edges.along)
            with np.errstate(all="ignore"):
                cut = -at / slope
            low = np.where(slope > 0, np.maximum(low, cut), low)
            high = np.where(slope < 0, np.minimum(high, cut), high)
            high = np.where((slope == 0) & (at < 0), -1.0, high)
        seen = (height > TOLERANCE) | (leads_in & (height > -TOLERANCE))
        seen = seen & (low <= high + TOLERANCE)
        place = np.clip(foot, low, high) - foot  # huge where a side is all but parallel to a wall
        found: Floats = np.where(seen, np.hypot(height, place), np.inf).min(1, initial=np.inf)
        return found

    def _squares(self, point: Sequence[float]) -> tuple[Floats, Floats]:
        """Return where on each edge it is nearest to a point [m], and its squared distance."""
        edges = self._edges
        away = (point[0], point[1]) - edges.begin
        along = (away * edges.along).sum(1)
        place = np.minimum(np.maximum(along, 0.0), edges.length)
        height = (away * edges.normal).sum(1)
        off = along - place
        return place, height * height + off * off

    def _solids_at(self, point: Sequence[float]) -> list[int]:
        """Return the numbers of the polygons that a point lies in."""
        x, y = point
        below, above = self._edges.begin[:, 1] > y, self._ends[:, 1] > y
        height = -((self._edges.begin - (x, y)) * self._edges.normal).sum(1)
        # To the left of an edge that rises, or to the right of one that falls: a ray crosses it.
        crossed = (below != above) & ((height < 0) == above)
        odd = np.add.reduceat(crossed, self._firsts) % 2
        return [int(at) for at in np.flatnonzero(odd)]

    def _rebuild(self) -> None:
        """Make the arrays anew of what is there."""
        solids = [*self._walls, *(shape.at(pose) for shape, pose in self._objects.values())]
        begins: list[Point] = []
        ends: list[Point] = []
        counts = []
        for solid in solids:
            for ring in solid.rings:
                begins += ring
                ends += (*ring[1:], ring[0])
            counts.append(sum(map(len, solid.rings)))
        begin = np.array(begins, dtype=np.float64).reshape(-1, 2)
        self._ends = np.array(ends, dtype=np.float64).reshape(-1, 2)
        along = self._ends - begin
        length = np.hypot(along[:, 0], along[:, 1])
        along /= length[:, None]
        normal = np.stack((along[:, 1], -along[:, 0]), 1)
        self._edges = Edges(begin, along, normal, length)
        self._solid_of = np.repeat(np.arange(len(solids)), counts)
        self._firsts = np.cumsum([0, *counts[:-1]]) if counts else np.zeros(0, dtype=np.int64)
        self.version += 1


def _along(angles: Floats, vectors: Floats) -> Floats:
    """Return of each direction a row: how far each vector leads along it."""
    x, y = np.cos(angles)[:, None], np.sin(angles)[:, None]
    found: Floats = x * vectors[:, 0] + y * vectors[:, 1]
    return found
