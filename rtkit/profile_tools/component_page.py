"""Builds the page about a component type from the documentation in its profile."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.drawing.component import component_svg
from rtkit.profile import rtc_model as rtc
from rtkit.profile.constraint_text import format_constraint
from rtkit.profile.rtc_spec import ACTIONS
from rtkit.profile.words import normal_data_type, values_in_sets
from rtkit.profile_tools.component_scene import component_name, component_pins
from rtkit.profile_tools.component_summary import DIRECTIONS, dates, hertz, one_line
from rtkit.profile_tools.page import Page, PageTable, Section, present, section


def component_page(profile: rtc.RtcProfile) -> Page:
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


def _facts(profile: rtc.RtcProfile) -> Iterator[tuple[str, str | None]]:
    info = profile.basic_info
    yield "Id", profile.id
    if info is not None:
        yield "Version", info.version
        yield "Vendor", info.vendor
        yield "Category", info.category
        yield "Kind", ", ".join((info.component_type, info.activity_type, info.component_kind))
        yield "Execution", f"{info.execution_type}{hertz(info.execution_rate)}"
        yield "Instances", f"at most {info.max_instances}" if info.max_instances else ""
        doc = info.doc or rtc.BasicDoc()
        yield "Creator", doc.creator
        yield "License", doc.license
        yield "Dates", dates(info.creation_date, info.update_date)
    yield "Language", profile.language.kind if profile.language else ""


def _about(profile: rtc.RtcProfile) -> Section | None:
    info = profile.basic_info
    if info is None:
        return None
    doc = info.doc or rtc.BasicDoc()
    texts = {
        "Input and output": doc.inout,
        "Algorithm": doc.algorithm,
        "Hardware": info.hardware_profile,
        "References": doc.reference,
        "Remarks": info.comment,
    }
    parts = [section(title, [text]) for title, text in texts.items()]
    return section("About", [doc.description, info.abstract], parts=parts)


def _data_ports(profile: rtc.RtcProfile) -> Section | None:
    heads = ("Port", "Direction", "Type", "Unit", "Constraint", "Description")
    rows = tuple(_data_port_row(port) for port in profile.data_ports)
    parts = [_data_port(port) for port in profile.data_ports]
    return section("Data ports", table=PageTable(heads, rows), parts=parts)


def _data_port_row(port: rtc.DataPortDeclaration) -> tuple[str, ...]:
    doc = port.doc or rtc.DataPortDoc()
    return (
        port.name,
        DIRECTIONS[port.port_type],
        port.type,
        port.unit or doc.unit or "",
        format_constraint(port.constraint),
        doc.description or port.comment or "",
    )


def _data_port(port: rtc.DataPortDeclaration) -> Section | None:
    doc = port.doc or rtc.DataPortDoc()
    is_same = normal_data_type(doc.type or "") == normal_data_type(port.type)
    rows = [
        ("Type", "" if is_same else doc.type),
        ("Number", doc.number),
        ("Semantics", doc.semantics),
        ("Occurrence", doc.occerrence),
        ("Operation", doc.operation),
        ("IDL file", port.idl_file),
    ]
    table = PageTable(("", ""), present(rows)) if present(rows) else None
    return section(port.name, table=table, parts=[_events(port.events)])


def _events(events: tuple[rtc.FsmTransition, ...]) -> Section | None:
    heads = ("Event", "From", "To", "Type", "Condition", "Description")
    rows = tuple(
        (
            event.name,
            event.source,
            event.target,
            event.type or "",
            one_line(event.condition),
            (event.doc or rtc.EventDoc()).description or "",
        )
        for event in events
    )
    return section("Events", table=PageTable(heads, rows))


def _service_ports(profile: rtc.RtcProfile) -> Section | None:
    return section("Service ports", parts=[_service_port(each) for each in profile.service_ports])


def _service_port(port: rtc.ServicePortDeclaration) -> Section | None:
    heads = ("Interface", "Direction", "Type", "IDL file", "Description")
    rows = tuple(
        (
            each.name,
            each.direction.lower(),
            each.type,
            each.idl_file or "",
            (each.doc or rtc.ServiceInterfaceDoc()).description or each.comment or "",
        )
        for each in port.service_interfaces
    )
    doc = port.doc or rtc.ServicePortDoc()
    texts = [port.comment, doc.description, doc.ifdescription]
    parts = [_interface(each) for each in port.service_interfaces]
    found = section(port.name, texts, PageTable(heads, rows), parts)
    return found or Section(port.name, ("No interfaces.",))


def _interface(each: rtc.ServiceInterface) -> Section | None:
    doc = each.doc or rtc.ServiceInterfaceDoc()
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


def _parameters(profile: rtc.RtcProfile) -> Section | None:
    if profile.configuration_set is None:
        return None
    heads = ("Parameter", "Type", "Default", "Unit", "Allowed", "Description")
    rows = tuple(_parameter(item) for item in profile.configuration_set.configurations)
    return section("Configuration parameters", table=PageTable(heads, rows))


def _parameter(item: rtc.ConfigurationParameter) -> tuple[str, ...]:
    doc = item.doc or rtc.ConfigurationDoc()
    limits = [format_constraint(item.constraint) or doc.range or "", doc.constraint or ""]
    is_named = doc.dataname and doc.dataname != item.name
    texts = [doc.description, item.comment, f"Data: {doc.dataname}" if is_named else ""]
    texts += [f"In set {name}: {text}" for name, text in values_in_sets(item.properties).items()]
    return (
        item.name,
        item.type,
        item.default_value,
        item.unit or doc.unit or "",
        ", ".join(dict.fromkeys(filter(None, limits))),
        "\n".join(dict.fromkeys(text for text in texts if text)),
    )


def _callbacks(profile: rtc.RtcProfile) -> Section | None:
    heads = ("Callback", "Description", "Before", "After")
    rows = []
    for field, name in ACTIONS.items():
        status: rtc.ActionStatus | None = getattr(profile.actions, field, None)
        if status is None or not status.implemented:
            continue
        doc = status.doc or rtc.ActionDoc()
        texts = (doc.description, doc.pre_condition, doc.post_condition)
        rows.append((name, *(text or "" for text in texts)))
    if not any(any(row[1:]) for row in rows):
        return section("Callbacks", [", ".join(row[0] for row in rows)])
    return section("Callbacks", table=PageTable(heads, tuple(rows)))


def _environment(profile: rtc.RtcProfile) -> Section | None:
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


def _history(profile: rtc.RtcProfile) -> Section | None:
    logs = profile.basic_info.version_up_logs if profile.basic_info else ()
    return section("History", logs)
