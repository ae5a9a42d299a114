"""Checks whether ports may be connected, before anything changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rtkit.rtc.data_types import is_same_type
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.interface_types import canonical
from rtkit.rtc.profiles import PortInterfaceProfile, PortProfile

WRONG_TYPE = "Wrong port type."
INCOMPATIBLE = "Incompatible connection properties."
NO_INTERFACE = "Interfaces do not match."
NO_POLARITY = "Polarities do not match."
ANY_DATA_TYPE = "rtkit.any_data_type"
"""Connector property; YES connects ports of different data types all the same."""

_CHOICES = (
    "dataport.interface_type",
    "dataport.dataflow_type",
    "dataport.subscription_type",
    "dataport.serializer.cdr.endian",
)


def refusal(ports: Sequence[PortProfile], properties: Mapping[str, str]) -> str:
    """Return why the ports cannot be connected with these properties, "" when they can."""
    kinds = [port.port_type for port in ports]
    if PortType.SERVICE in kinds:
        if any(kind is not PortType.SERVICE for kind in kinds):
            return WRONG_TYPE
        return _refused_interfaces(ports)
    if len(ports) > 1 and not (PortType.IN in kinds and PortType.OUT in kinds):
        return WRONG_TYPE
    is_forced = properties.get(ANY_DATA_TYPE, "").upper() == "YES"
    types = "" if is_forced else _refused_types(ports, properties)
    return types or _refused_properties(ports, properties)


def _refused_types(ports: Sequence[PortProfile], properties: Mapping[str, str]) -> str:
    typed = [port for port in ports if port.data_type]
    for index, one in enumerate(typed):
        for other in typed[index + 1 :]:
            if not is_same_type(one.data_type, other.data_type):
                return (
                    f"Data types differ: {one.name} has {one.data_type},"
                    f" {other.name} has {other.data_type}"
                )
    wanted = properties.get("dataport.data_type", "")
    for port in typed:
        if not is_same_type(wanted, port.data_type):
            return f"Data types differ: {port.name} has {port.data_type}, wanted is {wanted}"
    return ""


def _refused_properties(ports: Sequence[PortProfile], properties: Mapping[str, str]) -> str:
    for key in _CHOICES:
        value = properties.get(key, "").strip()
        if not value or not all(port.properties.get(key, "").strip() for port in ports):
            continue
        wanted = _words(key, value)
        for port in ports:
            offered = _words(key, port.properties[key])
            if "any" not in offered and not wanted & offered:
                return incompatible(key, value, port)
    return ""


def incompatible(key: str, value: str, port: PortProfile) -> str:
    """Return the message about a property that a port does not offer."""
    return f"{INCOMPATIBLE} ({key} is {value}; {port.name} offers {port.properties[key]})"


def _words(key: str, text: str) -> set[str]:
    return {canonical(key, word) for word in text.split(",")}


def _refused_interfaces(ports: Sequence[PortProfile]) -> str:
    listed = [port.interfaces for port in ports if port.interfaces]
    if not listed:
        return ""
    for index, one in enumerate(listed):
        for other in listed[index + 1 :]:
            found = _match(one, other)
            if found:
                return found
    return ""


def _match(one: tuple[PortInterfaceProfile, ...], other: tuple[PortInterfaceProfile, ...]) -> str:
    pairs = [(mine, its) for mine in one for its in other if mine.type_name == its.type_name]
    if not pairs:
        return NO_INTERFACE
    wanted = {Polarity.PROVIDED, Polarity.REQUIRED}
    if not any({mine.polarity, its.polarity} == wanted for mine, its in pairs):
        return NO_POLARITY
    return ""
