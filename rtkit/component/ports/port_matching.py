"""Checks whether ports may be connected, before anything changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rtkit.rtc.connector_properties import canonical
from rtkit.rtc.data_types import is_same_type
from rtkit.rtc.enums import PortType
from rtkit.rtc.port_types import WRONG_TYPE, interfaces_fit, shared_interfaces, types_fit
from rtkit.rtc.profiles import PortProfile

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
    types = [port.port_type for port in ports]
    if not types_fit(types):
        return WRONG_TYPE
    if PortType.SERVICE in types:
        return _refused_interfaces(ports)
    is_forced = properties.get(ANY_DATA_TYPE, "").upper() == "YES"
    differing = "" if is_forced else _refused_types(ports, properties)
    return differing or _refused_properties(ports, properties)


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
    listed = [port for port in ports if port.interfaces]
    for index, one in enumerate(listed):
        for other in listed[index + 1 :]:
            if not interfaces_fit(one.interfaces, other.interfaces):
                is_shared = shared_interfaces(one.interfaces, other.interfaces)
                return NO_POLARITY if is_shared else NO_INTERFACE
    return ""
