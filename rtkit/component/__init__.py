"""Components after the OMG RTC specification: base classes, ports, parameters and data types.

Importing a name from here loads only what that name needs: a slave with one component takes few of
all these modules (decision 35).
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rtkit.component.standard import declared_in, home_of, names_of
from rtkit.rtc.enums import Polarity as Polarity
from rtkit.rtc.enums import ReturnCode as ReturnCode
from rtkit.rtc.profiles import PortInterfaceProfile as PortInterfaceProfile

if TYPE_CHECKING:
    from rtkit.component.actuators import *  # noqa: F403
    from rtkit.component.base import Component as Component
    from rtkit.component.base import Manager as Manager
    from rtkit.component.configuration.parameter import Parameter as Parameter
    from rtkit.component.extended import *  # noqa: F403
    from rtkit.component.fsm import EventPort as EventPort
    from rtkit.component.fsm import FsmComponent as FsmComponent
    from rtkit.component.fsm import State as State
    from rtkit.component.fsm import takes as takes
    from rtkit.component.geometry import *  # noqa: F403
    from rtkit.component.navigation import *  # noqa: F403
    from rtkit.component.ports.connector_events import ConnectorEvent as ConnectorEvent
    from rtkit.component.ports.in_port import InPort as InPort
    from rtkit.component.ports.options import PortStatus as PortStatus
    from rtkit.component.ports.out_port import OutPort as OutPort
    from rtkit.component.sensors import *  # noqa: F403
    from rtkit.component.services.interface import raises as raises
    from rtkit.component.services.interface import returns as returns
    from rtkit.component.services.service import RequiredPort as RequiredPort
    from rtkit.component.services.service import ServicePort as ServicePort
    from rtkit.component.timed import *  # noqa: F403
    from rtkit.component.types import Char as Char
    from rtkit.component.types import Double as Double
    from rtkit.component.types import Float as Float
    from rtkit.component.types import Long as Long
    from rtkit.component.types import LongLong as LongLong
    from rtkit.component.types import Octet as Octet
    from rtkit.component.types import Short as Short
    from rtkit.component.types import Time as Time
    from rtkit.component.types import ULong as ULong
    from rtkit.component.types import ULongLong as ULongLong
    from rtkit.component.types import UShort as UShort
    from rtkit.component.types import WChar as WChar
    from rtkit.component.types import WString as WString

_HOME = {
    "base": ("Component", "Manager"),
    "configuration.parameter": ("Parameter",),
    "fsm": ("EventPort", "FsmComponent", "State", "takes"),
    "ports.connector_events": ("ConnectorEvent",),
    "ports.in_port": ("InPort",),
    "ports.options": ("PortStatus",),
    "ports.out_port": ("OutPort",),
    "services.interface": ("raises", "returns"),
    "services.service": ("RequiredPort", "ServicePort"),
    "types": (
        "Char", "Double", "Float", "Long", "LongLong", "Octet", "Short", "ULong", "ULongLong",
        "UShort", "WChar", "WString",
    ),
}  # fmt: skip
_MODULE = {name: module for module, names in _HOME.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "__all__":
        return ["PortInterfaceProfile", "Polarity", "ReturnCode", *_MODULE, *names_of("RTC")]
    home = _MODULE.get(name) or ("" if name.startswith("_") else home_of("RTC", name))
    if not home:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(f"{__name__}.{home}"), name)
    return found


def __dir__() -> list[str]:
    """Return what authors use first; data types beyond the timed ones are found by their names."""
    own = ("PortInterfaceProfile", "Polarity", "ReturnCode", *_MODULE)
    return sorted((*own, *declared_in("timed")))
