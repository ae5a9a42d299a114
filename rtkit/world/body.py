"""Body that moves in a scene until it touches something, and the bumper round it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rtkit.errors import Malformed, Refused
from rtkit.world.contact import NO_DISCS, TOLERANCE, Contact
from rtkit.world.scene import Scene
from rtkit.world.shapes import Pose, moved

if TYPE_CHECKING:
    from rtkit.world.contact import Floats

_PRESSED = 0.01
"""How far a body may be pressed against a wall before that counts as a collision [m]."""


class Body:
    """A disc, or a point, that moves along exact arcs; a contact stops it.

    Args:
        scene: Where it moves; objects may move meanwhile.
        pose: Where it begins.
        radius: Of the disc [m]; 0 for a point.

    Attributes:
        collisions: How many times it was pressed against a wall by more than 0.01 m; pressing on
            counts once, until it has moved again.
        pressed: How far its motion would have gone into what it touches, since it stopped [m].
        contact: What stopped the last move; None if nothing did.

    Raises:
        Malformed: The radius is below 0.
        Refused: It overlaps a solid.
    """

    def __init__(self, scene: Scene, pose: Pose, radius: float = 0.0) -> None:
        if not 0 <= radius < math.inf:
            raise Malformed(f"a radius is 0 or more, not {radius:g}")
        if scene.distance(pose[:2]) < radius - TOLERANCE:
            raise Refused(f"a body of radius {radius:g} at ({pose.x:g}, {pose.y:g}) is in a wall")
        self.radius = radius
        self.collisions = 0
        self.pressed = 0.0
        self.contact: Contact | None = None
        self._scene = scene
        self._pose = Pose(*pose)
        self._room = 0.0
        self._version = scene.version - 1

    @property
    def scene(self) -> Scene:
        """The scene in which it moves."""
        return self._scene

    @property
    def pose(self) -> Pose:
        """Its place and heading; setting it puts it elsewhere, whatever is on the way."""
        return self._pose

    @pose.setter
    def pose(self, pose: Pose) -> None:
        self._pose = Pose(*pose)
        self._room = 0.0
        self.contact, self.pressed = None, 0.0

    @property
    def clearance(self) -> float:
        """The distance of its centre from the nearest wall [m], below 0 inside of a solid."""
        return self._scene.distance(self._pose[:2])

    @property
    def is_touching(self) -> bool:
        """Return whether its rim is at a wall."""
        return self._scene.gap(self._pose[:2]) <= self.radius + 2 * TOLERANCE

    @property
    def touched_objects(self) -> tuple[str, ...]:
        """The names of the objects that it touches."""
        return self._scene.touched(self._pose[:2], self.radius)

    def move(
        self, vx: float, vy: float, omega: float, dt: float, discs: Floats = NO_DISCS
    ) -> float:
        """Move with a twist in its own frame, as far as nothing is in the way.

        Args:
            vx: Speed ahead [m/s].
            vy: Speed to the left [m/s]; 0 for a differential robot.
            omega: Turning, counter-clockwise [rad/s].
            dt: How long [s].
            discs: What is in the way besides the scene: x, y and radius in each row [m].

        Returns:
            How long it moved before a contact stopped it [s]; `dt` if none did.
        """
        path = math.hypot(vx, vy) * dt
        self.contact = None
        if path and (len(discs) or not self._has_room(path)):
            twist = vx, vy, omega
            self.contact = self._scene.contact(self._pose, self.radius, twist, dt, discs)
        time = dt if self.contact is None else self.contact.time
        start, self._pose = self._pose, moved(self._pose, vx, vy, omega, time)
        self._room -= path
        if self.contact is not None:
            self._press(self.contact, moved(start, vx, vy, omega, dt), time > 0)
        elif path:
            self.pressed = 0.0
        return time

    def _has_room(self, path: float) -> bool:
        """Return whether nothing can be met on so short a way [m]."""
        if self._version != self._scene.version or self._room <= path:
            self._room = self._scene.gap(self._pose[:2]) - self.radius
            self._version = self._scene.version
        return self._room > path

    def _press(self, contact: Contact, wanted: Pose, has_moved: bool) -> None:
        """Note how far a motion would have gone into a wall."""
        was = 0.0 if has_moved else self.pressed
        nx, ny = contact.normal
        depth = (self._pose.x - wanted.x) * nx + (self._pose.y - wanted.y) * ny
        self.pressed = was + max(0.0, depth)
        if was <= _PRESSED < self.pressed:
            self.collisions += 1


class Bumper:
    """Switches round a body; one closes when a wall is next to its sector.

    Args:
        sectors: How many, of the same width; the middle of the first one is ahead, the others
            follow counter-clockwise.
        reach: How far from the rim a wall closes a switch [m].
    """

    def __init__(self, sectors: int = 6, reach: float = 0.01) -> None:
        if sectors < 1 or not reach >= 0:
            raise Malformed("a bumper has at least one sector, and a reach of 0 or more")
        self.sectors = sectors
        self.reach = reach

    def closed(self, body: Body) -> tuple[bool, ...]:
        """Return of each switch whether it is closed."""
        limit = body.radius + self.reach + TOLERANCE
        scene, (x, y, theta) = body.scene, body.pose
        if scene.gap((x, y)) > limit:
            return (False,) * self.sectors
        width = math.tau / self.sectors
        bearings = [theta + number * width for number in range(self.sectors)]
        found = scene.cones((x, y), bearings, width, math.inf)
        return tuple(bool(each <= limit) for each in found)
