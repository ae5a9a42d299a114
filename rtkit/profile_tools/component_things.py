"""Splits an RTC profile into things that can be compared by name."""

from __future__ import annotations

from rtkit.profile.constraint_text import format_constraint
from rtkit.profile.rtc_model import (
    BasicInfo,
    ConfigurationParameter,
    DataPortDeclaration,
    RtcProfile,
)
from rtkit.profile.rtc_spec import ACTIONS
from rtkit.profile.words import normal_data_type
from rtkit.profile_tools.compared_things import (
    Collector,
    Thing,
    ThingKey,
    Things,
    as_fields,
    fields_of,
    picked,
    put,
)

_PARTS = ("basic_info", "actions", "configuration_set", "parameters", "data_ports", "service_ports")
_OF_INTERFACE = ("direction", "type", "instance_name", "idl_file")
_CONTAINERS = {"configuration_set": ("configurations",), "actions": tuple(ACTIONS)}


def component_things(profile: RtcProfile, takes_all: bool) -> Things:
    """Return the things of a profile: all, or those that matter to users of the component."""
    found = Collector(takes_all)
    put(found.things, ThingKey(0, "component", ""), Thing(_component(profile, takes_all)))
    for port in profile.data_ports:
        key = found.add((1, "port", port.name), port, _data_port(port), ("name", "events"))
        for event in port.events:
            fields = picked(event, "source", "target", "condition", "type")
            found.add((2, "event", f"{key.name}.{event.name}"), event, fields, ("name",), key)
    for service in profile.service_ports:
        without = ("name", "service_interfaces")
        key = found.add((1, "service port", service.name), service, {}, without)
        for each in service.service_interfaces:
            name = f"{service.name}.{each.name}"
            found.add((2, "interface", name), each, picked(each, *_OF_INTERFACE), ("name",), key)
    parameters = profile.configuration_set.configurations if profile.configuration_set else ()
    for item in parameters:
        found.add((3, "parameter", item.name), item, _parameter(item), ("name",))
    for old in profile.parameters:
        default = as_fields(default=old.default_value)
        found.add((3, "system parameter", old.name), old, default, ("name",))
    for field, name in ACTIONS.items():
        status = getattr(profile.actions, field, None)
        if status is not None and (takes_all or status.implemented):
            found.add((4, "callback", name), status, {})
    return found.things


def _component(profile: RtcProfile, takes_all: bool) -> dict[str, str]:
    info = profile.basic_info
    if not takes_all:
        language = profile.language.kind if profile.language else None
        return (_info(info) if info else {}) | as_fields(language=language)
    fields = fields_of(profile, _PARTS)
    for name, lists in _CONTAINERS.items():
        part = getattr(profile, name)
        if part is not None:
            fields |= {name: "there"} | fields_of(part, lists, f"{name}.")
    return fields | (fields_of(info, prefix="basic_info.") if info else {})


def _info(info: BasicInfo) -> dict[str, str]:
    kind = ("component_type", "activity_type", "component_kind", "rtc_type", "execution_type")
    return picked(info, "name", "vendor", "category", "version", *kind) | as_fields(
        execution_rate=info.execution_rate or None, max_instances=info.max_instances or None
    )


def _data_port(port: DataPortDeclaration) -> dict[str, str]:
    return as_fields(
        port_type=port.port_type,
        type=normal_data_type(port.type),
        unit=port.unit,
        constraint=format_constraint(port.constraint),
        idl_file=port.idl_file,
        interface_type=(port.interface_type or "").lower(),
        dataflow_type=(port.dataflow_type or "").lower(),
        subscription_type=(port.subscription_type or "").lower(),
    )


def _parameter(item: ConfigurationParameter) -> dict[str, str]:
    return as_fields(
        type=" ".join(item.type.split()).lower(),
        default=item.default_value,
        unit=item.unit,
        constraint=format_constraint(item.constraint),
    )
