"""Interface data types of actuators: arrays, grippers, limbs, pan-tilt units.

Fields are named and ordered as in the interface definitions of the RTC world.
"""

# Names of fields are those of the interface definitions; values used as defaults never change.
# ruff: noqa: N815

from __future__ import annotations

from enum import Enum

from rtkit.component.extended import OAP, Geometry3D
from rtkit.component.geometry import Orientation3D, Vector3D
from rtkit.component.typenames import register_all
from rtkit.component.types import EPOCH, Double, Time, UShort
from rtkit.fast_dataclass import dataclass


@dataclass(frozen=True, slots=True)
class ActArrayActuatorPos:
    """Position of one actuator [m] or [rad]."""

    tm: Time = EPOCH
    index: UShort = 0
    position: Double = 0.0


@dataclass(frozen=True, slots=True)
class ActArrayActuatorSpeed:
    """Speed of one actuator [m/s] or [rad/s]."""

    tm: Time = EPOCH
    index: UShort = 0
    speed: Double = 0.0


@dataclass(frozen=True, slots=True)
class ActArrayActuatorCurrent:
    """Current that one actuator draws [A]."""

    tm: Time = EPOCH
    index: UShort = 0
    current: Double = 0.0


class ActArrayActuatorStatus(Enum):
    """Status of an actuator."""

    ACTUATOR_STATUS_IDLE = 0
    ACTUATOR_STATUS_MOVING = 1
    ACTUATOR_STATUS_BRAKED = 2
    ACTUATOR_STATUS_STALLED = 3


@dataclass(frozen=True, slots=True)
class Actuator:
    """Position [m] or [rad], speed, acceleration, current [A] and status of one actuator."""

    position: Double = 0.0
    speed: Double = 0.0
    accel: Double = 0.0
    current: Double = 0.0
    status: ActArrayActuatorStatus = ActArrayActuatorStatus.ACTUATOR_STATUS_IDLE


@dataclass(frozen=True, slots=True)
class ActArrayState:
    """All actuators of an array at one time."""

    tm: Time = EPOCH
    actuators: tuple[Actuator, ...] = ()


class ActArrayActuatorType(Enum):
    """Kind of motion of an actuator."""

    ACTARRAY_ACTUATORTYPE_LINEAR = 0
    ACTARRAY_ACTUATORTYPE_ROTARY = 1


@dataclass(frozen=True, slots=True)
class ActArrayActuatorGeometry:
    """One actuator: its link [m], axis, range of motion [m] or [rad], brakes."""

    type: ActArrayActuatorType = ActArrayActuatorType.ACTARRAY_ACTUATORTYPE_LINEAR
    length: Double = 0.0
    orientation: Orientation3D = Orientation3D()
    axis: Vector3D = Vector3D()
    minRange: Double = 0.0
    centre: Double = 0.0
    maxRange: Double = 0.0
    homePosition: Double = 0.0
    hasBrakes: bool = False


@dataclass(frozen=True, slots=True)
class ActArrayGeometry:
    """Place and extent of an array of actuators and of each of them."""

    arrayGeometry: Geometry3D = Geometry3D()
    actuatorGeometry: tuple[ActArrayActuatorGeometry, ...] = ()


class GripperStatus(Enum):
    """Status of a gripper."""

    GRIPPER_STATE_OPEN = 0
    GRIPPER_STATE_CLOSED = 1
    GRIPPER_STATE_MOVING = 2
    GRIPPER_STATE_UNKNOWN = 3


@dataclass(frozen=True, slots=True)
class GripperState:
    """Status of a gripper at one time."""

    tm: Time = EPOCH
    status: GripperStatus = GripperStatus.GRIPPER_STATE_OPEN


@dataclass(frozen=True, slots=True)
class GripperGeometry:
    """Outer and inner extent of an open gripper."""

    exterior: Geometry3D = Geometry3D()
    interior: Geometry3D = Geometry3D()


class LimbStatus(Enum):
    """Status of a limb."""

    LIMB_STATUS_IDLE = 0
    LIMB_STATUS_BRAKED = 1
    LIMB_STATUS_MOVING = 2
    LIMB_STATUS_OOR = 3
    LIMB_STATUS_COLLISION = 4


@dataclass(frozen=True, slots=True)
class LimbState:
    """End effector and status of a limb at one time."""

    tm: Time = EPOCH
    oapMatrix: OAP = OAP()
    status: LimbStatus = LimbStatus.LIMB_STATUS_IDLE


@dataclass(frozen=True, slots=True)
class PanTiltAngles:
    """Angles of a pan-tilt unit [rad] at one time."""

    tm: Time = EPOCH
    pan: Double = 0.0
    tilt: Double = 0.0


@dataclass(frozen=True, slots=True)
class PanTiltState:
    """Angles [rad] and speeds [rad/s] of a pan-tilt unit at one time."""

    tm: Time = EPOCH
    angles: PanTiltAngles = PanTiltAngles()
    panSpeed: Double = 0.0
    tiltSpeed: Double = 0.0


register_all(globals(), "RTC")
