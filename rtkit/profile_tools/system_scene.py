"""Drawing input of a system profile: components, pins and connections."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtkit.drawing import scene as s
from rtkit.drawing.sides import with_sides
from rtkit.profile import rts_model as rts
from rtkit.profile.ports import DataPortFacts, DataPortKey, data_port_facts
from rtkit.profile.words import normal_data_type, strip_instance
from rtkit.profile_tools.system_summary import short_type
from rtkit.rtc.enums import PortType

_Ports = dict[tuple[str, str, str, str], s.WireEnd]
"""Boxes and ports by component id, instance, kind and port name."""

_DATA, _SERVICE = "data", "service"
_KINDS = {PortType.IN: s.IN, PortType.OUT: s.OUT, None: s.DATA}


def system_scene(profile: rts.RtsProfile) -> s.Scene:
    """Return components, ports and connectors of a system."""
    facts = data_port_facts(profile)
    hosts = {_host(component) for component in profile.components}
    ends: _Ports = {}
    boxes = []
    for index, component in enumerate(profile.components):
        ports = [*_data_ports(component, facts), *_service_ports(component)]
        for place, (key, _) in enumerate(ports):
            ends.setdefault(key, s.WireEnd(index, place))
        boxes.append(_box(component, [port for _, port in ports], len(hosts) > 1))
    connectors = [
        *(_wire(each, _DATA, ends) for each in profile.data_port_connectors),
        *(_wire(each, _SERVICE, ends) for each in profile.service_port_connectors),
    ]
    drawn = tuple(connector for connector in connectors if connector is not None)
    return with_sides(s.Scene(tuple(boxes), drawn, tuple(_frames(profile))))


def _frames(profile: rts.RtsProfile) -> Iterator[s.Frame]:
    """Yield the composites whose members are in the profile."""
    places = {each.instance_name: place for place, each in enumerate(profile.components)}
    for place, component in enumerate(profile.components):
        names = [each.instance_name for each in component.participants]
        members = tuple(places[name] for name in names if name in places)
        if component.composite_type not in (None, "None") and members:
            yield s.Frame(place, members)


_Listed = list[tuple[tuple[str, str, str, str], s.PortPin]]


def _data_ports(
    component: rts.ComponentInstance, facts: dict[DataPortKey, DataPortFacts]
) -> _Listed:
    listed = []
    for port in component.data_ports:
        name = strip_instance(port.name, component.instance_name)
        known = facts[DataPortKey(component.id, component.instance_name, name)]
        kind = _KINDS[known.direction]
        side = s.RIGHT if kind == s.OUT else s.LEFT
        tip = " ".join(filter(None, (name, short_type(known.data_type))))
        key = (component.id, component.instance_name, _DATA, name)
        listed.append((key, s.PortPin(name, side, kind, tip)))
    return listed


def _service_ports(component: rts.ComponentInstance) -> _Listed:
    listed = []
    for port in component.service_ports:
        name = strip_instance(port.name, component.instance_name)
        key = (component.id, component.instance_name, _SERVICE, name)
        listed.append((key, s.PortPin(name, s.LEFT, s.SERVICE, f"{name} (service port)")))
    return listed


def _box(component: rts.ComponentInstance, ports: Iterable[s.PortPin], has_host: bool) -> s.Box:
    type_name = component.id.split(":")[3] if component.id.count(":") >= 4 else component.id
    # The name of the type says nothing more where the instance has it too.
    parts = ["" if type_name == component.instance_name else type_name]
    parts += [f"on {_host(component)}"] if has_host and _host(component) else []
    where = " ".join(filter(None, parts))
    tip = "\n".join(filter(None, (component.id, component.path_uri, component.comment)))
    return s.Box(component.instance_name, where, tuple(ports), tip)


def _host(component: rts.ComponentInstance) -> str:
    path = component.path_uri
    return "" if "://" in path or "/" not in path else path.partition("/")[0]


def _key(end: rts.TargetPort, kind: str) -> tuple[str, str, str, str]:
    name = strip_instance(end.port_name, end.instance_name)
    return (end.component_id, end.instance_name, kind, name)


def _wire(
    connector: rts.DataPortConnector | rts.ServicePortConnector, kind: str, ends: _Ports
) -> s.Wire | None:
    source, target = ends.get(_key(connector.source, kind)), ends.get(_key(connector.target, kind))
    if source is None or target is None:
        return None
    tip = [f"{connector.source.instance_name} -> {connector.target.instance_name}", connector.name]
    if isinstance(connector, rts.DataPortConnector):
        how = (connector.dataflow_type, connector.subscription_type or "")
        tip += [short_type(normal_data_type(connector.data_type)), " ".join(filter(None, how))]
    wire_kind = s.SERVICE if kind == _SERVICE else s.DATA
    return s.Wire(source, target, wire_kind, "\n".join(filter(None, tip)))
