"""Creates a system profile from component profiles and pairs of ports to connect."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from rtkit.drawing.layout import laid_out
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.fast_dataclass import replace
from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.ports import declared_interfaces
from rtkit.profile.rtc_model import DataPortDeclaration, RtcProfile, ServicePortDeclaration
from rtkit.profile.words import normal_data_type
from rtkit.profile_tools.component_scene import component_name
from rtkit.profile_tools.system_scene import system_scene
from rtkit.rtc.create import CreateString
from rtkit.rtc.naming_properties import CREATE
from rtkit.rtc.nearest import did_you_mean
from rtkit.rtc.port_types import are_reversed, declared_port_type, interfaces_fit, types_fit

_CONTEXT_KINDS = {"PERIODIC": "PERIODIC", "SPORADIC": "EVENT_DRIVEN", "EVENTDRIVEN": "EVENT_DRIVEN"}
_DEFAULT = "default"


class NewMember(NamedTuple):
    """A component of a new system: its type, its name, and the slave that holds it, if any does."""

    type: RtcProfile
    instance: str
    slave: str = ""


class _End(NamedTuple):
    """A port that is to be connected."""

    member: NewMember
    port: DataPortDeclaration | ServicePortDeclaration

    @property
    def text(self) -> str:
        """The port as users write it."""
        return f"{self.member.instance}.{self.port.name}"


def new_system(
    name: str,
    date: str,
    members: Sequence[NewMember] = (),
    connections: Iterable[str] = (),
    *,
    vendor: str = "Me",
    version: str = "1.0.0",
    abstract: str = "",
    host: str = "localhost",
) -> rts.RtsProfile:
    """Return a profile in the strict form; connections are ``INSTANCE.PORT=INSTANCE.PORT``.

    Raises:
        Malformed: A name is used twice, or a connection is none.
        NotFound: A connection names what is not there.
        Refused: Two ports cannot be connected.
    """
    _check_names(name, vendor, version, members)
    by_name = {member.instance: member for member in members}
    data: list[rts.DataPortConnector] = []
    services: list[rts.ServicePortConnector] = []
    for number, text in enumerate(connections, 1):
        made = _connector(text, str(number), by_name)
        if isinstance(made, rts.DataPortConnector):
            data.append(made)
        else:
            services.append(made)
    profile = rts.RtsProfile(
        f"RTSystem:{vendor}:{name}:{version}",
        rts.RTS_VERSION,
        date,
        date,
        abstract=abstract or None,
        components=tuple(new_component(member, host) for member in members),
        data_port_connectors=tuple(data),
        service_port_connectors=tuple(services),
    )
    return _located(profile)


def _check_names(name: str, vendor: str, version: str, members: Sequence[NewMember]) -> None:
    if not name.strip() or "/" in name:
        raise Malformed(f"{name!r} cannot be the name of a system")
    for what, text in (("name", name), ("vendor", vendor), ("version", version)):
        if ":" in text:
            raise Malformed(f"a {what} with a colon would break the id: {text}")
    listed = [member.instance for member in members]
    for instance in listed:
        if listed.count(instance) > 1:
            raise Malformed(f"component {instance} is named twice")


def default_instance(type_name: str, taken: Iterable[str]) -> str:
    """Return the first free name for an instance: ``Motor0``, then ``Motor1``."""
    known = set(taken)
    number = 0
    while f"{type_name}{number}" in known:
        number += 1
    return f"{type_name}{number}"


def in_slaves(members: Sequence[NewMember], places: Iterable[str]) -> list[NewMember]:
    """Return members with their slaves, which are given as ``INSTANCE=SLAVE``.

    Raises:
        Malformed: A place is none.
        NotFound: It names a component that is not there.
    """
    known, found = [member.instance for member in members], {}
    for text in places:
        instance, _, slave = text.partition("=")
        if not (instance and slave):
            raise Malformed(f"a component in a slave is INSTANCE=SLAVE: {text}")
        if instance not in known:
            raise NotFound(f"no such component: {instance}{did_you_mean(instance, known)}")
        found[instance] = slave
    return [member._replace(slave=found.get(member.instance, "")) for member in members]


def new_component(member: NewMember, host: str) -> rts.ComponentInstance:
    """Return a component as its type declares it, with the default values of its parameters."""
    info = member.type.basic_info
    kind = _CONTEXT_KINDS[info.activity_type] if info else "PERIODIC"
    rate = (info.execution_rate or None) if info and kind == "PERIODIC" else None
    items = member.type.configuration_set.configurations if member.type.configuration_set else ()
    values = tuple(rts.ConfigurationData(item.name, item.default_value) for item in items)
    return rts.ComponentInstance(
        member.type.id,
        f"{host}/{member.instance}.rtc",
        member.instance,
        active_configuration_set=_DEFAULT if values else None,
        visible=True,
        data_ports=tuple(_data_port(member, port) for port in member.type.data_ports),
        service_ports=tuple(
            stated_port(member.instance, port.name, "CorbaPort")
            for port in member.type.service_ports
        ),
        configuration_sets=(rts.ConfigurationSet(_DEFAULT, values),) if values else (),
        execution_contexts=(rts.OwnedContext("0", kind, rate),),
        properties=_held_by(member),
    )


def _held_by(member: NewMember) -> tuple[ExtensionProperty, ...]:
    if not member.slave:
        return ()
    create = CreateString(component_name(member.type), options={"manager_name": member.slave})
    return (ExtensionProperty(CREATE, str(create)),)


def _data_port(member: NewMember, port: DataPortDeclaration) -> rts.InstancePort:
    return stated_port(member.instance, port.name, declared_port_type(port.port_type), port.type)


def stated_port(instance: str, name: str, kind: str, data_type: str = "") -> rts.InstancePort:
    """Return a port as the profile of a system lists it, with its kind and its data type."""
    stated = (
        [ExtensionProperty("dataport.data_type", normal_data_type(data_type))] if data_type else []
    )
    properties = (*stated, ExtensionProperty("port.port_type", kind))
    return rts.InstancePort(f"{instance}.{name}", True, properties=properties)


def _connector(
    text: str, number: str, members: Mapping[str, NewMember]
) -> rts.DataPortConnector | rts.ServicePortConnector:
    one, equals, other = text.partition("=")
    if not (one and equals and other) or "=" in other:
        raise Malformed(f"a connection is INSTANCE.PORT=INSTANCE.PORT: {text}")
    source, target = _end(one, members), _end(other, members)
    name = f"{source.port.name}_{target.port.name}"
    mine, its = source.port, target.port
    if isinstance(mine, DataPortDeclaration) and isinstance(its, DataPortDeclaration):
        types = [declared_port_type(port.port_type) for port in (mine, its)]
        if not types_fit(types):
            both = f"{mine.port_type} and {its.port_type}"
            raise Refused(f"{source.text} and {target.text} cannot be connected: {both}")
        if are_reversed(types):
            source, target = target, source
        data_type = _common_type(source, target)
        ends = (_target(source), _target(target))
        return rts.DataPortConnector(number, name, data_type, "corba_cdr", "push", *ends, "new")
    _check_services(source, target)
    return rts.ServicePortConnector(number, name, _target(source), _target(target))


def _end(text: str, members: Mapping[str, NewMember]) -> _End:
    instance, dot, port_name = text.partition(".")
    member = members.get(instance)
    if not dot or member is None:
        known = ", ".join(members) or "none"
        raise NotFound(f"no such component: {text}; there are: {known}")
    ports: list[DataPortDeclaration | ServicePortDeclaration] = [
        *member.type.data_ports,
        *member.type.service_ports,
    ]
    for port in ports:
        if port.name == port_name:
            return _End(member, port)
    known = ", ".join(port.name for port in ports) or "none"
    raise NotFound(f"no such port: {text}; {instance} has: {known}")


def _common_type(source: _End, target: _End) -> str:
    types = [
        normal_data_type(end.port.type)
        for end in (source, target)
        if isinstance(end.port, DataPortDeclaration)
    ]
    closed = [each for each in types if each.lower() not in ("", "any")]
    if len(set(closed)) > 1:
        listed = " and ".join(types)
        raise Refused(f"{source.text} and {target.text} cannot be connected: {listed}")
    return closed[0] if closed else types[0]


def _check_services(source: _End, target: _End) -> None:
    if not (
        isinstance(source.port, ServicePortDeclaration)
        and isinstance(target.port, ServicePortDeclaration)
    ):
        raise Refused(f"{source.text} and {target.text}: one is a data port, one a service port")
    one, other = declared_interfaces(source.port), declared_interfaces(target.port)
    if not (one and other and interfaces_fit(one, other)):
        raise Refused(f"{source.text} and {target.text}: neither provides what the other requires")


def _target(end: _End) -> rts.TargetPort:
    return target_port(end.member.type.id, end.member.instance, end.port.name)


def target_port(component_id: str, instance: str, port: str) -> rts.TargetPort:
    """Return the end of a connector at a port."""
    return rts.TargetPort(component_id, instance, f"{instance}.{port}")


def _located(profile: rts.RtsProfile) -> rts.RtsProfile:
    """Say where an editor is to draw the components."""
    places = laid_out(system_scene(profile)).places
    components = tuple(
        replace(component, location=rts.Location(40 + x, 40 + y, -1, -1, "RIGHT"))
        for component, (x, y) in zip(profile.components, places, strict=True)
    )
    return replace(profile, components=components)
