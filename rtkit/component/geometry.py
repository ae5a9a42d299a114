"""Geometric data types of the RTC world, fields named as in its interface definitions.

Positions in [m], angles in [rad], unless a summary says otherwise.
"""

from __future__ import annotations

from rtkit.component.typenames import register_all
from rtkit.component.types import EPOCH, Double, Time
from rtkit.fast_dataclass import dataclass


@dataclass(frozen=True, slots=True)
class Point2D:
    """A point in the plane [m]."""

    x: Double = 0.0
    y: Double = 0.0


@dataclass(frozen=True, slots=True)
class Vector2D:
    """A vector in the plane."""

    x: Double = 0.0
    y: Double = 0.0


@dataclass(frozen=True, slots=True)
class Pose2D:
    """A position [m] and a heading [rad] in the plane."""

    position: Point2D = Point2D()
    heading: Double = 0.0


@dataclass(frozen=True, slots=True)
class Velocity2D:
    """Velocities along x and y [m/s] and about the vertical [rad/s]."""

    vx: Double = 0.0
    vy: Double = 0.0
    va: Double = 0.0


@dataclass(frozen=True, slots=True)
class Acceleration2D:
    """Accelerations along x and y [m/s^2]."""

    ax: Double = 0.0
    ay: Double = 0.0


@dataclass(frozen=True, slots=True)
class PoseVel2D:
    """A pose in the plane and its velocities."""

    pose: Pose2D = Pose2D()
    velocities: Velocity2D = Velocity2D()


@dataclass(frozen=True, slots=True)
class Size2D:
    """Length and width [m]."""

    l: Double = 0.0  # noqa: E741 - its name in the IDL
    w: Double = 0.0


@dataclass(frozen=True, slots=True)
class SpeedHeading2D:
    """A speed [m/s] and a heading [rad]."""

    speed: Double = 0.0
    heading: Double = 0.0


@dataclass(frozen=True, slots=True)
class Point3D:
    """A point in space [m]."""

    x: Double = 0.0
    y: Double = 0.0
    z: Double = 0.0


@dataclass(frozen=True, slots=True)
class Vector3D:
    """A vector in space."""

    x: Double = 0.0
    y: Double = 0.0
    z: Double = 0.0


@dataclass(frozen=True, slots=True)
class Orientation3D:
    """Roll, pitch and yaw [rad]."""

    r: Double = 0.0
    p: Double = 0.0
    y: Double = 0.0


@dataclass(frozen=True, slots=True)
class Pose3D:
    """A position [m] and an orientation [rad] in space."""

    position: Point3D = Point3D()
    orientation: Orientation3D = Orientation3D()


@dataclass(frozen=True, slots=True)
class Velocity3D:
    """Velocities along [m/s] and about [rad/s] the axes."""

    vx: Double = 0.0
    vy: Double = 0.0
    vz: Double = 0.0
    vr: Double = 0.0
    vp: Double = 0.0
    va: Double = 0.0


@dataclass(frozen=True, slots=True)
class AngularVelocity3D:
    """Velocities about the axes [rad/s]."""

    avx: Double = 0.0
    avy: Double = 0.0
    avz: Double = 0.0


@dataclass(frozen=True, slots=True)
class Acceleration3D:
    """Accelerations along the axes [m/s^2]."""

    ax: Double = 0.0
    ay: Double = 0.0
    az: Double = 0.0


@dataclass(frozen=True, slots=True)
class AngularAcceleration3D:
    """Accelerations about the axes [rad/s^2]."""

    aax: Double = 0.0
    aay: Double = 0.0
    aaz: Double = 0.0


@dataclass(frozen=True, slots=True)
class PoseVel3D:
    """A pose in space and its velocities."""

    pose: Pose3D = Pose3D()
    velocities: Velocity3D = Velocity3D()


@dataclass(frozen=True, slots=True)
class Size3D:
    """Length, width and height [m]."""

    l: Double = 0.0  # noqa: E741 - its name in the IDL
    w: Double = 0.0
    h: Double = 0.0


@dataclass(frozen=True, slots=True)
class RGBColour:
    """A colour, each part 0 to 1."""

    r: Double = 0.0
    g: Double = 0.0
    b: Double = 0.0


@dataclass(frozen=True, slots=True)
class TimedPoint2D:
    """A point in the plane [m], and when."""

    tm: Time = EPOCH
    data: Point2D = Point2D()


@dataclass(frozen=True, slots=True)
class TimedVector2D:
    """A vector in the plane, and when."""

    tm: Time = EPOCH
    data: Vector2D = Vector2D()


@dataclass(frozen=True, slots=True)
class TimedPose2D:
    """A position [m] and a heading [rad] in the plane, and when."""

    tm: Time = EPOCH
    data: Pose2D = Pose2D()


@dataclass(frozen=True, slots=True)
class TimedVelocity2D:
    """Velocities along x and y [m/s] and about the vertical [rad/s], and when."""

    tm: Time = EPOCH
    data: Velocity2D = Velocity2D()


@dataclass(frozen=True, slots=True)
class TimedAcceleration2D:
    """Accelerations along x and y [m/s^2], and when."""

    tm: Time = EPOCH
    data: Acceleration2D = Acceleration2D()


@dataclass(frozen=True, slots=True)
class TimedPoseVel2D:
    """A pose in the plane and its velocities, and when."""

    tm: Time = EPOCH
    data: PoseVel2D = PoseVel2D()


@dataclass(frozen=True, slots=True)
class TimedSize2D:
    """Length and width [m], and when."""

    tm: Time = EPOCH
    data: Size2D = Size2D()


@dataclass(frozen=True, slots=True)
class TimedSpeedHeading2D:
    """A speed [m/s] and a heading [rad], and when."""

    tm: Time = EPOCH
    data: SpeedHeading2D = SpeedHeading2D()


@dataclass(frozen=True, slots=True)
class TimedPoint3D:
    """A point in space [m], and when."""

    tm: Time = EPOCH
    data: Point3D = Point3D()


@dataclass(frozen=True, slots=True)
class TimedVector3D:
    """A vector in space, and when."""

    tm: Time = EPOCH
    data: Vector3D = Vector3D()


@dataclass(frozen=True, slots=True)
class TimedOrientation3D:
    """Roll, pitch and yaw [rad], and when."""

    tm: Time = EPOCH
    data: Orientation3D = Orientation3D()


@dataclass(frozen=True, slots=True)
class TimedPose3D:
    """A position [m] and an orientation [rad] in space, and when."""

    tm: Time = EPOCH
    data: Pose3D = Pose3D()


@dataclass(frozen=True, slots=True)
class TimedVelocity3D:
    """Velocities along [m/s] and about [rad/s] the axes, and when."""

    tm: Time = EPOCH
    data: Velocity3D = Velocity3D()


@dataclass(frozen=True, slots=True)
class TimedAngularVelocity3D:
    """Velocities about the axes [rad/s], and when."""

    tm: Time = EPOCH
    data: AngularVelocity3D = AngularVelocity3D()


@dataclass(frozen=True, slots=True)
class TimedAcceleration3D:
    """Accelerations along the axes [m/s^2], and when."""

    tm: Time = EPOCH
    data: Acceleration3D = Acceleration3D()


@dataclass(frozen=True, slots=True)
class TimedAngularAcceleration3D:
    """Accelerations about the axes [rad/s^2], and when."""

    tm: Time = EPOCH
    data: AngularAcceleration3D = AngularAcceleration3D()


@dataclass(frozen=True, slots=True)
class TimedPoseVel3D:
    """A pose in space and its velocities, and when."""

    tm: Time = EPOCH
    data: PoseVel3D = PoseVel3D()


@dataclass(frozen=True, slots=True)
class TimedSize3D:
    """Length, width and height [m], and when."""

    tm: Time = EPOCH
    data: Size3D = Size3D()


@dataclass(frozen=True, slots=True)
class TimedRGBColour:
    """A colour, each part 0 to 1, and when."""

    tm: Time = EPOCH
    data: RGBColour = RGBColour()


register_all(globals(), "RTC")
