"""Interface data types of navigation: localisation, maps, paths.

Fields are named and ordered as in the interface definitions of the RTC world.
"""

# Names of fields are those of the interface definitions; values used as defaults never change.
# ruff: noqa: N815

from __future__ import annotations

from rtkit.component.extended import Covariance2D, Covariance3D, PointCovariance2D
from rtkit.component.geometry import Point2D, Pose2D, Pose3D, Velocity2D, Velocity3D
from rtkit.component.typenames import register_all
from rtkit.component.types import EPOCH, Double, Time, ULong
from rtkit.fast_dataclass import dataclass


@dataclass(frozen=True, slots=True)
class Hypothesis2D:
    """One guess of a pose in the plane: mean, covariance, weight."""

    mean: Pose2D = Pose2D()
    covariance: Covariance2D = Covariance2D()
    weight: Double = 0.0


@dataclass(frozen=True, slots=True)
class Hypotheses2D:
    """Guesses of a pose in the plane at one time."""

    tm: Time = EPOCH
    hypotheses: tuple[Hypothesis2D, ...] = ()


@dataclass(frozen=True, slots=True)
class Hypothesis3D:
    """One guess of a pose in space: mean, covariance, weight."""

    mean: Pose3D = Pose3D()
    covariance: Covariance3D = Covariance3D()
    weight: Double = 0.0


@dataclass(frozen=True, slots=True)
class Hypotheses3D:
    """Guesses of a pose in space at one time."""

    tm: Time = EPOCH
    hypotheses: tuple[Hypothesis3D, ...] = ()


@dataclass(frozen=True, slots=True)
class OGMapConfig:
    """An occupancy grid: scales [m] per cell, size [cell], pose of its first cell."""

    xScale: Double = 0.0
    yScale: Double = 0.0
    width: ULong = 0
    height: ULong = 0
    origin: Pose2D = Pose2D()


@dataclass(frozen=True, slots=True)
class OGMapTile:
    """A part of an occupancy grid; cells row by row."""

    column: ULong = 0
    row: ULong = 0
    width: ULong = 0
    height: ULong = 0
    cells: bytes = b""


@dataclass(frozen=True, slots=True)
class PointFeature:
    """A point of a map: probability, position, covariance."""

    probability: Double = 0.0
    position: Point2D = Point2D()
    covariance: PointCovariance2D = PointCovariance2D()


@dataclass(frozen=True, slots=True)
class PoseFeature:
    """A point of a map with an orientation."""

    probability: Double = 0.0
    position: Pose2D = Pose2D()
    covariance: Covariance2D = Covariance2D()


@dataclass(frozen=True, slots=True)
class LineFeature:
    """A line of a map: distance [m] and angle [rad] of its normal, its ends."""

    probability: Double = 0.0
    rho: Double = 0.0
    alpha: Double = 0.0
    covariance: PointCovariance2D = PointCovariance2D()
    start: Point2D = Point2D()
    end: Point2D = Point2D()
    startSighted: bool = False
    endSighted: bool = False


@dataclass(frozen=True, slots=True)
class Features:
    """The features of a map at one time."""

    tm: Time = EPOCH
    pointFeatures: tuple[PointFeature, ...] = ()
    poseFeatures: tuple[PoseFeature, ...] = ()
    lineFeatures: tuple[LineFeature, ...] = ()


@dataclass(frozen=True, slots=True)
class Waypoint2D:
    """A target in the plane: pose, tolerances [m, rad], time limit and top speed."""

    target: Pose2D = Pose2D()
    distanceTolerance: Double = 0.0
    headingTolerance: Double = 0.0
    timeLimit: Time = EPOCH
    maxSpeed: Velocity2D = Velocity2D()


@dataclass(frozen=True, slots=True)
class Path2D:
    """Waypoints in the plane."""

    tm: Time = EPOCH
    waypoints: tuple[Waypoint2D, ...] = ()


@dataclass(frozen=True, slots=True)
class Waypoint3D:
    """A target in space: pose, tolerances [m, rad], time limit and top speed."""

    target: Pose3D = Pose3D()
    distanceTolerance: Double = 0.0
    headingTolerance: Double = 0.0
    timeLimit: Time = EPOCH
    maxSpeed: Velocity3D = Velocity3D()


@dataclass(frozen=True, slots=True)
class Path3D:
    """Waypoints in space."""

    tm: Time = EPOCH
    waypoints: tuple[Waypoint3D, ...] = ()


register_all(globals(), "RTC")
