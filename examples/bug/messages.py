"""Values and interfaces that the components of this folder share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from rtkit.component import Double, Long, Point2D, Time

ONE_EACH_TICK = {
    "dataport.buffer.read.empty_policy": "block",
    "dataport.buffer.read.timeout": "5",
    "dataport.buffer.write.full_policy": "block",
}
"""Buffers of in ports that get one value in each step: whoever reads waits for it."""


@dataclass(frozen=True)
class Body:
    """What the simulator alone knows of the body: the truth.

    Attributes:
        tm: Simulated time.
        x: Place of its centre [m].
        y: The same.
        theta: Heading [rad].
        collisions: How often it was pressed into a wall.
        min_clearance: Least distance of its centre from a wall so far [m].
        is_last: Whether no further step will come: the limit of steps is reached.
    """

    tm: Time = Time()  # noqa: RUF009 - it cannot be changed
    x: Double = 0.0
    y: Double = 0.0
    theta: Double = 0.0
    collisions: Long = 0
    min_clearance: Double = 0.0
    is_last: bool = False


@dataclass(frozen=True)
class Navigation:
    """What a navigator has in mind after a control step.

    Attributes:
        tm: Simulated time.
        mode: ``goal`` or ``follow``.
        status: Empty while under way; ``reached`` or ``unreachable`` at the end.
        state: What it does, in a few words.
        hits: Places where following began [m].
        leaves: Places where it ended [m].
        reversals: How often it turned round at an earlier point.
        x: Where it takes itself to be [m].
        y: The same.
        theta: The same [rad].
        v: Speed ahead until the next step [m/s].
        omega: Turning until then [rad/s].
    """

    tm: Time = Time()  # noqa: RUF009 - it cannot be changed
    mode: str = ""
    status: str = ""
    state: str = ""
    hits: tuple[Point2D, ...] = ()
    leaves: tuple[Point2D, ...] = ()
    reversals: Long = 0
    x: Double = 0.0
    y: Double = 0.0
    theta: Double = 0.0
    v: Double = 0.0
    omega: Double = 0.0


@dataclass(frozen=True)
class Beams:
    """All beams of a step.

    Attributes:
        bearings: In the robot's frame [rad], counter-clockwise from ahead.
        ranges: The way that is free along each [m].
    """

    bearings: tuple[Double, ...] = ()
    ranges: tuple[Double, ...] = ()


class Distance(Protocol):
    """Hardware abstractions of what is round the robot; an adaptor for each set of sensors."""

    def safe_distance(self) -> float:
        """Return how far a followed wall is kept [m]."""

    def obstacle_in_front_of_the_robot(self) -> bool:
        """Return whether the way ahead is blocked within the stop distance."""

    def obstacle_on_the_left(self) -> bool:
        """Return whether something is on the left."""

    def obstacle_on_the_right(self) -> bool:
        """Return whether something is on the right."""

    def left_distance(self) -> float:
        """Return how far it is on the left [m]."""

    def right_distance(self) -> float:
        """Return how far it is on the right [m]."""

    def free_distance(self, bearing: float) -> tuple[float, ...]:
        """Return how far it is along a bearing [rad]: one number [m], none out of sight."""

    def scan(self) -> Beams:
        """Return all beams, from right to left."""


class Localisation(Protocol):
    """Hardware abstractions of where the robot is."""

    def position(self) -> Point2D:
        """Return the place [m]."""

    def heading(self) -> float:
        """Return the heading [rad]."""


@dataclass(frozen=True)
class PathRow:
    """One row of a trajectory, see `records.Row`."""

    t: Double = 0.0
    x: Double = 0.0
    y: Double = 0.0
    theta: Double = 0.0
    mode: str = ""
    odom_x: Double = 0.0
    odom_y: Double = 0.0
    odom_theta: Double = 0.0


@dataclass(frozen=True)
class Outcome:
    """How a run is so far; see `records.Record`."""

    run: str = ""
    status: str = ""
    state: str = ""
    rows: Long = 0
    hits: tuple[Point2D, ...] = ()
    leaves: tuple[Point2D, ...] = ()
    reversals: Long = 0
    collisions: Long = 0
    min_clearance: Double = 0.0


class Record(Protocol):
    """What a run has left behind so far."""

    def outcome(self) -> Outcome:
        """Return how it is."""

    def rows(self, first: int, count: int) -> tuple[PathRow, ...]:
        """Return rows from the first one asked for on, the start being 0."""


def time_of(seconds: float) -> Time:
    """Return a simulated time [s] as the time stamp of a value."""
    whole = int(seconds)
    return Time(whole, round((seconds - whole) * 1e9))


def seconds(time: Time) -> float:
    """Return a time stamp [s]."""
    return float(time.sec) + float(time.nsec) / 1e9
