"""Builds the page about a component type from the documentation in its profile."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.drawing.component import component_svg
from rtkit.profile.constraint_text import format_constraint
from rtkit.profile.rtc_model import (
    ActionStatus,
    ConfigurationParameter,
    DataPortDeclaration,
    FsmTransition,
    RtcProfile,
    ServiceInterface,
    ServicePortDeclaration,
)
from rtkit.profile.rtc_spec import ACTIONS
from rtkit.profile.words import normal_data_type
from rtkit.profile_tools.component_scene import component_name, component_pins
from rtkit.profile_tools.component_summary import dates, hertz, one_line
from rtkit.profile_tools.page import Page, PageTable, Section, present, section

_DIRECTIONS = {"DataInPort": "in", "DataOutPort": "out", "EventPort": "event"}


def component_page(profile: RtcProfile) -> Page:
    """Return the page about a component type."""
    pins = component_pins(profile)
    found = (
        _about(profile),
        _data_ports(profile),
        _service_ports(profile),
        _parameters(profile),
        _callbacks(profile),
        _environment(profile),
        _history(profile),
    )
    name = component_name(profile)
    info = profile.basic_info
    return Page(
        name,
        one_line(info.description) if info else "",
        present(list(_facts(profile))),
        component_svg(name, pins) if pins else "",
        f"The ports of {name}",
        tuple(each for each in found if each is not None),
    )


def _facts(profile: RtcProfile) -> Iterator[tuple[str, str | None]]:
    info = profile.basic_info
    yield "Id", profile.id
    if info is not None:
        yield "Version", info.version
        yield "Vendor", info.vendor
        yield "Category", info.category
        yield "Kind", ", ".join((info.component_type, info.activity_type, info.component_kind))
        yield "Execution", f"{info.execution_type}{hertz(info.execution_rate)}"
        yield "Instances", f"at most {info.max_instances}" if info.max_instances else ""
        yield "Creator", info.doc.creator if info.doc else ""
        yield "License", info.doc.license if info.doc else ""
        yield "Dates", dates(info.creation_date, info.update_date)
    yield "Language", profile.language.kind if profile.language else ""


def _about(profile: RtcProfile) -> Section | None:
    info = profile.basic_info
    if info is None:
        return None
    doc = info.doc
    parts = [
        section("Input and output", [doc.inout if doc else ""]),
        section("Algorithm", [doc.algorithm if doc else ""]),
        section("Hardware", [info.hardware_profile]),
        section("References", [doc.reference if doc else ""]),
        section("Remarks", [info.comment]),
    ]
    return section("About", [doc.description if doc else "", info.abstract], parts=parts)


def _data_ports(profile: RtcProfile) -> Section | None:
    heads = ("Port", "Direction", "Type", "Unit", "Constraint", "Description")
    rows = tuple(_data_port_row(port) for port in profile.data_ports)
    parts = [_data_port(port) for port in profile.data_ports]
    return section("Data ports", table=PageTable(heads, rows), parts=parts)


def _data_port_row(port: DataPortDeclaration) -> tuple[str, ...]:
    return (
        port.name,
        _DIRECTIONS[port.port_type],
        port.type,
        port.unit or (port.doc.unit if port.doc else "") or "",
        format_constraint(port.constraint),
        (port.doc.description if port.doc else "") or port.comment or "",
    )


def _data_port(port: DataPortDeclaration) -> Section | None:
    doc = port.doc
    rows = [
        ("Type", doc.type if doc and not _is_same_type(doc.type, port.type) else ""),
        ("Number", doc.number if doc else ""),
        ("Semantics", doc.semantics if doc else ""),
        ("Occurrence", doc.occerrence if doc else ""),
        ("Operation", doc.operation if doc else ""),
        ("IDL file", port.idl_file),
    ]
    table = PageTable(("", ""), present(rows)) if present(rows) else None
    return section(port.name, table=table, parts=[_events(port.events)])


def _is_same_type(one: str | None, other: str) -> bool:
    return normal_data_type(one or "") == normal_data_type(other)


def _events(events: tuple[FsmTransition, ...]) -> Section | None:
    heads = ("Event", "From", "To", "Type", "Condition", "Description")
    rows = tuple(
        (
            event.name,
            event.source,
            event.target,
            event.type or "",
            one_line(event.condition),
            (event.doc.description if event.doc else "") or "",
        )
        for event in events
    )
    return section("Events", table=PageTable(heads, rows))


def _service_ports(profile: RtcProfile) -> Section | None:
    return section("Service ports", parts=[_service_port(each) for each in profile.service_ports])


def _service_port(port: ServicePortDeclaration) -> Section | None:
    heads = ("Interface", "Direction", "Type", "IDL file", "Description")
    rows = tuple(
        (
            each.name,
            each.direction.lower(),
            each.type,
            each.idl_file or "",
            (each.doc.description if each.doc else "") or each.comment or "",
        )
        for each in port.service_interfaces
    )
    texts = [port.comment]
    if port.doc is not None:
        texts += [port.doc.description, port.doc.ifdescription]
    parts = [_interface(each) for each in port.service_interfaces]
    found = section(port.name, texts, PageTable(heads, rows), parts)
    return found or Section(port.name, ("No interfaces.",))


def _interface(each: ServiceInterface) -> Section | None:
    doc = each.doc
    if doc is None:
        return None
    rows = present(
        [
            ("Arguments", doc.doc_argument),
            ("Returns", doc.doc_return),
            ("Exceptions", doc.doc_exception),
            ("Before", doc.doc_pre_condition),
            ("After", doc.doc_post_condition),
        ]
    )
    return section(each.name, table=PageTable(("", ""), rows))


def _parameters(profile: RtcProfile) -> Section | None:
    if profile.configuration_set is None:
        return None
    heads = ("Parameter", "Type", "Default", "Unit", "Allowed", "Description")
    rows = tuple(_parameter(item) for item in profile.configuration_set.configurations)
    return section("Configuration parameters", table=PageTable(heads, rows))


def _parameter(item: ConfigurationParameter) -> tuple[str, ...]:
    doc = item.doc
    limits = [format_constraint(item.constraint)]
    told = [item.comment]
    if doc is not None:
        limits = [limits[0] or doc.range or "", doc.constraint or ""]
        is_named = doc.dataname and doc.dataname != item.name
        told = [doc.description, item.comment, f"Data: {doc.dataname}" if is_named else ""]
    unit = item.unit or (doc.unit if doc else "") or ""
    return (
        item.name,
        item.type,
        item.default_value,
        unit,
        ", ".join(dict.fromkeys(filter(None, limits))),
        "\n".join(dict.fromkeys(text for text in told if text)),
    )


def _callbacks(profile: RtcProfile) -> Section | None:
    heads = ("Callback", "Description", "Before", "After")
    rows = []
    for field, name in ACTIONS.items():
        status: ActionStatus | None = getattr(profile.actions, field, None)
        if status is None or not status.implemented:
            continue
        doc = status.doc
        texts = (doc.description, doc.pre_condition, doc.post_condition) if doc else ("", "", "")
        rows.append((name, *(text or "" for text in texts)))
    if not any(any(row[1:]) for row in rows):
        return section("Callbacks", [", ".join(row[0] for row in rows)])
    return section("Callbacks", table=PageTable(heads, tuple(rows)))


def _environment(profile: RtcProfile) -> Section | None:
    if profile.language is None:
        return None
    heads = ("Language", "Operating system", "Processor", "Libraries", "Remarks")
    rows = tuple(
        (
            " ".join(filter(None, (profile.language.kind, target.lang_version))),
            " ".join(filter(None, (target.os, *target.os_versions))),
            " ".join(filter(None, (*target.cpus, target.cpu_other))),
            ", ".join(
                " ".join(filter(None, (lib.name, lib.version, lib.other)))
                for lib in target.libraries
            ),
            target.other or "",
        )
        for target in profile.language.targets
    )
    return section("Environments", table=PageTable(heads, rows))


def _history(profile: RtcProfile) -> Section | None:
    logs = profile.basic_info.version_up_logs if profile.basic_info else ()
    return section("History", logs)
