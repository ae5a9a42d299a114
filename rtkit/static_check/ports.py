"""Checks the ports that a system profile lists against the types: names, directions, data types."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache

from rtkit.profile.rts_model import InstancePort
from rtkit.profile.words import strip_instance
from rtkit.report.finding import ERROR
from rtkit.rtc.data_types import is_same_type, scoped_name
from rtkit.rtc.port_types import stated_port_type
from rtkit.static_check.blueprint import Blueprint, DataPortType
from rtkit.static_check.finding import ProfileLocation, StaticFinding
from rtkit.static_check.view import CheckedComponent, View, kinds_of, property_place


def port_findings(view: View) -> Iterator[StaticFinding]:
    """Yield what is wrong with the listed ports of components whose types are known."""
    for part in view.parts:
        blueprint = part.blueprint
        if blueprint is None:
            continue
        for number, port in enumerate(part.component.data_ports):
            yield from _data_port(
                view, part, blueprint, port, part.place.below("data_ports", number)
            )
        for number, port in enumerate(part.component.service_ports):
            name = strip_instance(port.name, part.name)
            if name not in blueprint.service_ports and not view.has_port(part, name):
                place = part.place.below("service_ports", number)
                yield _unknown(part, blueprint, port, place, is_data=False)


def _data_port(
    view: View,
    part: CheckedComponent,
    blueprint: Blueprint,
    port: InstancePort,
    place: ProfileLocation,
) -> Iterator[StaticFinding]:
    name = strip_instance(port.name, part.name)
    known = blueprint.data_ports.get(name)
    if known is None:
        if not view.has_port(part, name):
            yield _unknown(part, blueprint, port, place, is_data=True)
        return
    stated = property_place(place, port.properties, "port.port_type")
    wanted, kinds = stated_port_type(stated[1]) if stated is not None else None, kinds_of(known)
    if stated is not None and wanted is not None and wanted not in kinds:
        allowed = " or ".join(sorted(kinds))
        text = f"port {name} of {part.name} is to be a {stated[1]}, but is a {allowed}"
        yield StaticFinding(ERROR, "port-direction", text, stated[0], stated[1], allowed)
    type = property_place(place, port.properties, "dataport.data_type")
    if type is not None and not fits_type(type[1], known):
        allowed = type_names(known)
        text = f"port {name} of {part.name} is to carry {type[1]}, but carries {allowed}"
        yield StaticFinding(ERROR, "data-type", text, type[0], type[1], allowed)


def _unknown(
    part: CheckedComponent,
    blueprint: Blueprint,
    port: InstancePort,
    place: ProfileLocation,
    *,
    is_data: bool,
) -> StaticFinding:
    name = strip_instance(port.name, part.name)
    has, has_not = (
        (blueprint.data_ports, blueprint.service_ports)
        if is_data
        else (blueprint.service_ports, blueprint.data_ports)
    )
    kind = "data" if is_data else "service"
    text = f"{part.name} has no {kind} port {name}"
    if name in has_not:
        text += f"; {name} is a {'service' if is_data else 'data'} port"
    return StaticFinding(ERROR, "unknown-port", text, place.at("name"), port.name, listed(has))


def listed(names: Iterable[str]) -> str:
    """Return what there is, in words."""
    return ", ".join(names) or "none"


def fits_type(type: str, ports: tuple[DataPortType, ...]) -> bool:
    """Return whether a data type is that of one of the ports; an open type is that of all."""
    return any(_is_same(type, port.data_type) for port in ports)


_is_same = lru_cache(4096)(is_same_type)


def type_names(ports: tuple[DataPortType, ...]) -> str:
    """Return the data types of ports, in words."""
    return " or ".join(dict.fromkeys(scoped_name(port.data_type) or "any" for port in ports))
