"""Drawing input of a component profile: its name and its pins."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.drawing.component import InterfaceSymbol, Pin
from rtkit.drawing.scene import EVENT, IN, LEFT, OUT, RIGHT, SERVICE, PortPin
from rtkit.profile.rtc_model import RtcProfile

_KINDS = {"DataInPort": IN, "DataOutPort": OUT, "EventPort": EVENT}


def component_pins(profile: RtcProfile) -> list[Pin]:
    """Return the ports: inputs at the left, outputs at the right.

    Service ports are where the profile has them, those above and below at the left.
    """
    return [*_data(profile), *_services(profile)]


def component_name(profile: RtcProfile) -> str:
    """Return the name to show for a component type; a fragment has none."""
    return profile.basic_info.name if profile.basic_info else profile.id or "(a fragment)"


def _data(profile: RtcProfile) -> Iterator[Pin]:
    for port in profile.data_ports:
        kind = _KINDS[port.port_type]
        tip = " ".join(filter(None, (port.name, port.type, port.unit)))
        side = RIGHT if kind == OUT else LEFT
        yield Pin(PortPin(port.name, side, kind, tip), port.type)


def _services(profile: RtcProfile) -> Iterator[Pin]:
    for port in profile.service_ports:
        side = RIGHT if port.position == "RIGHT" else LEFT
        interfaces = [
            InterfaceSymbol(each.name, each.type, each.direction == "Provided")
            for each in port.service_interfaces
        ]
        yield Pin(PortPin(port.name, side, SERVICE, port.comment or ""), "", tuple(interfaces))
