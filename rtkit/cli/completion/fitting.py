"""Matches ports with ports, for ports as plain facts."""

from __future__ import annotations

from collections.abc import Iterable

from rtkit.cli.completion.live import Plain
from rtkit.rtc.data_types import is_same_type
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.port_types import interfaces_fit, types_fit
from rtkit.rtc.profiles import PortInterfaceProfile


def is_fit(one: Plain, other: Plain) -> bool:
    """Return whether direction, data type and interfaces let two ports be connected."""
    types = [PortType(each["port_type"]) for each in (one, other)]
    if not types_fit(types):
        return False
    if PortType.SERVICE in types:
        return interfaces_fit(_interfaces(one), _interfaces(other))
    return is_same_type(_data_type(one), _data_type(other))


def _data_type(port: Plain) -> str:
    return str(port.get("properties", {}).get("dataport.data_type", ""))


def _interfaces(port: Plain) -> list[PortInterfaceProfile]:
    return [
        PortInterfaceProfile(each["instance_name"], each["type_name"], Polarity(each["polarity"]))
        for each in port.get("interfaces", ())
    ]


def fits(components: Iterable[Plain], instance: str, port: Plain) -> set[str]:
    """Return the components that have a port which goes with one of a component."""
    found = set()
    verdicts: dict[tuple[str, ...], bool] = {}
    for component in components:
        for each in component.get("ports", ()):
            if component["instance"] == instance and each["name"] == port["name"]:
                continue
            key = (each["port_type"], _data_type(each), str(each.get("interfaces", "")))
            if key not in verdicts:
                verdicts[key] = is_fit(port, each)
            if verdicts[key]:
                found.add(component["instance"])
                break
    return found
