"""Builds the page about a system: its drawing, components, connectors, orders."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.drawing.svg import picture
from rtkit.profile.rts_model import ComponentInstance, RtsProfile
from rtkit.profile.rts_spec import ORDERS
from rtkit.profile.words import normal_data_type
from rtkit.profile_tools.component_summary import dates, hertz, one_line
from rtkit.profile_tools.page import Page, PageTable, Section, present, section
from rtkit.profile_tools.system_scene import system_scene
from rtkit.profile_tools.system_summary import end_name, short_type, target_name, waited_for


def system_page(profile: RtsProfile) -> Page:
    """Return the page about a system."""
    scene = system_scene(profile)
    facts = [
        ("Id", profile.id),
        ("Dates", dates(profile.creation_date, profile.update_date)),
        ("Remarks", profile.comment),
    ]
    found = (
        _components(profile),
        _parameters(profile),
        _connectors(profile),
        _orders(profile),
        _groups(profile),
        section("History", profile.version_up_logs),
    )
    return Page(
        system_name(profile),
        one_line(profile.abstract),
        present(facts),
        picture(scene) if scene.boxes else "",
        f"The components and connectors of {system_name(profile)}",
        tuple(each for each in found if each is not None),
    )


def system_name(profile: RtsProfile) -> str:
    """Return the name of a system, which its id holds: ``RTSystem:vendor:name:version``."""
    parts = profile.id.split(":")
    return parts[2] if len(parts) == 4 and parts[2] else profile.id


def _components(profile: RtsProfile) -> Section | None:
    heads = ("Component", "Type", "Path", "Context", "Required", "Remarks")
    rows = tuple(
        (
            each.instance_name,
            each.id,
            each.path_uri,
            ", ".join(f"{one.kind}{hertz(one.rate)}" for one in each.execution_contexts),
            "" if each.is_required else "no",
            one_line(each.comment),
        )
        for each in profile.components
    )
    return section("Components", table=PageTable(heads, rows))


def _parameters(profile: RtsProfile) -> Section | None:
    rows = tuple(row for component in profile.components for row in _settings(component))
    heads = ("Component", "Set", "Parameter", "Value")
    return section("Configuration", table=PageTable(heads, rows))


def _settings(component: ComponentInstance) -> Iterator[tuple[str, ...]]:
    for each in component.configuration_sets:
        is_active = each.id == component.active_configuration_set
        for item in () if each.id.startswith("__") else each.data:
            name = f"{each.id} (active)" if is_active else each.id
            yield component.instance_name, name, item.name, item.data or ""


def _connectors(profile: RtsProfile) -> Section | None:
    rows = [
        (
            end_name(each.source),
            end_name(each.target),
            short_type(normal_data_type(each.data_type)),
            " ".join(filter(None, (each.dataflow_type, each.subscription_type))).lower(),
            each.interface_type.lower(),
        )
        for each in profile.data_port_connectors
    ]
    rows += [
        (end_name(each.source), end_name(each.target), "service", "", each.trans_method or "")
        for each in profile.service_port_connectors
    ]
    heads = ("From", "To", "Type", "Flow", "By")
    return section("Connectors", table=PageTable(heads, tuple(rows)))


def _orders(profile: RtsProfile) -> Section | None:
    rows = []
    for field, name in ORDERS:
        order = getattr(profile, field)
        for step in sorted(order.targets if order else (), key=lambda step: step.sequence):
            rows.append(
                (name, str(step.sequence), target_name(step.target_component), waited_for(step))
            )
    return section("Orders", table=PageTable(("Order", "Step", "Component", "When"), tuple(rows)))


def _groups(profile: RtsProfile) -> Section | None:
    rows = tuple(
        (group.group_id, ", ".join(member.instance_name for member in group.members))
        for group in profile.groups
    )
    return section("Groups", table=PageTable(("Group", "Members"), rows))
