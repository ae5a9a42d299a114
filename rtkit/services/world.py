"""World service: a simulated home with walls, rooms, lights, objects, and the bodies of robots.

Whoever owns a body moves it and hears how far it came; whose process ends leaves its body standing.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final

import rtkit
from rtkit.errors import InvalidDocument, Malformed, RtkitError
from rtkit.world import Ball, Body, Polygon, Pose, Scene, photo, png

Place = tuple[float, float, float]
"""x, y and heading [m, rad]."""
Row = tuple[float, ...]
_DARK = 0.25
_MOST_RAYS = 10_000
_EYE_SHIFT = 0.01
_PATIENCE_S = 5.0
_LONGEST_MOVE = 1.0
"""How far ahead whoever moves a body may move it in one request [s]."""


class Standing:
    """Body of a robot in the world: a disc that walls stop."""

    def __init__(self, body: Body, height: float) -> None:
        self.radius: Final = body.radius
        self.height: Final = height
        self._body = body

    def get_location(self) -> Annotated[tuple[float, ...], rtkit.Unit("m")]:
        """Place in the world: x y z a b c."""
        x, y, theta = self._body.pose
        return x, y, 0.0, 0.0, 0.0, theta

    def get_collisions(self) -> int:
        """Times that it was pressed into a wall."""
        return self._body.collisions


def push(body: Body, twist: Sequence[float], seconds: float) -> None:
    """Move a body as far as nothing is in its way; what touches a wall may still turn."""
    spent = body.move(twist[0], twist[1], twist[2], seconds)
    if body.contact is not None and twist[2]:
        body.move(0.0, 0.0, twist[2], seconds - spent)


class HomeWorld:
    """Simulated home: robots move their bodies in it, and see what is there.

    Args:
        file: JSON of an object with ``walls`` (each a ring of corners, or ``outer`` and ``holes``),
            ``rooms`` (a ring of corners by name) and ``objects`` (parts of a marker by name; of the
            type ``light`` with ``on``); none: an empty plain.
        pace: How many times as fast as real time robots move; 0: they are moved by hand.

    Attributes:
        objects: Markers in the frame of the world, by name.
        rooms: The corners of each room [m].
        bodies: Of robots, by name.
    """

    type: Final = ("world",)
    version: Final = "1.0"
    status: Final = "ready"

    def __init__(self, *, file: str = "", pace: float = 1.0) -> None:
        self.pace: Final = float(pace)
        if not 0 <= self.pace < math.inf:
            raise Malformed(f"pace is 0 or more, not {pace}")
        self.objects: dict[str, rtkit.Marker] = {}
        self.rooms: dict[str, tuple[tuple[float, float], ...]] = {}
        self.bodies: dict[str, Standing] = {}
        self._bodies: dict[str, Body] = {}
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
        if unknown := document.keys() - {"walls", "rooms", "objects"}:
            raise Malformed(f"no such key: {' '.join(sorted(unknown))}")
        polygons = [
            Polygon(**wall) if isinstance(wall, dict) else Polygon(wall)
            for wall in document.get("walls", ())
        ]
        rooms = {name: Polygon(ring).outer for name, ring in document.get("rooms", {}).items()}
        objects = {}
        for name, parts in document.get("objects", {}).items():
            try:
                objects[name] = rtkit.Marker(**{"id": name, "frame": "world", **parts})
            except (TypeError, rtkit.PropertyError) as error:
                raise Malformed(f"objects.{name}: {error}") from error
        self._scene, self.rooms, self.objects = Scene(polygons), rooms, objects

    # bodies

    def join(
        self, name: str, at: Place = (0.0, 0.0, 0.0), radius: float = 0.15, height: float = 0.3
    ) -> None:
        """Put a body of a name into the world, or the one of that name elsewhere."""
        with self._lock:
            body = Body(self._scene, Pose(*at), radius)
            self._bodies[name] = body
            self.bodies = {**self.bodies, name: Standing(body, height)}

    def leave(self, name: str) -> None:
        """Take a body out."""
        with self._lock:
            self._bodies.pop(name, None)
            self.bodies = {each: body for each, body in self.bodies.items() if each != name}

    def set_moves(self, moves: list[tuple[str, float, float, float, float]]) -> None:
        """Bodies to move now: name, speed ahead and to the left, turning, and how long.

        Metres, radians, seconds. A wall stops a body; one that is not there is left out.
        """
        with self._lock:
            for name, *twist, seconds in moves:
                if name in self._bodies:
                    push(self._bodies[name], twist, min(seconds, _LONGEST_MOVE))

    def get_poses(self, names: Sequence[str] = ()) -> list[Row]:
        """Of each body x, y and heading; of one that is not there nothing."""
        with self._lock:
            return [self._bodies[name].pose if name in self._bodies else () for name in names]

    # objects

    def put(self, name: str, marker: rtkit.Marker) -> None:
        """Put an object into the world, or elsewhere; its location is in the frame world."""
        self.objects = {**self.objects, name: marker.with_(id=name, frame="world")}

    def take(self, name: str) -> None:
        """Take an object out."""
        self.objects = {each: marker for each, marker in self.objects.items() if each != name}

    # what is to be seen

    def get_ranges(
        self,
        at: Place = (0.0, 0.0, 0.0),
        count: int = 181,
        field: float = math.pi,
        reach: float = 4.0,
    ) -> Annotated[tuple[float, ...], rtkit.Unit("m")]:
        """Free way along rays that are spread over a field, from the right to the left."""
        if not 0 < count <= _MOST_RAYS:
            raise rtkit.PropertyError("bad-parameter", f"1 to {_MOST_RAYS} rays, not {count}")
        first, step = at[2] - field / 2, field / max(count - 1, 1)
        bearings = [first + number * step for number in range(count)]
        with self._lock:
            return tuple(self._scene.rays(at[:2], bearings, reach).tolist())

    def get_seen(
        self, at: Place = (0.0, 0.0, 0.0), field: float = 1.2, reach: float = 5.0
    ) -> list[rtkit.Marker]:
        """Objects and bodies in a field of view that no wall hides, in the frame of the world."""
        bodies = [
            rtkit.Marker(body.get_location(), id=name, name=name, type="robot", frame="world")
            for name, body in self.bodies.items()
        ]
        return [each for each in (*self.objects.values(), *bodies)
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
        for marker in self.objects.values():
            size = marker.size if isinstance(marker.size, float) else 0.2
            centre = (*(marker.location or ()), size / 2)[:3]
            glows = bool(marker.features.get("on"))
            if len(centre) == 3:
                colour = tuple(marker.features.get("color", (0.8, 0.1, 0.1)))
                found.append(Ball(centre, size / 2, colour, glows))
        for body in self.bodies.values():
            x, y, *_ = body.get_location()
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
        lights = [each for each in self.objects.values() if each.type == "light" and each.location]
        lights = [each for each in lights if self._room_of(each) == room]
        is_lit = not lights or any(each.features.get("on") for each in lights)
        return 1.0 if is_lit else _DARK

    def _room_of(self, marker: rtkit.Marker) -> str:
        x, y, *_ = marker.location or (math.inf, math.inf)
        return self.get_room((x, y))


def _is_inside(ring: Sequence[Sequence[float]], at: Sequence[float]) -> bool:
    x, y = at
    crossed = False
    for (ax, ay), (bx, by) in zip(ring, (*ring[1:], ring[0]), strict=True):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            crossed = not crossed
    return crossed


class RemoteWorld:
    """World service elsewhere, asked through a client as if it were here.

    Args:
        name: Of the service.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._client = rtkit.Client()
        self._pace: float | None = None
        self.join = partial(self._call, "join")
        self.leave = partial(self._call, "leave")

    @property
    def pace(self) -> float:
        """Return how fast robots move there; 1 until it has answered."""
        if self._pace is None:
            with suppress(RtkitError):
                self._pace = float(self.get_pace())
        return 1.0 if self._pace is None else self._pace

    def close(self) -> None:
        """Ask it no longer."""
        self._client.close()

    def set_moves(self, moves: Sequence[tuple[str, float, float, float, float]]) -> None:
        """Move bodies; see `HomeWorld`."""
        self._client.set(f"{self._name}.moves", moves)

    def _call(self, action: str, *arguments: Any) -> None:
        """Call an action; while another process has called it, try again."""
        until = time.monotonic() + _PATIENCE_S
        while True:
            try:
                self._client.call(f"{self._name}.{action}", *arguments, timeout_s=_PATIENCE_S)
            except rtkit.PropertyError as error:
                if error.code != "busy" or time.monotonic() > until:
                    raise
                time.sleep(0.01)
            else:
                return

    def __getattr__(self, name: str) -> Any:
        """Return what gets a property: ``get_image(width=100)``."""
        if not name.startswith("get_"):
            raise AttributeError(name)
        return lambda **parameters: self._client.get(f"{self._name}.{name[4:]}", **parameters)


HomeWorldInit = rtkit.init_of(HomeWorld)
