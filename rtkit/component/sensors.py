"""Interface data types of sensors: rangers, bumpers, cameras, fiducials, positioning, clouds.

Fields are named and ordered as in the interface definitions of the RTC world.
"""

# Names of fields are those of the interface definitions; values used as defaults never change.
# ruff: noqa: N815

from __future__ import annotations

from enum import Enum

from rtkit.component.extended import Geometry3D
from rtkit.component.geometry import (
    Orientation3D,
    Point2D,
    Point3D,
    Pose3D,
    RGBColour,
    Size3D,
    Vector2D,
    Velocity3D,
)
from rtkit.component.typenames import register_all
from rtkit.component.types import EPOCH, Double, Time, ULong, UShort
from rtkit.fast_dataclass import dataclass


@dataclass(frozen=True, slots=True)
class RangerGeometry:
    """Place and extent of a range sensor and of each of its sensing elements."""

    geometry: Geometry3D = Geometry3D()
    elementGeometries: tuple[Geometry3D, ...] = ()


@dataclass(frozen=True, slots=True)
class RangerConfig:
    """Scan settings of a range sensor: angles [rad], ranges [m], frequency [Hz]."""

    minAngle: Double = 0.0
    maxAngle: Double = 0.0
    angularRes: Double = 0.0
    minRange: Double = 0.0
    maxRange: Double = 0.0
    rangeRes: Double = 0.0
    frequency: Double = 0.0


@dataclass(frozen=True, slots=True)
class RangeData:
    """One scan: ranges [m] with geometry and configuration at that time."""

    tm: Time = EPOCH
    ranges: tuple[Double, ...] = ()
    geometry: RangerGeometry = RangerGeometry()
    config: RangerConfig = RangerConfig()


@dataclass(frozen=True, slots=True)
class IntensityData:
    """Intensities of one scan, each 0 to 1."""

    tm: Time = EPOCH
    intensities: tuple[Double, ...] = ()
    geometry: RangerGeometry = RangerGeometry()
    config: RangerConfig = RangerConfig()


@dataclass(frozen=True, slots=True)
class BumperGeometry:
    """Place and size of one bumper; radius of curvature [m], 0 for a straight one."""

    pose: Pose3D = Pose3D()
    size: Size3D = Size3D()
    roc: Double = 0.0


@dataclass(frozen=True, slots=True)
class BumperArrayGeometry:
    """Place and extent of an array of bumpers and of each of them."""

    arrayGeometry: Geometry3D = Geometry3D()
    bumperGeometry: tuple[BumperGeometry, ...] = ()


@dataclass(frozen=True, slots=True)
class CameraImage:
    """An image: width and height [pixel], bits per pixel, format, divisor, pixel data."""

    tm: Time = EPOCH
    width: UShort = 0
    height: UShort = 0
    bpp: UShort = 0
    format: str = ""
    fDiv: Double = 0.0
    pixels: bytes = b""


@dataclass(frozen=True, slots=True)
class CameraInfo:
    """Focal length [m], principal point, radial (k) and tangential (p) distortion."""

    focalLength: Vector2D = Vector2D()
    principalPoint: Point2D = Point2D()
    k1: Double = 0.0
    k2: Double = 0.0
    p1: Double = 0.0
    p2: Double = 0.0


@dataclass(frozen=True, slots=True)
class MultiCameraImages:
    """Images of several cameras at one time."""

    tm: Time = EPOCH
    images: tuple[CameraImage, ...] = ()


@dataclass(frozen=True, slots=True)
class MulticameraGeometry:
    """Place and extent of a set of cameras and of each of them."""

    geometry: Geometry3D = Geometry3D()
    cameraGeometries: tuple[Geometry3D, ...] = ()


@dataclass(frozen=True, slots=True)
class FiducialInfo:
    """One fiducial: number, pose and size, and how uncertain they are."""

    id: ULong = 0
    pose: Pose3D = Pose3D()
    poseUncertainty: Pose3D = Pose3D()
    size: Size3D = Size3D()
    sizeUncertainty: Size3D = Size3D()


@dataclass(frozen=True, slots=True)
class Fiducials:
    """The fiducials that are seen at one time."""

    tm: Time = EPOCH
    fiducialsList: tuple[FiducialInfo, ...] = ()


@dataclass(frozen=True, slots=True)
class FiducialFOV:
    """Field of view for fiducials: ranges [m] and angle of view [rad]."""

    minRange: Double = 0.0
    maxRange: Double = 0.0
    viewAngle: Double = 0.0


@dataclass(frozen=True, slots=True)
class GPSTime:
    """Time of a satellite receiver: seconds [s] and microseconds."""

    sec: ULong = 0
    msec: ULong = 0


class GPSFixType(Enum):
    """Source of a satellite receiver's position fix."""

    GPS_FIX_NONE = 0
    GPS_FIX_NORMAL = 1
    GPS_FIX_DGPS = 2


@dataclass(frozen=True, slots=True)
class GPSData:
    """Position [deg, deg, m], errors [m], heading [rad] and speeds [m/s] of a receiver."""

    tm: Time = EPOCH
    timeFromGPS: GPSTime = GPSTime()
    latitude: Double = 0.0
    longitude: Double = 0.0
    altitude: Double = 0.0
    horizontalError: Double = 0.0
    verticalError: Double = 0.0
    heading: Double = 0.0
    horizontalSpeed: Double = 0.0
    verticalSpeed: Double = 0.0
    numSatellites: UShort = 0
    fixType: GPSFixType = GPSFixType.GPS_FIX_NONE


@dataclass(frozen=True, slots=True)
class INSData:
    """Position [deg, deg, m], height above sea [m], velocities and orientation, inertial."""

    tm: Time = EPOCH
    latitude: Double = 0.0
    longitude: Double = 0.0
    altitude: Double = 0.0
    heightAMSL: Double = 0.0
    velocityENU: Velocity3D = Velocity3D()
    orientation: Orientation3D = Orientation3D()


@dataclass(frozen=True, slots=True)
class PointCloudPoint:
    """One point of a cloud and its colour."""

    point: Point3D = Point3D()
    colour: RGBColour = RGBColour()


@dataclass(frozen=True, slots=True)
class PointCloud:
    """Points in space at one time."""

    tm: Time = EPOCH
    points: tuple[PointCloudPoint, ...] = ()


register_all(globals(), "RTC")
