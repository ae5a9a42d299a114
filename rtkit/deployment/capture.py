"""Captures a live system as a system profile, with all that its recovery needs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rtkit.deployment import extension
from rtkit.deployment.described import DATA_ATTRIBUTES, interfaces_to_text, lasting
from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.fast_dataclass import dataclass, replace
from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty
from rtkit.rtc.connector_properties import DEFAULT_INTERFACE, PUSH_INTERVAL, USUAL_NAMES, finite
from rtkit.rtc.create import FRESH_SLAVE, CreateString, parse_create
from rtkit.rtc.enums import PortType
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, MANAGER_SUFFIX, split_manager
from rtkit.rtc.profiles import DEFINITION, ConnectorProfile, PortProfile, PortRef


@dataclass(frozen=True, slots=True)
class SystemHeading:
    """Identity of a saved system; `date` is ``xs:dateTime`` text."""

    date: str
    name: str = "RTSystem"
    version: str = "0"
    vendor: str = "Me"
    abstract: str = "RT System created by rtcryo."

    @property
    def id(self) -> str:
        """Identity of the system."""
        return f"RTSystem:{self.vendor}:{self.name}:{self.version}"


def capture(
    snapshot: Snapshot,
    heading: SystemHeading,
    *,
    takes_all: bool = False,
    hosts: Iterable[str] = (),
) -> rts.RtsProfile:
    """Return the profile of what lives: components that are connected, or all of them.

    The members of a connected composite count as connected too, and so does the composite of a
    member; likewise the components that its execution contexts drive, and the one that drives it.

    With `hosts` only components registered below one of these. Zombies are left out, and so are
    components of attached processes that state no create string: what a data tool shows for a while
    is no part of the system. One run by hand is saved as what a slave of its own makes.
    """
    own = _own(snapshot)
    chosen = _chosen(snapshot, own, takes_all, tuple(hosts))
    names = {c.instance: c for c in chosen}
    connectors = [w for w in snapshot.connectors if all(end.instance in names for end in w.ports)]
    connectors.sort(key=lambda connector: (connector.ports, connector.connector_id))
    data = [connector for connector in connectors if _is_data(connector, names)]
    service = [connector for connector in connectors if not _is_data(connector, names)]
    return rts.RtsProfile(
        id=heading.id,
        version=rts.RTS_VERSION,
        creation_date=heading.date,
        update_date=heading.date,
        abstract=heading.abstract,
        components=tuple(_component(c, own[c.instance]) for c in chosen),
        data_port_connectors=tuple(_data_connector(connector, names) for connector in data),
        service_port_connectors=tuple(
            _service_connector(connector, names) for connector in service
        ),
    )


def _own(snapshot: Snapshot) -> dict[str, Snapshot]:
    """Return what the manager of each component knows, by its name."""
    own = dict.fromkeys((c.instance for c in snapshot.components), snapshot)
    for each in snapshot.others:
        own.update((c.instance, each) for c in each.components)
    return own


def _chosen(
    snapshot: Snapshot, own: Mapping[str, Snapshot], takes_all: bool, hosts: tuple[str, ...]
) -> tuple[ComponentFacts, ...]:
    wired = {end.instance for connector in snapshot.connectors for end in connector.ports}
    wired = _with_composites(snapshot, wired)
    guests = {
        (each.manager, name) for each in (snapshot, *snapshot.others) for name in _guests(each)
    }
    chosen = [
        c
        for c in snapshot.components
        if not (c.zombie or ((own[c.instance].manager, c.process) in guests and not c.create))
        and (takes_all or c.instance in wired)
        and (not hosts or any(n.partition("/")[0] in hosts for n in _names(c, own[c.instance])))
    ]
    return tuple(sorted(chosen, key=lambda component: component.instance))


def _guests(snapshot: Snapshot) -> set[str]:
    return {process.name for process in snapshot.processes if process.is_guest}


def _with_composites(snapshot: Snapshot, wired: set[str]) -> set[str]:
    """Return these components with all that they make up, are part of, drive, or are driven by."""
    found = set(wired)
    kin = {c.instance: {*c.members, c.composite} for c in snapshot.components}
    for facts in snapshot.components:
        for context in facts.contexts:
            kin[facts.instance].update((context.owner, *context.participants))
    ready = list(found)
    while ready:
        new = kin.get(ready.pop(), set()) - found - {""}
        found |= new
        ready += new
    return found


def _names(component: ComponentFacts, snapshot: Snapshot) -> tuple[str, ...]:
    below = f"{LOCAL}/{snapshot.manager}{MANAGER_SUFFIX}/{component.instance}{COMPONENT_SUFFIX}"
    manager, host = split_manager(snapshot.manager)
    if host:
        below = f"{host}/{manager}{MANAGER_SUFFIX}/{component.instance}{COMPONENT_SUFFIX}"
    return component.names or (below,)


def _is_data(connector: ConnectorProfile, components: Mapping[str, ComponentFacts]) -> bool:
    port = components[connector.ports[0].instance].port(connector.ports[0].port)
    return port is None or port.port_type is not PortType.SERVICE


def _component(facts: ComponentFacts, snapshot: Snapshot) -> rts.ComponentInstance:
    options = extension.options_of(facts)
    unstated = options.get(extension.UNSTATED, "").split(",")
    data_ports = [port for port in facts.ports if port.port_type is not PortType.SERVICE]
    service_ports = [port for port in facts.ports if port.port_type is PortType.SERVICE]
    sets = {
        name: values
        for name, values in facts.sets.items()
        if values or f"set:{name}" not in unstated
    }
    is_open = "active-set" in unstated and facts.active_set == "default"
    return rts.ComponentInstance(
        id=extension.stated_id(facts),
        path_uri=_names(facts, snapshot)[0],
        instance_name=facts.instance,
        active_configuration_set=None if is_open else facts.active_set or None,
        composite_type=facts.composite_type or "None",
        visible=True,
        data_ports=tuple(_port(port, facts) for port in data_ports),
        service_ports=tuple(_port(port, facts) for port in service_ports),
        configuration_sets=tuple(
            rts.ConfigurationSet(
                name, tuple(rts.ConfigurationData(key, value) for key, value in values.items())
            )
            for name, values in sets.items()
        ),
        execution_contexts=_contexts(facts, options, snapshot),
        participants=tuple(_refs(facts.members, snapshot)),
        properties=_origin(facts, snapshot),
    )


def _refs(instances: Iterable[str], snapshot: Snapshot) -> Iterator[rts.ComponentRef]:
    """Yield these components as profiles refer to them."""
    for name in instances:
        facts = snapshot.component(name)
        if facts is not None:
            yield rts.ComponentRef(extension.stated_id(facts), name)


def _port(port: PortProfile, facts: ComponentFacts) -> rts.InstancePort:
    properties = {name: value for name, value in port.properties.items() if name != DEFINITION}
    stated = properties.pop(extension.STATED_TYPE, "")
    if stated:
        properties["dataport.data_type"] = stated
    if facts.is_stand_in and port.interfaces:
        properties[extension.INTERFACES] = interfaces_to_text(port.interfaces)
    return rts.InstancePort(
        f"{facts.instance}.{port.name}", True, properties=_properties(properties)
    )


def _contexts(
    facts: ComponentFacts, options: Mapping[str, str], snapshot: Snapshot
) -> tuple[rts.OwnedContext, ...]:
    own = [context for context in facts.contexts if context.owner in ("", facts.instance)]
    return tuple(
        rts.OwnedContext(
            context.id,
            options.get(f"{extension.STATED_KIND}{context.id}", "") or context.kind.value,
            context.rate,
            # Those of a composite are its members, which it states by itself.
            () if facts.composite_type else tuple(_refs(context.participants, snapshot)),
        )
        for context in own
    )


def _origin(facts: ComponentFacts, snapshot: Snapshot) -> tuple[ExtensionProperty, ...]:
    """Return the properties from which the component is created again."""
    properties = {}
    if facts.is_stand_in:
        properties[extension.STAND_IN] = "yes"
    create = _create(facts, snapshot)
    if create is not None:
        properties[extension.CREATE] = str(create)
    for key, value in extension.options_of(facts).items():
        if key.startswith(f"{extension.STAND_IN}.") or extension.is_policy(key):
            properties[key] = value
    module = "" if facts.is_stand_in else facts.module or _module(facts, snapshot)
    if module:
        properties[extension.MODULE] = module
    return tuple(ExtensionProperty(name, value) for name, value in properties.items())


def _create(facts: ComponentFacts, snapshot: Snapshot) -> CreateString | None:
    if not facts.create:
        return None
    made = parse_create(facts.create)
    own = {key: "" for key in made.options if key.startswith("rtkit.")}
    slaves = {process.name for process in snapshot.processes if process.is_slave}
    place = facts.process if facts.process in slaves else ""
    if facts.process in _guests(snapshot):
        place = FRESH_SLAVE
    if facts.composite_type:  # what it was made of may be another thing by now
        present = facts.sets.get(facts.active_set, {})
        own.update({key: present.get(key, "") for key in ("members", "exported_ports")})
    if "==" in (facts.module or _module(facts, snapshot)):  # one of several installed versions
        made = replace(parse_create(facts.type.full_id), options=made.options)
    return made.with_options(**own, instance_name=facts.instance, manager_name=place)


def _module(facts: ComponentFacts, snapshot: Snapshot) -> str:
    for module in snapshot.modules:
        if any(kind.id == facts.type.id for kind in module.types):
            return f"{module.path}:{module.init}" if module.init else module.path
    return ""


def _data_connector(
    connector: ConnectorProfile, components: Mapping[str, ComponentFacts]
) -> rts.DataPortConnector:
    properties = lasting(connector.properties)
    interval = finite(properties.get(PUSH_INTERVAL, ""))
    if interval:
        del properties[PUSH_INTERVAL]  # what is no interval stays the property that it is
    data_type, interface, flow, subscription = (properties.get(k, "") for k in DATA_ATTRIBUTES)
    source, target = (_target(end, components) for end in connector.ports)
    return rts.DataPortConnector(
        connector_id=connector.connector_id,
        name=connector.name,
        data_type=data_type,
        interface_type=USUAL_NAMES.get(interface, interface) or USUAL_NAMES[DEFAULT_INTERFACE],
        dataflow_type=flow or "push",
        subscription_type=subscription or None,
        push_interval=interval or None,
        source=source,
        target=target,
        visible=True,
        properties=_properties(properties),
    )


def _service_connector(
    connector: ConnectorProfile, components: Mapping[str, ComponentFacts]
) -> rts.ServicePortConnector:
    source, target = (_target(end, components) for end in connector.ports)
    return rts.ServicePortConnector(
        connector_id=connector.connector_id,
        name=connector.name,
        source=source,
        target=target,
        visible=True,
        properties=_properties(lasting(connector.properties)),
    )


def _target(end: PortRef, components: Mapping[str, ComponentFacts]) -> rts.TargetPort:
    facts = components[end.instance]
    path = facts.names[0] if facts.names else ""
    known = (ExtensionProperty("COMPONENT_PATH_ID", path),) if path else ()
    return rts.TargetPort(
        extension.stated_id(facts), end.instance, f"{end.instance}.{end.port}", known
    )


def _properties(properties: Mapping[str, str]) -> tuple[ExtensionProperty, ...]:
    return tuple(ExtensionProperty(name, value) for name, value in sorted(properties.items()))
