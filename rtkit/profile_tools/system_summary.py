"""Summarises an RTS profile."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.profile import rts_model as rts
from rtkit.profile.ports import DataPortFacts, DataPortKey, data_port_facts
from rtkit.profile.rts_spec import ORDERS
from rtkit.profile.words import OWN_PREFIX, normal_data_type, strip_instance
from rtkit.profile_tools.component_summary import dates, hertz, one_line, properties
from rtkit.profile_tools.outline import Outline, entry
from rtkit.rtc.enums import PortType

_HIDDEN = "__"
_DIRECTIONS = {PortType.IN: "in", PortType.OUT: "out", None: "data"}
_Facts = dict[DataPortKey, DataPortFacts]


def system_summary(profile: rts.RtsProfile) -> Outline:
    """Return the summary of an RTS profile."""
    facts = data_port_facts(profile)
    below = [
        *_head(profile),
        *_listed("components", (_component(each, facts) for each in profile.components)),
        *_listed("data connectors", map(_data_connector, profile.data_port_connectors)),
        *_listed("service connectors", map(_service_connector, profile.service_port_connectors)),
        *_orders(profile),
        *_groups(profile),
        *_listed("systems", (entry(system.path) for system in profile.systems)),
        *properties(profile.properties),
    ]
    return entry(profile.id, f"system, RTS profile {profile.version}".rstrip(), below=below)


def _head(profile: rts.RtsProfile) -> Iterator[Outline]:
    rows = [
        ("abstract", one_line(profile.abstract)),
        ("comment", one_line(profile.comment)),
        ("created", dates(profile.creation_date, profile.update_date)),
    ]
    yield from (entry(name, value) for name, value in rows if value)


def _listed(name: str, rows: Iterator[Outline] | map[Outline]) -> Iterator[Outline]:
    """Yield an entry with its rows, counted, if there are any."""
    listed = tuple(rows)
    if listed:
        yield entry(f"{name} ({len(listed)})", below=listed)


def _component(component: rts.ComponentInstance, facts: _Facts) -> Outline:
    rows = [
        ("path", component.path_uri),
        ("composite", _unless_none(component.composite_type)),
        ("required", "" if component.is_required else "no"),
        ("comment", one_line(component.comment)),
    ]
    below = [entry(name, value) for name, value in rows if value]
    below += [_data_port(component, port.name, facts) for port in component.data_ports]
    below += [
        entry("service", strip_instance(port.name, component.instance_name))
        for port in component.service_ports
    ]
    below += [
        _set(each, is_active=each.id == component.active_configuration_set)
        for each in component.configuration_sets
        if not each.id.startswith(_HIDDEN)
    ]
    below += map(_context, component.execution_contexts)
    below += [entry("participant", each.instance_name) for each in component.participants]
    own = (each for each in component.properties if each.name.startswith(OWN_PREFIX))
    below += properties(tuple(own))
    return entry(component.instance_name, component.id, below=below)


def _unless_none(composite_type: str | None) -> str:
    return "" if composite_type in (None, "None") else str(composite_type)


def _data_port(component: rts.ComponentInstance, name: str, facts: _Facts) -> Outline:
    port = strip_instance(name, component.instance_name)
    known = facts[DataPortKey(component.id, component.instance_name, port)]
    return entry(_DIRECTIONS[known.direction], port, short_type(known.data_type))


def short_type(data_type: str) -> str:
    """Return a data type as people write it.

    >>> short_type("IDL:RTC/TimedLong:1.0"), short_type("IDL:Img/TimedCameraImage:1.0")
    ('TimedLong', 'Img::TimedCameraImage')
    """
    name = data_type.removeprefix("IDL:").removesuffix(":1.0")
    return name.removeprefix("RTC/").replace("/", "::")


def _set(configuration: rts.ConfigurationSet, *, is_active: bool) -> Outline:
    rows = (entry(item.name, one_line(item.data)) for item in configuration.data)
    return entry("set", f"{configuration.id}{'*' if is_active else ''}", below=rows)


def _context(context: rts.OwnedContext) -> Outline:
    below = [entry("participant", each.instance_name) for each in context.participants]
    return entry("context", context.id, f"{context.kind}{hertz(context.rate)}", below=below)


def _data_connector(connector: rts.DataPortConnector) -> Outline:
    how = (connector.dataflow_type, connector.subscription_type, connector.interface_type)
    types = " ".join(text.lower() for text in how if text)
    data_type = short_type(normal_data_type(connector.data_type))
    return entry(connected(connector.source, connector.target), data_type, types)


def _service_connector(connector: rts.ServicePortConnector) -> Outline:
    return entry(connected(connector.source, connector.target, "--"), connector.trans_method or "")


def connected(source: rts.TargetPort, target: rts.TargetPort, arrow: str = "->") -> str:
    """Return both ends of a connector."""
    return f"{end_name(source)} {arrow} {end_name(target)}"


def end_name(end: rts.TargetPort) -> str:
    """Return an end of a connector, ``INSTANCE.PORT``."""
    return f"{end.instance_name}.{strip_instance(end.port_name, end.instance_name)}"


def _orders(profile: rts.RtsProfile) -> Iterator[Outline]:
    for field, name in ORDERS:
        order = getattr(profile, field)
        if order is not None:
            steps = sorted(order.targets, key=lambda step: step.sequence)
            words = "".join(f" {c.lower()}" if c.isupper() else c for c in name).strip()
            yield from _listed(words, map(_step, steps))


def _step(step: rts.OrderStep) -> Outline:
    target = target_name(step.target_component)
    return entry(str(step.sequence), target, waited_for(step))


def target_name(target: rts.TargetComponent) -> str:
    """Return the name of an order's target."""
    context = "" if target.id == "0" else f" in context {target.id}"
    return f"{target.instance_name}{context}"


def waited_for(step: rts.OrderStep) -> str:
    """Return the precondition of an order's step; empty for none."""
    if step.wait_time is not None and step.wait_time.wait_time:
        return f"after {step.wait_time.wait_time} ms"
    if step.preceding is None or not step.preceding.preceding_components:
        return ""
    names = ", ".join(map(target_name, step.preceding.preceding_components))
    timing = step.preceding.sending_timing or "SYNC"
    most = f", at most {step.preceding.timeout} ms" if step.preceding.timeout else ""
    return f"when {names} {'is done' if timing == 'SYNC' else 'was told'} ({timing}){most}"


def _groups(profile: rts.RtsProfile) -> Iterator[Outline]:
    rows = [
        entry(group.group_id, ", ".join(member.instance_name for member in group.members))
        for group in profile.groups
    ]
    return _listed("groups", iter(rows))
