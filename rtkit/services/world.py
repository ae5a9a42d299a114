"""World service: a simulated home with walls, rooms, lights, objects, and the bodies of robots.

The owner of a body moves it and hears how far it came; when its process ends the body is left
standing.
"""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeVar

import numpy as np

import rtkit
from rtkit.errors import InvalidDocument, Malformed
from rtkit.services.frames import plain, pose_of
from rtkit.world import Ball, Body, Polygon, Pose, Scene, photo, png

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
Place = tuple[float, float, float]
"""x, y and heading [m, rad]."""
Row = tuple[float, ...]
Thing = TypeVar("Thing")
Form = TypeVar("Form", list[Any], dict[str, Any])
_DARK = 0.25
_MOST_RAYS = 10_000
_EYE_SHIFT = 0.01
_TOUCHES = 0.01
_LONGEST_MOVE = 1.0
"""How far ahead whoever moves a body may move it in one request [s]."""


class Standing(Body):
    """Body of a robot in the world: a disc that walls and other bodies stop."""

    def __init__(self, scene: Scene, pose: Pose, radius: float, height: float) -> None:
        super().__init__(scene, pose, radius)
        self.height: Final = height

    def marker(self, name: str) -> rtkit.Marker:
        """Return it as it is seen."""
        x, y, theta = self.pose
        return rtkit.Marker(
            plain((x, y, 0.0, 0.0, 0.0, theta)), id=name, name=name, type="robot", frame="world",
            radius=self.radius, height=self.height,
        )  # fmt: skip

    def push(self, twist: Sequence[float], seconds: float, others: Floats) -> None:
        """Move as far as nothing is in the way; what touches something may still turn."""
        spent = self.move(twist[0], twist[1], twist[2], seconds, others)
        if self.contact is not None and twist[2]:
            self.move(0.0, 0.0, twist[2], seconds - spent)


class Placed(rtkit.Names):
    """Markers in the frame of the world by name; a SET puts one there, or for ``()`` takes it out.

    Args:
        names: Returns the present names, the same object while none comes or goes.
        show: Returns the marker of a name, None where it is gone.
        put: Puts it there, or takes it out for None.
    """

    def __init__(
        self,
        names: Callable[[], Collection[str]],
        show: Callable[[str], rtkit.Marker | None],
        put: Callable[[str, rtkit.Marker | None], None],
    ) -> None:
        self._names, self._show, self._put = names, show, put

    def names(self) -> Collection[str]:
        """See `rtkit.Names.names`."""
        return self._names()

    def stamp(self, name: str) -> object:
        """See `rtkit.Names.stamp`."""
        return self._show(name)

    def get(self, name: str) -> rtkit.Marker | None:
        """See `rtkit.Names.get`."""
        found = self._show(name)
        if found is None:
            raise rtkit.PropertyError("unknown", f"there is none: {name}")
        return found

    def hint(self, name: str) -> Any:
        """See `rtkit.Names.hint`: parts of markers are of any type."""
        return object if "." in name else None

    def set(self, name: str, value: Any) -> None:
        """See `rtkit.Names.set`: a marker, or a part of one that is there, ``lamp.on``."""
        name, _, part = name.partition(".")
        self._put(name, self.get(name).with_(**{part: value}) if part else value)  # type: ignore[union-attr]


class HomeWorld:
    """Simulated home: robots move their bodies in it, and see what is there.

    Args:
        file: JSON of an object with ``walls`` (each a ring of corners, or ``outer`` and ``holes``),
            ``rooms`` (a ring of corners by name) and ``objects`` (parts of a marker by name; of the
            type ``light`` with ``on``); none: an empty plain.
        pace: How many times as fast as real time robots move; 0: they are moved by hand.

    Attributes:
        objects: Markers in the frame of the world, by name: ``SET objects.ball <marker>`` puts one
            there, ``()`` takes it out.
        rooms: The corners of each room [m].
        bodies: Of robots, by name, likewise: markers with ``radius``, ``height`` [m] and how many
            times they were pressed into something, ``collisions``.
    """

    type: Final = ("world",)
    version: Final = "1.0"
    status: Final = "ready"

    def __init__(self, *, file: str = "", pace: float = 1.0) -> None:
        self.pace: Final = float(pace)
        if not 0 <= self.pace < math.inf:
            raise Malformed(f"pace is 0 or more, not {pace}")
        self.rooms: dict[str, tuple[tuple[float, float], ...]] = {}
        self._objects: dict[str, rtkit.Marker] = {}
        self._bodies: dict[str, Standing] = {}
        self.objects: Final = Placed(
            lambda: self._objects, lambda name: self._objects.get(name), self._put_object
        )
        self.bodies: Final = Placed(lambda: self._bodies, self._body, self._put_body)
        self._file = file
        self._scene = Scene()
        self._lock = threading.RLock()

    def __enter__(self) -> HomeWorld:
        if self._file:
            try:
                self._read(json.loads(Path(self._file).read_text("utf-8")))
            except (ValueError, TypeError, AttributeError, Malformed) as error:
                raise InvalidDocument(f"{self._file}: {error}") from error
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def _read(self, document: Mapping[str, Any]) -> None:
        _checked("the document", document, dict)
        if unknown := document.keys() - {"walls", "rooms", "objects"}:
            raise Malformed(f"no such key: {' '.join(sorted(unknown))}")
        walls = _checked("walls", document.get("walls", []), list)
        rings = _checked("rooms", document.get("rooms", {}), dict)
        things = _checked("objects", document.get("objects", {}), dict)
        polygons = [_polygon(f"walls.{at}", wall) for at, wall in enumerate(walls)]
        rooms = {name: _polygon(f"rooms.{name}", ring).outer for name, ring in rings.items()}
        objects = {}
        for name, parts in things.items():
            _checked(f"objects.{name}", parts, dict)
            try:
                objects[name] = rtkit.Marker(**{"id": name, "frame": "world", **parts})
            except (TypeError, rtkit.PropertyError) as error:
                raise Malformed(f"objects.{name}: {error}") from error
        self._scene, self.rooms, self._objects = Scene(polygons), rooms, objects

    def _put_object(self, name: str, marker: rtkit.Marker | None) -> None:
        with self._lock:
            there = marker and marker.with_(id=name, frame="world")
            self._objects = _replaced(self._objects, name, there)

    # bodies

    def _body(self, name: str) -> rtkit.Marker | None:
        body = self._bodies.get(name)
        return None if body is None else body.marker(name).with_(collisions=body.collisions)

    def _put_body(self, name: str, marker: rtkit.Marker | None) -> None:
        with self._lock:
            there = None
            if marker is not None:
                x, y, *_, heading = pose_of(marker.location or ())
                radius, height = (
                    float(marker.features.get(key, usual))
                    for key, usual in (("radius", 0.15), ("height", 0.3))
                )
                there = Standing(self._scene, Pose(x, y, heading), radius, height)
            self._bodies = _replaced(self._bodies, name, there)

    def set_moves(self, moves: list[tuple[str, float, float, float, float]]) -> None:
        """Bodies to move now: name, speed ahead and to the left, turning, and how long.

        Metres, radians, seconds. Walls and other bodies stop a body; one that is not there is left
        out.
        """
        with self._lock:
            discs, rows = self._discs(), {name: row for row, name in enumerate(self._bodies)}
            for name, *twist, seconds in moves:
                if name in rows:
                    body, row = self._bodies[name], rows[name]
                    seconds = min(seconds, _LONGEST_MOVE)
                    reach = body.radius + math.hypot(*twist[:2]) * seconds
                    is_near = _gaps(discs, body.pose) <= reach + _TOUCHES
                    is_near[row] = False
                    body.push(twist, seconds, discs[is_near])
                    discs[row, :2] = body.pose[:2]

    def _discs(self) -> Floats:
        """Return x, y and radius of each body [m]."""
        rows = [(*body.pose[:2], body.radius) for body in self._bodies.values()]
        return np.array(rows).reshape(-1, 3)

    def get_poses(self, names: Sequence[str] = ()) -> list[Row]:
        """Of each body x, y and heading; of one that is not there nothing."""
        with self._lock:
            return [self._bodies[name].pose if name in self._bodies else () for name in names]

    # what is to be seen

    def get_ranges(
        self,
        at: Place = (0.0, 0.0, 0.0),
        count: int = 181,
        field: float = math.pi,
        reach: float = 4.0,
    ) -> Annotated[tuple[float, ...], rtkit.Unit("m")]:
        """Free way along rays that are spread over a field, from the right to the left.

        Walls end it, and bodies, but for one round the place itself.
        """
        if not 0 < count <= _MOST_RAYS:
            raise rtkit.PropertyError("bad-parameter", f"1 to {_MOST_RAYS} rays, not {count}")
        first, step = at[2] - field / 2, field / max(count - 1, 1)
        bearings = [first + number * step for number in range(count)]
        with self._lock:
            discs = self._discs()
            near = discs[_gaps(discs, at) < reach]
            return tuple(self._scene.rays(at[:2], bearings, reach, near).tolist())

    def get_seen(
        self, at: Place = (0.0, 0.0, 0.0), field: float = 1.2, reach: float = 5.0
    ) -> list[rtkit.Marker]:
        """Objects and bodies in a field of view that no wall hides, in the frame of the world."""
        bodies = [body.marker(name) for name, body in self._bodies.items()]
        return [each for each in (*self._objects.values(), *bodies)
                if self._is_seen(each.location or (), at, field, reach)]  # fmt: skip

    def _is_seen(self, there: Sequence[float], at: Place, field: float, reach: float) -> bool:
        if not there:
            return False
        dx, dy = there[0] - at[0], there[1] - at[1]
        far, bearing = math.hypot(dx, dy), math.atan2(dy, dx)
        aside = abs(math.remainder(bearing - at[2], math.tau))
        if not _EYE_SHIFT < far <= reach or aside > field / 2:
            return False
        with self._lock:
            return bool(self._scene.rays(at[:2], [bearing], far)[0] >= far - 1e-6)

    def get_image(
        self,
        at: tuple[float, float, float, float] = (0.0, 0.0, 0.3, 0.0),
        width: int = 320,
        height: int = 240,
        field: float = 1.2,
    ) -> bytes:
        """Picture (PNG) from a place: x, y, z and heading."""
        with self._lock:
            scene, light, balls = self._scene, self.get_light(at[:2]), [*self._balls(at)]
        try:
            pixels = photo(scene, at, balls, width=width, height=height, field=field, light=light)
        except Malformed as error:
            raise rtkit.PropertyError("bad-parameter", str(error)) from None
        return png(pixels)

    def _balls(self, at: Sequence[float]) -> list[Ball]:
        found = []
        for marker in self._objects.values():
            size = marker.size if isinstance(marker.size, float) else 0.2
            centre = (*(marker.location or ()), size / 2)[:3]
            glows = bool(marker.features.get("on"))
            if len(centre) == 3:
                colour = tuple(marker.features.get("color", (0.8, 0.1, 0.1)))
                found.append(Ball(centre, size / 2, colour, glows))
        for body in self._bodies.values():
            x, y, _ = body.pose
            if math.hypot(x - at[0], y - at[1]) > body.radius:
                found.append(Ball((x, y, body.height / 2), body.height / 2, (0.35, 0.4, 0.45)))
        return found

    def get_room(self, at: tuple[float, float] = (0.0, 0.0)) -> str:
        """Name of the room that a place is in; empty outside."""
        inside = (name for name, ring in self.rooms.items() if _is_inside(ring, at))
        return next(inside, "")

    def get_light(self, at: tuple[float, float] = (0.0, 0.0)) -> float:
        """Brightness of a place, 0 to 1: dark where the room has lights and none is on."""
        room = self.get_room(at)
        lights = [each for each in self._objects.values() if each.type == "light" and each.location]
        lights = [each for each in lights if self._room_of(each) == room]
        is_lit = not lights or any(each.features.get("on") for each in lights)
        return 1.0 if is_lit else _DARK

    def _room_of(self, marker: rtkit.Marker) -> str:
        x, y, *_ = marker.location or (math.inf, math.inf)
        return self.get_room((x, y))


def _checked(where: str, value: Any, form: type[Form]) -> Form:
    """Return a value of JSON if it is a list, or an object, as is expected there."""
    if not isinstance(value, form):
        raise Malformed(f"{where}: expected {'a list' if form is list else 'an object'}")
    return value


def _polygon(where: str, wall: Any) -> Polygon:
    """Return the solid of a ring, or of an object with ``outer`` and ``holes``."""
    parts = wall if isinstance(wall, dict) else {"outer": wall}
    if unknown := parts.keys() - {"outer", "holes"}:
        raise Malformed(f"{where}: no such key: {' '.join(sorted(unknown))}")
    try:
        return Polygon(parts.get("outer", ()), _checked("holes", parts.get("holes", []), list))
    except Malformed as error:
        raise Malformed(f"{where}: {error}") from None


def _replaced(kept: dict[str, Thing], name: str, thing: Thing | None) -> dict[str, Thing]:
    """Return things with one of them replaced, or gone for None; a new mapping for other names."""
    if thing is not None and name in kept:
        kept[name] = thing
        return kept
    rest = {each: other for each, other in kept.items() if each != name}
    return rest if thing is None else rest | {name: thing}


def _gaps(discs: Floats, at: Sequence[float]) -> Floats:
    """Return how far each disc is from a place [m], below 0 round it."""
    gaps: Floats = np.hypot(discs[:, 0] - at[0], discs[:, 1] - at[1]) - discs[:, 2]
    return gaps


def _is_inside(ring: Sequence[Sequence[float]], at: Sequence[float]) -> bool:
    x, y = at
    crossed = False
    for (ax, ay), (bx, by) in zip(ring, (*ring[1:], ring[0]), strict=True):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            crossed = not crossed
    return crossed


HomeWorldInit = rtkit.init_of(HomeWorld)
