"""Summarises an RTC profile."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.profile import rtc_model as rtc
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.constraint_text import format_constraint
from rtkit.profile.rtc_spec import ACTIONS
from rtkit.profile.rts_rules import NO_DATE
from rtkit.profile.words import values_in_sets
from rtkit.profile_tools.outline import Outline, entry
from rtkit.profile_tools.page import with_line_breaks

DIRECTIONS = {"DataInPort": "in", "DataOutPort": "out", "EventPort": "event"}


def component_summary(profile: rtc.RtcProfile) -> Outline:
    """Return the summary of an RTC profile."""
    info = profile.basic_info
    name = f"{info.name} {info.version}".rstrip() if info else "(a fragment, without a name)"
    below = [*_identity(profile), *_ports(profile), *_parameters(profile), *_behaviour(profile)]
    return entry(name, f"component type, RTC profile {profile.version}".rstrip(), below=below)


def _identity(profile: rtc.RtcProfile) -> Iterator[Outline]:
    info = profile.basic_info
    if profile.id:
        yield entry("id", profile.id)
    if info is not None:
        yield from _basic_info(info)
    if profile.language is not None:
        targets = [
            " ".join(filter(None, (target.lang_version, target.os, *target.os_versions)))
            for target in profile.language.targets
        ]
        yield entry("language", ", ".join(filter(None, (profile.language.kind, *targets))))


def _basic_info(info: rtc.BasicInfo) -> Iterator[Outline]:
    rows = [
        ("description", one_line(info.description)),
        ("abstract", one_line(info.abstract)),
        ("vendor", info.vendor),
        ("category", info.category),
        ("kind", ", ".join((info.component_type, info.activity_type, info.component_kind))),
        ("execution", f"{info.execution_type}{hertz(info.execution_rate)}"),
        ("instances", f"at most {info.max_instances}" if info.max_instances else ""),
        ("hardware", one_line(info.hardware_profile)),
        ("created", dates(info.creation_date, info.update_date)),
        ("license", one_line(info.doc.license) if info.doc else ""),
        ("comment", one_line(info.comment)),
    ]
    yield from (entry(name, value) for name, value in rows if value)
    yield from properties(info.properties)


def _ports(profile: rtc.RtcProfile) -> Iterator[Outline]:
    if profile.data_ports:
        yield entry("data ports", below=map(_data_port, profile.data_ports))
    if profile.service_ports:
        yield entry("service ports", below=map(_service_port, profile.service_ports))


def _data_port(port: rtc.DataPortDeclaration) -> Outline:
    description = one_line(port.comment) or (one_line(port.doc.description) if port.doc else "")
    unit = f"[{port.unit}]" if port.unit else ""
    below = map(_event, port.events)
    direction = DIRECTIONS[port.port_type]
    return entry(direction, port.name, f"{port.type} {unit}".rstrip(), description, below=below)


def _event(event: rtc.FsmTransition) -> Outline:
    condition = f"if {one_line(event.condition)}" if event.condition else ""
    way = f"{event.source} -> {event.target}"
    return entry("event", event.name or "(no name)", way, event.type or "", condition)


def _service_port(port: rtc.ServicePortDeclaration) -> Outline:
    below = [
        entry(each.direction.lower(), each.name, each.type, each.idl_file or "")
        for each in port.service_interfaces
    ]
    return entry(port.name, one_line(port.comment), below=below)


def _parameters(profile: rtc.RtcProfile) -> Iterator[Outline]:
    if profile.configuration_set and profile.configuration_set.configurations:
        yield entry("parameters", below=map(_parameter, profile.configuration_set.configurations))
    if profile.parameters:
        rows = (entry(each.name, each.default_value or "") for each in profile.parameters)
        yield entry("system parameters", below=rows)


def _parameter(item: rtc.ConfigurationParameter) -> Outline:
    value = f"{item.default_value} {item.unit or ''}".rstrip()
    limit = format_constraint(item.constraint)
    description = one_line(item.comment) or (one_line(item.doc.description) if item.doc else "")
    below = [entry("set", *pair) for pair in values_in_sets(item.properties).items()]
    return entry(item.name or "(no name)", item.type, value, limit, description, below=below)


def _behaviour(profile: rtc.RtcProfile) -> Iterator[Outline]:
    if profile.actions is None:
        return
    implemented = []
    for field, name in ACTIONS.items():
        status: rtc.ActionStatus | None = getattr(profile.actions, field)
        if status is not None and status.implemented:
            implemented.append(name)
    yield entry("callbacks", " ".join(implemented) or "(none)")


def properties(items: tuple[ExtensionProperty, ...]) -> Iterator[Outline]:
    """Yield one entry that holds the properties, if there are any."""
    if items:
        rows = (entry(item.name, one_line(item.value)) for item in items)
        yield entry("properties", below=rows)


def one_line(text: str | None) -> str:
    """Return a text on one line; empty for none."""
    return " ".join(with_line_breaks(text or "").split())


def dates(created: str, changed: str) -> str:
    """Return the dates of creation and change; empty where the profile has none."""
    if created == changed:
        return "" if created == NO_DATE else created
    return f"{created}, changed {changed}"


def hertz(rate: float | None) -> str:
    """Return a rate [Hz] as it is told behind its context; empty for none."""
    return f" {rate:g} Hz" if rate else ""
