"""Frames that services share: poses, and a tree of frames by name.

A pose is a vector ``x y z a b c`` in metres and radians: a is roll, b pitch, c yaw, and the
rotation is Rz(c) Ry(b) Rx(a). The pose of a frame is its place in the frame that it stands in, so
`compose` of both leads from the inner one out. Angles that are returned are in (-pi, pi].
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import rtkit

Pose = tuple[float, ...]
Rows = tuple[tuple[float, ...], ...]
Lookup = Callable[[str], Sequence[float]]
"""Returns the pose of a service or a named frame in the world [m, rad]."""

ORIGIN: Pose = (0.0,) * 6
_LOCKED = 1e-12
"""Cosine of the pitch below which roll and yaw turn about one axis."""
_NO_FRAME = frozenset(["unknown", "no-service", "syntax", "bad-value", "bad-parameter"])
"""Codes of a lookup that tell that there is no such frame."""


def compose(outer: Sequence[float], inner: Sequence[float]) -> Pose:
    """Return a pose that is given in a frame in what that frame stands in [m, rad]."""
    turn = _rotation(outer)
    return _moved(outer, turn, inner) + angles_of(_product(turn, _rotation(inner)))


def inverse(pose: Sequence[float]) -> Pose:
    """Return the pose of what a frame stands in, seen from that frame [m, rad]."""
    back = tuple(zip(*_rotation(pose), strict=True))
    return tuple(-each for each in applied(back, pose[:3])) + angles_of(back)


def transform(pose: Sequence[float], location: Sequence[float]) -> tuple[float, ...]:
    """Return a location of a frame in what the frame stands in, as many numbers as it has.

    Args:
        pose: Of the frame [m, rad].
        location: ``x y``, ``x y z`` or a pose, in that frame [m, rad]; without z it is 0.

    Raises:
        PropertyError: ``bad-value``: it has not 2, 3 or 6 finite numbers.
    """
    if len(_checked(location)) == 6:
        return compose(pose, location)
    return _moved(pose, _rotation(pose), location)[: len(location)]


def plain(numbers: Sequence[float]) -> tuple[float, ...]:
    """Return numbers as they are told: to 1e-9, and a 0 without a sign."""
    return tuple(round(each, 9) + 0.0 for each in numbers)


def transform_covariance(
    pose: Sequence[float], location: Sequence[float], covariance: Sequence[Sequence[float]]
) -> Rows:
    """Return the covariance of a location of a frame in what the frame stands in.

    Args:
        pose: Of the frame [m, rad]; it is taken to be known.
        location: As in `transform`.
        covariance: As many rows and columns as the location has numbers, in squares of its units.

    Raises:
        PropertyError: ``bad-value``: it has another size.
    """
    size = len(_checked(location))
    if len(covariance) != size or any(len(row) != size for row in covariance):
        raise rtkit.PropertyError("bad-value", f"a covariance of {size} numbers is {size} rows")
    turn = _rotation(pose)
    if size < 6:
        slope: Rows = tuple(row[:size] for row in turn[:size])
    else:
        moved = compose(pose, location)
        angular = _product(_inverse_rates(moved), _product(turn, _rates(location)))
        slope = (*((*row, 0.0, 0.0, 0.0) for row in turn), *((0.0, 0.0, 0.0, *r) for r in angular))
    return _product(_product(slope, covariance), tuple(zip(*slope, strict=True)))


def pose_of(location: Sequence[float]) -> Pose:
    """Return the pose of what is at a location: level where it tells no angles [m, rad].

    Raises:
        PropertyError: ``bad-value``: it has not 2, 3 or 6 finite numbers.
    """
    return (*map(float, _checked(location)), *ORIGIN[len(location) :])


def is_number(value: object) -> bool:
    """Return whether a value is a number; true and false are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


class Frames:
    """Tells locations of one frame in another.

    Frames are ``base`` (the own base), ``world``, what was added, and what the lookup knows: names
    of services, which stand for their `location`, and of frames that are kept elsewhere.

    Args:
        lookup: Asked for other names; raises `PropertyError` for one that it does not know.
        base: Returns the pose of the own base in the world [m, rad]; None where there is none.
    """

    def __init__(
        self,
        lookup: Lookup | None = None,
        base: Callable[[], Sequence[float]] | None = None,
    ) -> None:
        self._lookup = lookup
        self._base = base
        self._named: dict[str, tuple[str, Pose]] = {}

    def add(self, name: str, pose: Sequence[float], parent: str = "world") -> None:
        """Add a frame that stands in another one, or put it elsewhere [m, rad].

        Raises:
            PropertyError: ``bad-value``: it is no pose; the name is base or world.
        """
        if name in ("base", "world", ""):
            raise rtkit.PropertyError("bad-value", f"the frame {name} is there already")
        self._named[name] = (parent, pose_of(pose))

    def pose(self, name: str) -> Pose:
        """Return the pose of a frame in the world [m, rad].

        Raises:
            PropertyError: ``bad-parameter``: there is no such frame, or it stands in itself.
        """
        pose, seen = ORIGIN, [name]
        while name in self._named:
            name, inner = self._named[name]
            pose = compose(inner, pose)
            if name in seen:
                raise rtkit.PropertyError("bad-parameter", f"frame stands in itself: {name}")
            seen.append(name)
        return compose(self._root(name), pose)

    def convert(
        self, location: Sequence[float], frame: str = "base", to: str = "world"
    ) -> tuple[float, ...]:
        """Return a location of one frame in another one [m, rad].

        Raises:
            PropertyError: ``bad-parameter``: there is no such frame.
        """
        if frame == to:
            return plain(_checked(location))
        return plain(transform(self.between(frame, to), location))

    def between(self, frame: str, to: str) -> Pose:
        """Return the pose of one frame in another one [m, rad].

        Raises:
            PropertyError: ``bad-parameter``: there is no such frame.
        """
        return compose(inverse(self.pose(to)), self.pose(frame))

    def _root(self, name: str) -> Pose:
        """Return the pose of a frame that stands in the world."""
        if name == "world":
            return ORIGIN
        if name == "base" and self._base is not None:
            return pose_of(self._base())
        if name in ("base", "") or self._lookup is None:
            raise rtkit.PropertyError("bad-parameter", f"no frame: {name}")
        try:
            return pose_of(self._lookup(name))
        except rtkit.PropertyError as error:
            if error.code not in _NO_FRAME:
                raise  # it may be there, and is only silent now
            raise rtkit.PropertyError("bad-parameter", f"no frame: {name} ({error})") from None


def _checked(location: Sequence[float]) -> Sequence[float]:
    if len(location) not in (2, 3, 6):
        raise rtkit.PropertyError("bad-value", f"a location has 2, 3 or 6 numbers, not {location}")
    if not all(is_number(each) and math.isfinite(each) for each in location):
        raise rtkit.PropertyError("bad-value", f"a location has finite numbers, not {location}")
    return location


def _rotation(pose: Sequence[float]) -> Rows:
    """Return the rotation of a pose as three rows."""
    a, b, c = pose_of(pose)[3:]
    ca, sa, cb, sb, cc, sc = (
        math.cos(a), math.sin(a), math.cos(b), math.sin(b), math.cos(c), math.sin(c)
    )  # fmt: skip
    return (
        (cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa),
        (sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa),
        (-sb, cb * sa, cb * ca),
    )


def angles_of(turn: Rows) -> Pose:
    """Return roll, pitch and yaw of a rotation [rad]; upright or head down, all turning is yaw."""
    flat = math.hypot(turn[0][0], turn[1][0])
    pitch = math.atan2(-turn[2][0], flat)
    if flat < _LOCKED:
        return 0.0, pitch, math.atan2(-turn[0][1], turn[1][1])
    return math.atan2(turn[2][1], turn[2][2]), pitch, math.atan2(turn[1][0], turn[0][0])


def _rates(pose: Sequence[float]) -> Rows:
    """Return what makes the turning of what changes its three angles."""
    _, b, c = pose_of(pose)[3:]
    return (
        (math.cos(c) * math.cos(b), -math.sin(c), 0.0),
        (math.sin(c) * math.cos(b), math.cos(c), 0.0),
        (-math.sin(b), 0.0, 1.0),
    )


def _inverse_rates(pose: Sequence[float]) -> Rows:
    _, b, c = pose[3:]
    flat = math.copysign(max(abs(math.cos(b)), _LOCKED), math.cos(b))
    x, y = math.cos(c) / flat, math.sin(c) / flat
    return (
        (x, y, 0.0),
        (-math.sin(c), math.cos(c), 0.0),
        (x * math.sin(b), y * math.sin(b), 1.0),
    )


def _moved(pose: Sequence[float], turn: Rows, location: Sequence[float]) -> Pose:
    there = applied(turn, (*location[:3], 0.0)[:3])
    return tuple(own + far for own, far in zip(pose_of(pose), there, strict=False))


def applied(rows: Rows, vector: Sequence[float]) -> Pose:
    """Return the product of a matrix and a vector."""
    return tuple(sum(a * b for a, b in zip(row, vector, strict=True)) for row in rows)


def _product(left: Sequence[Sequence[float]], right: Sequence[Sequence[float]]) -> Rows:
    columns = tuple(zip(*right, strict=True))
    return tuple(applied(columns, row) for row in left)
