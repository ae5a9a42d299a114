"""Components after the OMG RTC specification: base classes, ports, parameters and data types.

Importing a name from here loads only what that name needs: a slave with one component takes few of
all these modules (decision 35).
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rtkit.component.standard import HOMES
from rtkit.rtc.enums import Polarity, ReturnCode
from rtkit.rtc.profiles import PortInterfaceProfile

if TYPE_CHECKING:
    from rtkit.component.actuators import ActArrayActuatorCurrent as ActArrayActuatorCurrent
    from rtkit.component.actuators import ActArrayActuatorGeometry as ActArrayActuatorGeometry
    from rtkit.component.actuators import ActArrayActuatorPos as ActArrayActuatorPos
    from rtkit.component.actuators import ActArrayActuatorSpeed as ActArrayActuatorSpeed
    from rtkit.component.actuators import ActArrayActuatorStatus as ActArrayActuatorStatus
    from rtkit.component.actuators import ActArrayActuatorType as ActArrayActuatorType
    from rtkit.component.actuators import ActArrayGeometry as ActArrayGeometry
    from rtkit.component.actuators import ActArrayState as ActArrayState
    from rtkit.component.actuators import Actuator as Actuator
    from rtkit.component.actuators import GripperGeometry as GripperGeometry
    from rtkit.component.actuators import GripperState as GripperState
    from rtkit.component.actuators import GripperStatus as GripperStatus
    from rtkit.component.actuators import LimbState as LimbState
    from rtkit.component.actuators import LimbStatus as LimbStatus
    from rtkit.component.actuators import PanTiltAngles as PanTiltAngles
    from rtkit.component.actuators import PanTiltState as PanTiltState
    from rtkit.component.base import Component as Component
    from rtkit.component.base import Manager as Manager
    from rtkit.component.extended import OAP as OAP
    from rtkit.component.extended import Carlike as Carlike
    from rtkit.component.extended import Covariance2D as Covariance2D
    from rtkit.component.extended import Covariance3D as Covariance3D
    from rtkit.component.extended import Geometry2D as Geometry2D
    from rtkit.component.extended import Geometry3D as Geometry3D
    from rtkit.component.extended import PointCovariance2D as PointCovariance2D
    from rtkit.component.extended import Quaternion as Quaternion
    from rtkit.component.extended import SpeedHeading3D as SpeedHeading3D
    from rtkit.component.extended import TimedCarlike as TimedCarlike
    from rtkit.component.extended import TimedCovariance2D as TimedCovariance2D
    from rtkit.component.extended import TimedCovariance3D as TimedCovariance3D
    from rtkit.component.extended import TimedGeometry2D as TimedGeometry2D
    from rtkit.component.extended import TimedGeometry3D as TimedGeometry3D
    from rtkit.component.extended import TimedOAP as TimedOAP
    from rtkit.component.extended import TimedPointCovariance2D as TimedPointCovariance2D
    from rtkit.component.extended import TimedQuaternion as TimedQuaternion
    from rtkit.component.extended import TimedSpeedHeading3D as TimedSpeedHeading3D
    from rtkit.component.fsm import EventPort as EventPort
    from rtkit.component.fsm import FsmComponent as FsmComponent
    from rtkit.component.fsm import State as State
    from rtkit.component.fsm import takes as takes
    from rtkit.component.geometry import Acceleration2D as Acceleration2D
    from rtkit.component.geometry import Acceleration3D as Acceleration3D
    from rtkit.component.geometry import AngularAcceleration3D as AngularAcceleration3D
    from rtkit.component.geometry import AngularVelocity3D as AngularVelocity3D
    from rtkit.component.geometry import Orientation3D as Orientation3D
    from rtkit.component.geometry import Point2D as Point2D
    from rtkit.component.geometry import Point3D as Point3D
    from rtkit.component.geometry import Pose2D as Pose2D
    from rtkit.component.geometry import Pose3D as Pose3D
    from rtkit.component.geometry import PoseVel2D as PoseVel2D
    from rtkit.component.geometry import PoseVel3D as PoseVel3D
    from rtkit.component.geometry import RGBColour as RGBColour
    from rtkit.component.geometry import Size2D as Size2D
    from rtkit.component.geometry import Size3D as Size3D
    from rtkit.component.geometry import SpeedHeading2D as SpeedHeading2D
    from rtkit.component.geometry import TimedAcceleration2D as TimedAcceleration2D
    from rtkit.component.geometry import TimedAcceleration3D as TimedAcceleration3D
    from rtkit.component.geometry import TimedAngularAcceleration3D as TimedAngularAcceleration3D
    from rtkit.component.geometry import TimedAngularVelocity3D as TimedAngularVelocity3D
    from rtkit.component.geometry import TimedOrientation3D as TimedOrientation3D
    from rtkit.component.geometry import TimedPoint2D as TimedPoint2D
    from rtkit.component.geometry import TimedPoint3D as TimedPoint3D
    from rtkit.component.geometry import TimedPose2D as TimedPose2D
    from rtkit.component.geometry import TimedPose3D as TimedPose3D
    from rtkit.component.geometry import TimedPoseVel2D as TimedPoseVel2D
    from rtkit.component.geometry import TimedPoseVel3D as TimedPoseVel3D
    from rtkit.component.geometry import TimedRGBColour as TimedRGBColour
    from rtkit.component.geometry import TimedSize2D as TimedSize2D
    from rtkit.component.geometry import TimedSize3D as TimedSize3D
    from rtkit.component.geometry import TimedSpeedHeading2D as TimedSpeedHeading2D
    from rtkit.component.geometry import TimedVector2D as TimedVector2D
    from rtkit.component.geometry import TimedVector3D as TimedVector3D
    from rtkit.component.geometry import TimedVelocity2D as TimedVelocity2D
    from rtkit.component.geometry import TimedVelocity3D as TimedVelocity3D
    from rtkit.component.geometry import Vector2D as Vector2D
    from rtkit.component.geometry import Vector3D as Vector3D
    from rtkit.component.geometry import Velocity2D as Velocity2D
    from rtkit.component.geometry import Velocity3D as Velocity3D
    from rtkit.component.interface import raises as raises
    from rtkit.component.navigation import Features as Features
    from rtkit.component.navigation import Hypotheses2D as Hypotheses2D
    from rtkit.component.navigation import Hypotheses3D as Hypotheses3D
    from rtkit.component.navigation import Hypothesis2D as Hypothesis2D
    from rtkit.component.navigation import Hypothesis3D as Hypothesis3D
    from rtkit.component.navigation import LineFeature as LineFeature
    from rtkit.component.navigation import OGMapConfig as OGMapConfig
    from rtkit.component.navigation import OGMapTile as OGMapTile
    from rtkit.component.navigation import Path2D as Path2D
    from rtkit.component.navigation import Path3D as Path3D
    from rtkit.component.navigation import PointFeature as PointFeature
    from rtkit.component.navigation import PoseFeature as PoseFeature
    from rtkit.component.navigation import Waypoint2D as Waypoint2D
    from rtkit.component.navigation import Waypoint3D as Waypoint3D
    from rtkit.component.options import PortStatus as PortStatus
    from rtkit.component.parameter import Parameter as Parameter
    from rtkit.component.port import InPort as InPort
    from rtkit.component.port import OutPort as OutPort
    from rtkit.component.sensors import BumperArrayGeometry as BumperArrayGeometry
    from rtkit.component.sensors import BumperGeometry as BumperGeometry
    from rtkit.component.sensors import CameraImage as CameraImage
    from rtkit.component.sensors import CameraInfo as CameraInfo
    from rtkit.component.sensors import FiducialFOV as FiducialFOV
    from rtkit.component.sensors import FiducialInfo as FiducialInfo
    from rtkit.component.sensors import Fiducials as Fiducials
    from rtkit.component.sensors import GPSData as GPSData
    from rtkit.component.sensors import GPSFixType as GPSFixType
    from rtkit.component.sensors import GPSTime as GPSTime
    from rtkit.component.sensors import INSData as INSData
    from rtkit.component.sensors import IntensityData as IntensityData
    from rtkit.component.sensors import MulticameraGeometry as MulticameraGeometry
    from rtkit.component.sensors import MultiCameraImages as MultiCameraImages
    from rtkit.component.sensors import PointCloud as PointCloud
    from rtkit.component.sensors import PointCloudPoint as PointCloudPoint
    from rtkit.component.sensors import RangeData as RangeData
    from rtkit.component.sensors import RangerConfig as RangerConfig
    from rtkit.component.sensors import RangerGeometry as RangerGeometry
    from rtkit.component.service import RequiredPort as RequiredPort
    from rtkit.component.service import ServicePort as ServicePort
    from rtkit.component.types import Char as Char
    from rtkit.component.types import Double as Double
    from rtkit.component.types import Float as Float
    from rtkit.component.types import Long as Long
    from rtkit.component.types import LongLong as LongLong
    from rtkit.component.types import Octet as Octet
    from rtkit.component.types import Short as Short
    from rtkit.component.types import Time as Time
    from rtkit.component.types import TimedBoolean as TimedBoolean
    from rtkit.component.types import TimedBooleanSeq as TimedBooleanSeq
    from rtkit.component.types import TimedChar as TimedChar
    from rtkit.component.types import TimedCharSeq as TimedCharSeq
    from rtkit.component.types import TimedDouble as TimedDouble
    from rtkit.component.types import TimedDoubleSeq as TimedDoubleSeq
    from rtkit.component.types import TimedFloat as TimedFloat
    from rtkit.component.types import TimedFloatSeq as TimedFloatSeq
    from rtkit.component.types import TimedLong as TimedLong
    from rtkit.component.types import TimedLongSeq as TimedLongSeq
    from rtkit.component.types import TimedOctet as TimedOctet
    from rtkit.component.types import TimedOctetSeq as TimedOctetSeq
    from rtkit.component.types import TimedShort as TimedShort
    from rtkit.component.types import TimedShortSeq as TimedShortSeq
    from rtkit.component.types import TimedState as TimedState
    from rtkit.component.types import TimedString as TimedString
    from rtkit.component.types import TimedStringSeq as TimedStringSeq
    from rtkit.component.types import TimedULong as TimedULong
    from rtkit.component.types import TimedULongSeq as TimedULongSeq
    from rtkit.component.types import TimedUShort as TimedUShort
    from rtkit.component.types import TimedUShortSeq as TimedUShortSeq
    from rtkit.component.types import TimedWChar as TimedWChar
    from rtkit.component.types import TimedWCharSeq as TimedWCharSeq
    from rtkit.component.types import TimedWString as TimedWString
    from rtkit.component.types import TimedWStringSeq as TimedWStringSeq
    from rtkit.component.types import ULong as ULong
    from rtkit.component.types import ULongLong as ULongLong
    from rtkit.component.types import UShort as UShort
    from rtkit.component.types import WChar as WChar
    from rtkit.component.types import WString as WString

_HOME = {
    "base": ("Component", "Manager"),
    "fsm": ("EventPort", "FsmComponent", "State", "takes"),
    "interface": ("raises",),
    "parameter": ("Parameter",),
    "port": ("InPort", "OutPort"),
    "service": ("RequiredPort", "ServicePort"),
    "options": ("PortStatus",),
    "types": (
        "Char",
        "Double",
        "Float",
        "Long",
        "LongLong",
        "Octet",
        "Short",
        "ULong",
        "ULongLong",
        "UShort",
        "WChar",
        "WString",
    ),
}
_MODULE = {name: module for module, names in _HOME.items() for name in names}
_MODULE.update(HOMES["RTC"])

__all__ = ["PortInterfaceProfile", "Polarity", "ReturnCode", *_MODULE]


def __getattr__(name: str) -> Any:
    if name not in _MODULE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULE[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
