"""Extended data types beyond plain geometry: extents, uncertainty, steering, quaternions.

Fields are named and ordered as in the interface definitions of the RTC world.
"""

# Names of fields are those of the interface definitions; values used as defaults never change.
# ruff: noqa: N815

from __future__ import annotations

from rtkit.component.geometry import (
    Orientation3D,
    Pose2D,
    Pose3D,
    Size2D,
    Size3D,
    Vector3D,
)
from rtkit.component.typenames import register_all
from rtkit.component.types import EPOCH, Double, Time
from rtkit.fast_dataclass import dataclass


@dataclass(frozen=True, slots=True)
class Quaternion:
    """An orientation in space as a unit quaternion."""

    x: Double = 0.0
    y: Double = 0.0
    z: Double = 0.0
    w: Double = 0.0


@dataclass(frozen=True, slots=True)
class Geometry2D:
    """Place of a device on its carrier, and its extent, in the plane."""

    pose: Pose2D = Pose2D()
    size: Size2D = Size2D()


@dataclass(frozen=True, slots=True)
class Covariance2D:
    """Covariance of a pose in the plane: x, y and heading t, upper triangle."""

    xx: Double = 0.0
    xy: Double = 0.0
    xt: Double = 0.0
    yy: Double = 0.0
    yt: Double = 0.0
    tt: Double = 0.0


@dataclass(frozen=True, slots=True)
class PointCovariance2D:
    """Covariance of a point in the plane, upper triangle."""

    xx: Double = 0.0
    xy: Double = 0.0
    yy: Double = 0.0


@dataclass(frozen=True, slots=True)
class Carlike:
    """A speed [m/s] and a steering angle [rad] for a vehicle that steers like a car."""

    speed: Double = 0.0
    steeringAngle: Double = 0.0


@dataclass(frozen=True, slots=True)
class Geometry3D:
    """Place of a device on its carrier, and its extent, in space."""

    pose: Pose3D = Pose3D()
    size: Size3D = Size3D()


@dataclass(frozen=True, slots=True)
class Covariance3D:
    """Covariance of a pose in space: x, y, z, roll r, pitch p, yaw a, upper triangle."""

    xx: Double = 0.0
    xy: Double = 0.0
    xz: Double = 0.0
    xr: Double = 0.0
    xp: Double = 0.0
    xa: Double = 0.0
    yy: Double = 0.0
    yz: Double = 0.0
    yr: Double = 0.0
    yp: Double = 0.0
    ya: Double = 0.0
    zz: Double = 0.0
    zr: Double = 0.0
    zp: Double = 0.0
    za: Double = 0.0
    rr: Double = 0.0
    rp: Double = 0.0
    ra: Double = 0.0
    pp: Double = 0.0
    pa: Double = 0.0
    aa: Double = 0.0


@dataclass(frozen=True, slots=True)
class SpeedHeading3D:
    """A speed [m/s] and a direction [rad] in space."""

    speed: Double = 0.0
    direction: Orientation3D = Orientation3D()


@dataclass(frozen=True, slots=True)
class OAP:
    """Orientation, approach and position vectors of an end effector."""

    orientation: Vector3D = Vector3D()
    approach: Vector3D = Vector3D()
    position: Vector3D = Vector3D()


@dataclass(frozen=True, slots=True)
class TimedQuaternion:
    """An orientation as a unit quaternion, and when."""

    tm: Time = EPOCH
    data: Quaternion = Quaternion()


@dataclass(frozen=True, slots=True)
class TimedGeometry2D:
    """Place and extent of a device in the plane, and when."""

    tm: Time = EPOCH
    data: Geometry2D = Geometry2D()


@dataclass(frozen=True, slots=True)
class TimedCovariance2D:
    """Covariance of a pose in the plane, and when."""

    tm: Time = EPOCH
    data: Covariance2D = Covariance2D()


@dataclass(frozen=True, slots=True)
class TimedPointCovariance2D:
    """Covariance of a point in the plane, and when."""

    tm: Time = EPOCH
    data: PointCovariance2D = PointCovariance2D()


@dataclass(frozen=True, slots=True)
class TimedCarlike:
    """A speed [m/s] and a steering angle [rad], and when."""

    tm: Time = EPOCH
    data: Carlike = Carlike()


@dataclass(frozen=True, slots=True)
class TimedGeometry3D:
    """Place and extent of a device in space, and when."""

    tm: Time = EPOCH
    data: Geometry3D = Geometry3D()


@dataclass(frozen=True, slots=True)
class TimedCovariance3D:
    """Covariance of a pose in space, and when."""

    tm: Time = EPOCH
    data: Covariance3D = Covariance3D()


@dataclass(frozen=True, slots=True)
class TimedSpeedHeading3D:
    """A speed [m/s] and a direction [rad] in space, and when."""

    tm: Time = EPOCH
    data: SpeedHeading3D = SpeedHeading3D()


@dataclass(frozen=True, slots=True)
class TimedOAP:
    """Orientation, approach and position vectors, and when."""

    tm: Time = EPOCH
    data: OAP = OAP()


register_all(globals(), "RTC")
