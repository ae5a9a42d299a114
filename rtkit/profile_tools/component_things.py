"""Splits an RTC profile into things that can be compared by name."""

from __future__ import annotations

from collections.abc import Iterable

from rtkit.profile.constraint_model import Constraint
from rtkit.profile.constraint_text import format_constraint
from rtkit.profile.rtc_model import (
    BasicInfo,
    ConfigurationParameter,
    DataPortDeclaration,
    FsmTransition,
    RtcProfile,
)
from rtkit.profile.rtc_spec import ACTIONS
from rtkit.profile.words import normal_data_type
from rtkit.profile_tools.compared_things import (
    Thing,
    ThingKey,
    Things,
    fields_of,
    picked,
    put,
    told,
)

_PARTS = (
    "basic_info",
    "actions",
    "configuration_set",
    "parameters",
    "data_ports",
    "service_ports",
)
_OF_INTERFACE = ("direction", "type", "instance_name", "idl_file")
_CONTAINERS = {
    "configuration_set": ("configurations",),
    "actions": tuple(ACTIONS),
}


def component_things(profile: RtcProfile, takes_all: bool) -> Things:
    """Return the things of a profile: all, or those that matter to users of the component."""
    things: Things = {}
    put(things, ThingKey(0, "component", ""), Thing(_component(profile, takes_all)))
    for port in profile.data_ports:
        fields = fields_of(port, ("name", "events")) if takes_all else _data_port(port)
        key = put(things, ThingKey(1, "port", port.name), Thing(fields))
        _events(things, key, port.events, takes_all)
    for service in profile.service_ports:
        fields = fields_of(service, ("name", "service_interfaces")) if takes_all else {}
        key = put(things, ThingKey(1, "service port", service.name), Thing(fields))
        for each in service.service_interfaces:
            fields = fields_of(each, ("name",)) if takes_all else picked(each, *_OF_INTERFACE)
            put(things, ThingKey(2, "interface", f"{service.name}.{each.name}"), Thing(fields, key))
    if profile.configuration_set is not None:
        for item in profile.configuration_set.configurations:
            fields = fields_of(item, ("name",)) if takes_all else _parameter(item)
            put(things, ThingKey(3, "parameter", item.name), Thing(fields))
    for old in profile.parameters:
        fields = fields_of(old, ("name",)) if takes_all else told(default=old.default_value)
        put(things, ThingKey(3, "system parameter", old.name), Thing(fields))
    _actions(things, profile, takes_all)
    return things


def _component(profile: RtcProfile, takes_all: bool) -> dict[str, str]:
    info = profile.basic_info
    if not takes_all:
        language = profile.language.kind if profile.language else None
        return (_info(info) if info else {}) | told(language=language)
    fields = fields_of(profile, _PARTS)
    for name, lists in _CONTAINERS.items():
        part = getattr(profile, name)
        if part is not None:
            fields |= {name: "there"} | fields_of(part, lists, f"{name}.")
    return fields | (fields_of(info, prefix="basic_info.") if info else {})


def _info(info: BasicInfo) -> dict[str, str]:
    kind = ("component_type", "activity_type", "component_kind", "rtc_type", "execution_type")
    return picked(info, "name", "vendor", "category", "version", *kind) | told(
        execution_rate=info.execution_rate or None, max_instances=info.max_instances or None
    )


def _data_port(port: DataPortDeclaration) -> dict[str, str]:
    return told(
        port_type=port.port_type,
        type=normal_data_type(port.type),
        unit=port.unit,
        constraint=_constraint(port.constraint),
        idl_file=port.idl_file,
        interface_type=(port.interface_type or "").lower(),
        dataflow_type=(port.dataflow_type or "").lower(),
        subscription_type=(port.subscription_type or "").lower(),
    )


def _events(
    things: Things, port: ThingKey, events: Iterable[FsmTransition], takes_all: bool
) -> None:
    for event in events:
        fields = picked(event, "source", "target", "condition", "type")
        if takes_all:
            fields = fields_of(event, ("name",))
        put(things, ThingKey(2, "event", f"{port.name}.{event.name}"), Thing(fields, port))


def _parameter(item: ConfigurationParameter) -> dict[str, str]:
    return told(
        type=" ".join(item.type.split()).lower(),
        default=item.default_value,
        unit=item.unit,
        constraint=_constraint(item.constraint),
    )


def _constraint(constraint: Constraint | None) -> str:
    return "" if constraint is None else format_constraint(constraint)


def _actions(things: Things, profile: RtcProfile, takes_all: bool) -> None:
    for field, name in ACTIONS.items():
        status = getattr(profile.actions, field, None)
        if status is not None and (takes_all or status.implemented):
            fields = fields_of(status) if takes_all else {}
            put(things, ThingKey(4, "callback", name), Thing(fields))
