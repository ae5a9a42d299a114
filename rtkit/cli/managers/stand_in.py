"""Converts an RTC profile to the pattern of a stand-in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.profile.ports import declared_interfaces
from rtkit.profile.words import property_value, values_in_sets
from rtkit.rtc.enums import ExecutionKind, PortType
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.port_types import declared_port_type
from rtkit.rtc.profiles import PortProfile, TypeProfile

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import DataPortDeclaration, RtcProfile, ServicePortDeclaration

_DEFAULT_RATE = 1000.0


def read_pattern(file: str) -> ComponentPattern:
    """Read the RTC profile in `file`.

    Raises:
        NotFound: There is no such file.
        InvalidDocument: It is no RTC profile.
    """
    from rtkit.profile.read import read_bytes, read_rtc

    return pattern_of(read_rtc(read_bytes(file), file).profile)


def pattern_of(profile: RtcProfile) -> ComponentPattern:
    """Return the pattern of the component type that a profile describes."""
    ports = [_data_port(port) for port in profile.data_ports]
    ports += [_service_port(port) for port in profile.service_ports]
    return ComponentPattern(
        _type(profile), tuple(ports), _sets(profile), "default", contexts=(_context(profile),)
    )


def _type(profile: RtcProfile) -> TypeProfile:
    language = profile.language.kind if profile.language is not None else "Python"
    info = profile.basic_info
    if info is None:
        _, vendor, category, name, version = (profile.id.split(":") + [""] * 5)[:5]
        return TypeProfile(name, vendor, category, version, language=language)
    return TypeProfile(
        info.name, info.vendor, info.category, info.version, info.description or "", language
    )


def _sets(profile: RtcProfile) -> dict[str, dict[str, str]]:
    """Return the default values, and the hints that components with code give too."""
    from rtkit.profile.constraint_text import format_constraint

    sets: dict[str, dict[str, str]] = {"default": {}}
    declared = profile.configuration_set
    for each in declared.configurations if declared is not None else ():
        texts = {
            "default": each.default_value,
            "__type__": each.type,
            "__constraints__": format_constraint(each.constraint),
            "__widget__": property_value(each.properties, "__widget__") or "",
            **values_in_sets(each.properties),
        }
        for set_id, text in texts.items():
            if text or set_id == "default":
                sets.setdefault(set_id, {})[each.name] = text
    return sets


def _context(profile: RtcProfile) -> ContextPattern:
    info = profile.basic_info
    rate = (info.execution_rate if info is not None else None) or _DEFAULT_RATE
    word = info.execution_type.lower() if info is not None else "periodic"
    if "periodic" in word or not word:
        return ContextPattern(rate=rate)
    kind = ExecutionKind.EVENT_DRIVEN if "event" in word else ExecutionKind.OTHER
    return ContextPattern(kind=kind, rate=rate)


def _data_port(port: DataPortDeclaration) -> PortProfile:
    kind = declared_port_type(port.port_type)
    fields = {
        "dataport.data_type": port.type,
        "dataport.interface_type": port.interface_type,
        "dataport.dataflow_type": port.dataflow_type,
        "dataport.subscription_type": port.subscription_type,
        "description": port.comment,
    }
    properties = {key: value for key, value in fields.items() if value}
    return PortProfile(port.name, kind, {"port.port_type": kind.value, **properties})


def _service_port(port: ServicePortDeclaration) -> PortProfile:
    properties = {"port.port_type": PortType.SERVICE.value}
    if port.comment:
        properties["description"] = port.comment
    return PortProfile(port.name, PortType.SERVICE, properties, declared_interfaces(port))
