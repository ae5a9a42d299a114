"""Creates a component profile from a few words on each of its parts."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, NamedTuple

from rtkit.errors import Malformed
from rtkit.fast_dataclass import replace
from rtkit.profile import rtc_model as rtc
from rtkit.profile.constraint_text import parse_constraint
from rtkit.profile.rtc_spec import ACTIONS

_SINGLE_COLON = re.compile(r"(?<!:):(?!:)")
_PORT_NAME = re.compile(r"[\w./()-]+")
_STANDARD = re.compile(r"Timed\w+")
_LEFT_OUT = ("on_action", "on_mode_changed")
"""Callbacks that no language has a method for."""


class ComponentHeading(NamedTuple):
    """Identity and kind of a new component type.

    Attributes:
        rate: [Hz]; None leaves it open.
        max_instances: 0 for no limit.
        date: ``2024-01-31T12:00:00+09:00``.
    """

    name: str
    date: str
    vendor: str = "Me"
    category: str = "Misc"
    version: str = "1.0.0"
    description: str = ""
    component_type: str = "STATIC"
    activity_type: str = "PERIODIC"
    rate: float | None = None
    max_instances: int = 0
    language: str = "Python"


def new_component(
    heading: ComponentHeading,
    data_ports: Iterable[rtc.DataPortDeclaration] = (),
    service_ports: Iterable[rtc.ServicePortDeclaration] = (),
    parameters: Iterable[rtc.ConfigurationParameter] = (),
    callbacks: Iterable[str] = (),
) -> rtc.RtcProfile:
    """Return a profile in the strict form.

    Raises:
        Malformed: The name cannot be one, or names are used twice.
    """
    if not heading.name.isidentifier():
        raise Malformed(f"{heading.name!r} cannot be the name of a class, as a component's must be")
    for what in ("vendor", "category", "version"):
        if ":" in getattr(heading, what):
            raise Malformed(f"a {what} with a colon would break the id: {getattr(heading, what)}")
    data, services, items = tuple(data_ports), tuple(service_ports), tuple(parameters)
    _check_once("port", [port.name for port in data] + [port.name for port in services])
    _check_once("parameter", [item.name for item in items])
    id = ":".join(("RTC", heading.vendor, heading.category, heading.name, heading.version))
    return rtc.RtcProfile(
        id,
        rtc.RTC_VERSION,
        _basic_info(heading),
        _actions(callbacks),
        rtc.DeclaredParameters(items) if items else None,
        data_ports=data,
        service_ports=services,
        language=rtc.Language(heading.language),
    )


def _basic_info(heading: ComponentHeading) -> rtc.BasicInfo:
    is_periodic = heading.activity_type == "PERIODIC"
    return rtc.BasicInfo(
        heading.name,
        heading.component_type,
        heading.activity_type,
        "DataFlowComponent",
        heading.category,
        heading.vendor,
        heading.version,
        "PeriodicExecutionContext" if is_periodic else "EventDrivenExecutionContext",
        heading.date,
        heading.date,
        description=heading.description or None,
        execution_rate=heading.rate,
        max_instances=heading.max_instances,
    )


def _actions(callbacks: Iterable[str]) -> rtc.Actions:
    """Return all callbacks that there are methods for, those named as implemented.

    Raises:
        Malformed: There is no such callback.
    """
    fields = {name: field for field, name in ACTIONS.items() if field not in _LEFT_OUT}
    wanted = set()
    for name in callbacks:
        if name not in fields:
            raise Malformed(f"no such callback: {name}; there are {', '.join(fields)}")
        wanted.add(fields[name])
    stated: Any = {field: rtc.ActionStatus(field in wanted) for field in fields.values()}
    return rtc.Actions(**stated)


def _check_once(what: str, names: list[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise Malformed(f"{what} {name} is named twice")


def data_port(text: str, port_type: str) -> rtc.DataPortDeclaration:
    """Read ``NAME:TYPE``, ``NAME:TYPE:UNIT`` or ``…:FILE.idl``; a standard type needs no module.

    Raises:
        Malformed: It is none of these.
    """
    parts = _SINGLE_COLON.split(text)
    if len(parts) not in (2, 3) or not all(parts):
        raise Malformed(f"a data port is NAME:TYPE, NAME:TYPE:UNIT or NAME:TYPE:FILE.idl: {text}")
    name, data_type = _port_name(parts[0]), parts[1]
    full = f"RTC::{data_type}" if _STANDARD.fullmatch(data_type) else data_type
    position = "RIGHT" if port_type == "DataOutPort" else "LEFT"
    last = parts[2] if len(parts) == 3 else None
    is_file = last is not None and last.lower().endswith(".idl")
    idl_file, unit = (last, None) if is_file else (None, last)
    return rtc.DataPortDeclaration(port_type, name, full, position, idl_file, unit=unit)


class InterfaceWish(NamedTuple):
    """An interface and the port that it is to be at."""

    port: str
    interface: rtc.ServiceInterface


def interface(text: str, direction: str) -> InterfaceWish:
    """Read ``PORT:TYPE`` or ``PORT:TYPE:FILE.idl``; the interface is called as its type.

    Raises:
        Malformed: It is none of these.
    """
    parts = _SINGLE_COLON.split(text)
    if len(parts) not in (2, 3) or not all(parts):
        raise Malformed(f"an interface is PORT:TYPE or PORT:TYPE:FILE.idl: {text}")
    name = parts[1].rpartition("::")[2]
    idl_file = parts[2] if len(parts) == 3 else None
    found = rtc.ServiceInterface(name, direction, parts[1], idl_file=idl_file)
    return InterfaceWish(_port_name(parts[0]), found)


def service_ports(wishes: Iterable[InterfaceWish]) -> list[rtc.ServicePortDeclaration]:
    """Return service ports with all interfaces that are to be at each of them."""
    ports: dict[str, rtc.ServicePortDeclaration] = {}
    for wish in wishes:
        made = rtc.ServicePortDeclaration(
            wish.port, "RIGHT" if wish.interface.direction == "Provided" else "LEFT"
        )
        port = ports.get(wish.port, made)
        together = (*port.service_interfaces, wish.interface)
        ports[wish.port] = replace(port, service_interfaces=together)
    return list(ports.values())


def parameter(text: str) -> rtc.ConfigurationParameter:
    """Read ``NAME:TYPE=DEFAULT``, behind which ``;CONSTRAINT`` may stand.

    Raises:
        Malformed: It is nothing of that kind, or the constraint cannot be read.
    """
    declared, equals, value = text.partition("=")
    name, colon, type_name = declared.partition(":")
    if not (equals and colon and name.strip() and type_name.strip()):
        raise Malformed(f"a parameter is NAME:TYPE=DEFAULT or NAME:TYPE=DEFAULT;CONSTRAINT: {text}")
    default, _, rule = value.partition(";")
    constraint = parse_constraint(rule)
    return rtc.ConfigurationParameter(
        name.strip(), type_name.strip(), default, constraint=constraint
    )


def _port_name(text: str) -> str:
    if not _PORT_NAME.fullmatch(text):
        raise Malformed(f"{text!r} cannot be the name of a port")
    return text
