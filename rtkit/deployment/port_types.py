"""Data types of stand-ins' ports, resolved so that every connection of the profile can be made.

Profiles of long-lived systems contradict themselves: a port states one type, its connection
another. The connection wins, as it was once made; the statement is kept beside it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rtkit.deployment.extension import STATED_TYPE
from rtkit.deployment.system import WantedComponent, WantedConnector
from rtkit.fast_dataclass import replace
from rtkit.rtc.data_types import ANY, is_same_type, scoped_name
from rtkit.rtc.profiles import PortProfile

_TYPE = "dataport.data_type"


def settle_types(
    components: Mapping[str, WantedComponent], connectors: Iterable[WantedConnector]
) -> tuple[dict[str, WantedComponent], tuple[str, ...]]:
    """Return the components with the types of stand-ins' ports settled, and notes on changes."""
    settled = dict(components)
    notes: list[str] = []
    profiles = [connector.profile for connector in connectors if connector.is_data]
    for instance, component in components.items():
        if component.pattern is None:
            continue
        carried: dict[str, list[str]] = {}
        for connector in profiles:
            types = [connector.properties.get(_TYPE, "")]
            ends = (components[end.instance].port(end.port) for end in connector.ports)
            types += [port.data_type for port in ends if port is not None]
            for end in connector.ports:
                if end.instance == instance:
                    carried.setdefault(end.port, []).append(next(filter(None, types), ""))
        ports = tuple(_settle(port, carried.get(port.name, [])) for port in component.ports)
        if ports != component.ports:
            notes += [
                f"{instance}.{new.name}: stated type {old.data_type}, connected as {new.data_type}"
                for old, new in zip(component.ports, ports, strict=True)
                if old != new
            ]
            pattern = replace(component.pattern, ports=ports)
            settled[instance] = replace(component, ports=ports, pattern=pattern)
    return settled, tuple(notes)


def _settle(port: PortProfile, carried: list[str]) -> PortProfile:
    types = {scoped_name(text): text for text in carried if scoped_name(text)}
    stated = port.data_type
    if not types or (len(types) == 1 and stated and is_same_type(stated, *types)):
        return port
    chosen = next(iter(types.values())) if len(types) == 1 else ANY
    properties = {**port.properties, _TYPE: chosen}
    if stated:
        properties[STATED_TYPE] = stated
    return replace(port, properties=properties)
