"""Simulation of one robot with its sensors, and a run of a navigator in it, without processes."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from math import hypot
from typing import TYPE_CHECKING, NamedTuple

from rtkit.errors import Malformed
from rtkit.world import Body, Bumper, Noise, Odometry, Pose

from .algorithm import GAVE_UP, PERIOD, Navigator
from .senses import (
    INFRA_RED_BEARINGS,
    INFRA_RED_REACH,
    INFRA_RED_WIDTH,
    LASER_BEARINGS,
    LASER_REACH,
    BumperSenses,
    CombinedSenses,
    InfraRedSenses,
    LaserSenses,
    Senses,
)

if TYPE_CHECKING:
    from .assembly import Assembly
    from .environments import Environment

STEP_LIMIT = 20_000
_PART = 0.05
"""Time between two looks at the clearance [s]."""


class Raw(NamedTuple):
    """What the sensors say in one step; empty where a set-up lacks the sensor.

    Attributes:
        odometry: Where the robot takes itself to be (m, m, rad).
        scan: 181 ranges [m].
        ir: Ranges ahead, left, right [m].
        bumper: Six switches.
    """

    odometry: tuple[float, float, float]
    scan: tuple[float, ...] = ()
    ir: tuple[float, ...] = ()
    bumper: tuple[bool, ...] = ()


SENSES = {
    "laser": lambda raw: LaserSenses(raw.odometry, raw.scan),
    "ir": lambda raw: InfraRedSenses(raw.odometry, raw.ir),
    "laser+ir": lambda raw: CombinedSenses(raw.odometry, raw.scan, raw.ir),
    "bumper": lambda raw: BumperSenses(raw.odometry, raw.bumper),
}
"""Each sensor set-up: what makes the hardware abstractions of raw values."""


def senses_of(sensors: str, raw: Raw) -> Senses:
    """Return the hardware abstractions of a sensor set-up."""
    return SENSES[sensors](raw)


class Simulation:
    """A robot in its environment, moved by a command each control step of 0.5 s.

    Closed switches of the bumper cut the motors: with them contact ends the motion of a step. With
    other sensors the robot is blind to it, and presses on.

    Args:
        environment: Where it is.
        seed: The same seed gives the same noise.
        noise: Standard deviation of ranges [m]; odometry has errors in proportion.
        sensors: Which set-up `raw` measures.

    Raises:
        Malformed: There is no such set-up.
    """

    def __init__(
        self, environment: Environment, seed: int = 0, noise: float = 0.0, sensors: str = "laser"
    ) -> None:
        if sensors not in SENSES:
            raise Malformed(f"there are no sensors {sensors}; there are {', '.join(SENSES)}")
        start = Pose(*environment.start, environment.heading)
        self.sensors = sensors
        self.steps = 0
        self._scene = environment.scene
        self._body = Body(self._scene, start, environment.body_radius)
        self._bumper = Bumper()
        self._noise = Noise(noise, seed)
        self._odometry = Odometry(start, noise, noise, noise, seed)
        self.min_clearance = self._scene.gap(start[:2])

    @property
    def t(self) -> float:
        """Simulated time [s]."""
        return self.steps * PERIOD

    @property
    def pose(self) -> Pose:
        """Where the body truly is."""
        return self._body.pose

    @property
    def collisions(self) -> int:
        """How often the body was pressed into a wall by more than 0.01 m."""
        return self._body.collisions

    def raw(self) -> Raw:
        """Return what the sensors of this step say; ask once a step."""
        pose = self.pose
        found = Raw(tuple(self._odometry.follow(pose)))
        if "laser" in self.sensors:
            beams = self._scene.rays(
                pose[:2], [pose.theta + b for b in LASER_BEARINGS], LASER_REACH
            )
            found = found._replace(scan=tuple(self._noise.on(beams, LASER_REACH)))
        if "ir" in self.sensors:
            middles = [pose.theta + b for b in INFRA_RED_BEARINGS]
            cones = self._scene.cones(pose[:2], middles, INFRA_RED_WIDTH, INFRA_RED_REACH)
            found = found._replace(ir=tuple(self._noise.on(cones, INFRA_RED_REACH)))
        if "bumper" in self.sensors:
            found = found._replace(bumper=self._bumper.closed(self._body))
        return found

    def step(self, v: float, omega: float) -> None:
        """Move with a speed [m/s] and a turning [rad/s] for one control step."""
        self.steps += 1
        for _ in range(round(PERIOD / _PART)):
            dt = _PART
            if self.sensors == "bumper":
                met = self._scene.contact(self.pose, self._body.radius, (v, 0.0, omega), dt)
                dt = dt if met is None else met.time
                if not dt:
                    return
            self._body.move(v, 0.0, omega, dt)
            if v:
                self.min_clearance = min(self.min_clearance, self._scene.gap(self.pose[:2]))


class Row(NamedTuple):
    """Where the robot was in one step, and what it was doing (s, m, m, rad)."""

    t: float
    x: float
    y: float
    theta: float
    mode: str


@dataclass(frozen=True, slots=True)
class Run:
    """What came of one run.

    Attributes:
        status: ``reached``, ``unreachable`` or ``gave-up``.
        rows: One for each control step, the start first.
        hits: Places at which following began [m].
        leaves: Places at which it ended [m].
        reversals: How often it turned round at an earlier point.
        collisions: How often the body was pressed into a wall.
        min_clearance: Least distance of its centre from a wall [m].
    """

    status: str
    rows: list[Row] = field(repr=False)
    hits: list[tuple[float, float]]
    leaves: list[tuple[float, float]]
    reversals: int
    collisions: int
    min_clearance: float

    @property
    def path_length(self) -> float:
        """Length of the path through the rows [m]."""
        return sum(hypot(b.x - a.x, b.y - a.y) for a, b in pairwise(self.rows))


def simulate(
    environment: Environment,
    assembly: Assembly,
    sensors: str = "laser",
    direction: str = "left",
    seed: int = 0,
    noise: float = 0.0,
    step_limit: int = STEP_LIMIT,
) -> Run:
    """Run a navigator in an environment to its end, in this process, as fast as it goes.

    Raises:
        Malformed: There is no such direction, or sensor set-up.
    """
    world = Simulation(environment, seed, noise, sensors)
    navigator = Navigator(assembly, environment.goal, direction, environment.goal_margin)
    rows: list[Row] = []
    hits: list[tuple[float, float]] = []
    leaves: list[tuple[float, float]] = []
    while True:
        command = navigator.control(senses_of(sensors, world.raw()), world.t)
        before = rows[-1].mode if rows else "goal"
        mode = navigator.mode if rows else before  # a hit at the start shows from the next step on
        rows.append(Row(world.t, *world.pose, mode))
        if mode != before:
            (hits if before == "goal" else leaves).append(world.pose[:2])
        if navigator.status or world.steps >= step_limit:
            break
        world.step(*command)
    return Run(
        navigator.status or GAVE_UP,
        rows,
        hits,
        leaves,
        navigator.reversals,
        world.collisions,
        world.min_clearance,
    )
