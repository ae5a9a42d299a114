"""Splits an RTS profile into things that can be compared by name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterable

from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_spec import ORDERS
from rtkit.profile.words import OWN_PREFIX, normal_data_type, property_value, strip_instance
from rtkit.profile_tools.compared_things import Collector, ThingKey, Things, as_fields

_Names = dict[tuple[str, str], str]
"""Names of components in a comparison, by id and instance name."""

_PARTS = (
    "components",
    "groups",
    "data_port_connectors",
    "service_port_connectors",
    "systems",
    "variables",
    "includes",
    *(field for field, _ in ORDERS),
)
_OF_COMPONENT = (
    "instance_name",
    "data_ports",
    "service_ports",
    "configuration_sets",
    "execution_contexts",
)
_HIDDEN = "__"
_OPTIONS = ("dataport.", "port.", OWN_PREFIX)
_OF_THE_RUN = ("_ior", "_ref")
_GIVEN_BY_ATTRIBUTES = tuple(
    f"dataport.{name}"
    for name in ("data_type", "interface_type", "dataflow_type", "subscription_type")
)


def shared_names(profile: rts.RtsProfile) -> set[str]:
    """Return the instance names that several components of a system have."""
    counts = Counter(component.instance_name for component in profile.components)
    return {name for name, count in counts.items() if count > 1}


def system_things(profile: rts.RtsProfile, takes_all: bool, shared: Container[str] = ()) -> Things:
    """Return the things of a profile: all of it, or what it means for the running system.

    Components are called by their instance name, those of `shared` names by their path too.
    """
    found = Collector(takes_all)
    names = _names(profile.components, shared)
    own = _options(profile.properties, (OWN_PREFIX,))
    found.add((0, "system", ""), profile, own, _PARTS)
    for component in profile.components:
        name = names[component.id, component.instance_name]
        meaning = _component(component)
        owner = found.add((1, "component", name), component, meaning, _OF_COMPONENT)
        _parts(found, owner, component)
    _ports(found, profile, names)
    for connector in profile.data_port_connectors:
        name = f"{_end(connector.source, names)} -> {_end(connector.target, names)}"
        found.add((6, "connector", name), connector, _data_connector(connector))
    for service in profile.service_port_connectors:
        ends = sorted((_end(service.source, names), _end(service.target, names)))
        key = (6, "service connector", " -- ".join(ends))
        found.add(key, service, _service_connector(service))
    _orders(found, profile, names)
    for group in profile.groups:
        members = sorted(_called(names, m.component_id, m.instance_name) for m in group.members)
        found.add((8, "group", group.group_id), group, as_fields(members=", ".join(members)))
    for system in profile.systems:
        found.add((9, "system", system.path), system, {})
    for variable in profile.variables:
        meaning = as_fields(default=variable.default)
        found.add((9, "variable", variable.name), variable, meaning)
    for include in profile.includes:
        values = {each.name: each.value for each in include.values}
        name = f"{include.prefix or ''} {include.file}".strip()
        found.add((9, "include", name), include, values, ("values",))
    return found.things


def _names(components: Iterable[rts.ComponentInstance], shared: Container[str]) -> _Names:
    return {
        (component.id, component.instance_name): component.instance_name
        if component.instance_name not in shared
        else f"{component.instance_name} at {component.path_uri}"
        for component in components
    }


def _called(names: _Names, component_id: str, instance_name: str) -> str:
    return names.get((component_id, instance_name), instance_name)


def _component(component: rts.ComponentInstance) -> dict[str, str]:
    composite = component.composite_type
    participants = sorted(each.instance_name for each in component.participants)
    return as_fields(
        type=component.id,
        path=component.path_uri,
        required=component.is_required,
        active_set=component.active_configuration_set,
        composite="" if composite == "None" else composite,
        participants=", ".join(participants),
    ) | _options(component.properties, (OWN_PREFIX,))


def _parts(found: Collector, owner: ThingKey, component: rts.ComponentInstance) -> None:
    for each in component.configuration_sets:
        if each.id.startswith(_HIDDEN) and not found.takes_all:
            continue
        key = found.add((3, "set", f"{owner.name} {each.id}"), each, {}, ("id", "data"), owner)
        for item in each.data:
            name = f"{key.name}.{item.name}"
            found.add((4, "parameter", name), item, {"value": item.data or ""}, ("name",), key)
    for context in component.execution_contexts:
        name = f"{owner.name} {context.id}"
        found.add((5, "context", name), context, _context(context), ("id",), owner)


def _context(context: rts.OwnedContext) -> dict[str, str]:
    participants = sorted(each.instance_name for each in context.participants)
    return as_fields(kind=context.kind, rate=context.rate, participants=", ".join(participants))


def _ports(found: Collector, profile: rts.RtsProfile, names: _Names) -> None:
    for component in profile.components:
        name = names[component.id, component.instance_name]
        owner = ThingKey(1, "component", name)
        for kind, ports in (
            ("port", component.data_ports),
            ("service port", component.service_ports),
        ):
            for port in ports:
                own = strip_instance(port.name, component.instance_name)
                meaning = _data_port(port) if kind == "port" else {}
                found.add((2, kind, f"{name}.{own}"), port, meaning, (), owner)


def _data_port(port: rts.InstancePort) -> dict[str, str]:
    """Return the fields of a port itself, without those inferred from its connectors."""
    return as_fields(
        direction=property_value(port.properties, "port.port_type"),
        type=normal_data_type(property_value(port.properties, "dataport.data_type") or ""),
    )


def _end(end: rts.TargetPort, names: _Names) -> str:
    port = strip_instance(end.port_name, end.instance_name)
    return f"{_called(names, end.component_id, end.instance_name)}.{port}"


def _data_connector(connector: rts.DataPortConnector) -> dict[str, str]:
    return as_fields(
        data_type=normal_data_type(connector.data_type),
        interface_type=connector.interface_type.lower(),
        dataflow_type=connector.dataflow_type.lower(),
        subscription_type=(connector.subscription_type or "").lower(),
        push_interval=connector.push_interval,
    ) | _options(connector.properties, _OPTIONS)


def _service_connector(connector: rts.ServicePortConnector) -> dict[str, str]:
    return as_fields(trans_method=connector.trans_method) | _options(connector.properties, _OPTIONS)


def _options(properties: Iterable[ExtensionProperty], prefixes: tuple[str, ...]) -> dict[str, str]:
    """Return the properties of the desired state, without history and appearance."""
    return {
        item.name: item.value or ""
        for item in properties
        if item.name.startswith(prefixes)
        and not item.name.endswith(_OF_THE_RUN)
        and item.name not in _GIVEN_BY_ATTRIBUTES
    }


def _orders(found: Collector, profile: rts.RtsProfile, names: _Names) -> None:
    for field, name in ORDERS:
        order = getattr(profile, field)
        if order is None or not (found.takes_all or order.targets):
            continue
        owner = found.add((7, "order", name), order, {}, ("targets",))
        for step in order.targets:
            step_name = f"{name} {step.sequence} {_target(step.target_component, names)}"
            found.add((7, "step", step_name), step, _step(step, names), (), owner)


def _target(target: rts.TargetComponent, names: _Names) -> str:
    return f"{_called(names, target.component_id, target.instance_name)} in {target.id}"


def _step(step: rts.OrderStep, names: _Names) -> dict[str, str]:
    preceding = step.preceding
    fields = as_fields(wait_ms=step.wait_time.wait_time if step.wait_time else None)
    if preceding is not None:
        after = ", ".join(_target(each, names) for each in preceding.preceding_components)
        timing = preceding.sending_timing or "SYNC"
        fields |= as_fields(after=after, timing=timing, timeout_ms=preceding.timeout or None)
    return fields
