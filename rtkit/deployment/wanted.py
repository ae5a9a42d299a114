"""Converts a system profile into the facts of the wanted system.

`rtkit.deployment.deviations` compares them with what lives.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from rtkit.deployment import extension
from rtkit.deployment.described import (
    DATA_ATTRIBUTES,
    contexts_of,
    data_port,
    guests_of,
    kind_of,
    lasting,
    properties_of,
    rates_of,
    script_of,
    service_port,
    sets_of,
    stated_interfaces,
    type_of,
)
from rtkit.deployment.owned import read_movable
from rtkit.deployment.place import Hosts, check_map, place
from rtkit.deployment.port_types import settle_types
from rtkit.deployment.shown_ports import OwnEnds
from rtkit.deployment.system import (
    BadComponent,
    KnownType,
    WantedComponent,
    WantedConnector,
    WantedSystem,
)
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass, field, replace
from rtkit.profile.rts_model import (
    ComponentInstance,
    DataPortConnector,
    RtsProfile,
    ServicePortConnector,
    TargetPort,
)
from rtkit.profile.words import strip_instance
from rtkit.rtc.connector_properties import PUSH_INTERVAL, finite
from rtkit.rtc.context_settings import check_settings, is_setting
from rtkit.rtc.create import CreateString, listed_names, parse_create, readable_create
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.port_types import are_reversed
from rtkit.rtc.profiles import ConnectorProfile, PortInterfaceProfile, PortProfile, PortRef

STAND_IN_SLAVE = "stand-ins"
"""The slave that holds stand-ins of which no profile says where they belong."""


@dataclass(slots=True)
class _Wiring:
    """Statements of a profile's connectors about the ports that they join."""

    kinds: dict[PortRef, PortType] = field(default_factory=dict)
    types: dict[PortRef, str] = field(default_factory=dict)
    interfaces: dict[PortRef, tuple[PortInterfaceProfile, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Choices:
    stand_in: bool
    transmit: bool
    hosts: Hosts
    known_types: Mapping[str, KnownType]
    stand_ins: Collection[str]
    restarts: Mapping[str, str]
    slaves: Mapping[str, str]


def wanted(
    profile: RtsProfile,
    hostname: str,
    *,
    stand_in: bool = False,
    transmit: bool = False,
    host_map: Mapping[str, str] | None = None,
    known_types: Mapping[str, KnownType] | None = None,
    stand_ins: Collection[str] = (),
    managers: Collection[str] = (),
) -> WantedSystem:
    """Return the system that a profile describes, as it is to be on the host `hostname`.

    Args:
        profile: The system profile.
        hostname: The machine that ``localhost`` means.
        stand_in: Generate every component from the profile instead of making the real one.
        transmit: Stand-ins write default values, and answer calls with them.
        host_map: Hosts that stand for another one.
        known_types: How components are made, by identity.
        stand_ins: Instances that are stand-ins, also after their process died.
        managers: Managers of this host beside the first one.

    Raises:
        BadComponent: Two components of one name, or a property of rtkit that cannot be read.
        Malformed: A host is mapped to one that nobody knows, or restarts of a slave make no sense.
    """
    hosts = Hosts(hostname, host_map or {}, stand_in, managers)
    check_map(hosts)
    restarts = _restarts_of_slaves(profile)
    slaves = _shared_slaves(profile)
    choices = _Choices(stand_in, transmit, hosts, known_types or {}, stand_ins, restarts, slaves)
    _check_instances(profile.components)
    components, notes = _components(profile, choices)
    own = OwnEnds(components)
    stated = [
        *map(_data, profile.data_port_connectors),
        *map(_service, profile.service_port_connectors),
    ]
    connectors = [
        _turned(own.connector(connector), components, is_data) for connector, is_data in stated
    ]
    settled, type_notes = settle_types(components, connectors)
    return WantedSystem(tuple(settled.values()), tuple(connectors), (*notes, *type_notes))


def _components(
    profile: RtsProfile, choices: _Choices
) -> tuple[dict[str, WantedComponent], list[str]]:
    wiring = _wiring(profile)
    notes: list[str] = []
    components: dict[str, WantedComponent] = {}
    for position, each in enumerate(profile.components):
        taken = {c.name for c in components.values()}
        try:
            made, note = _component(each, wiring, choices, taken)
        except Malformed as error:
            raise BadComponent(position, str(error)) from error
        components[made.instance] = made
        notes += [note] if note else []
    return components, notes


def _check_instances(components: Iterable[ComponentInstance]) -> None:
    seen: set[str] = set()
    for position, component in enumerate(components):
        if component.instance_name in seen:
            raise BadComponent(
                position,
                f"two components are named {component.instance_name};"
                " instance names must differ within one manager",
            )
        seen.add(component.instance_name)


def _wiring(profile: RtsProfile) -> _Wiring:
    wiring = _Wiring()
    for data in profile.data_port_connectors:
        options = properties_of(data.properties)
        type_name = options.get("dataport.data_type") or data.data_type or ""
        for end, kind in ((data.source, PortType.OUT), (data.target, PortType.IN)):
            ref = _ref(end)
            wiring.kinds.setdefault(ref, kind)
            if type_name:
                wiring.types.setdefault(ref, type_name)
    for service in profile.service_port_connectors:
        _add_interfaces(service, wiring)
    return wiring


def _add_interfaces(service: ServicePortConnector, wiring: _Wiring) -> None:
    ends = [_ref(service.source), _ref(service.target)]
    for instance, port, interface in stated_interfaces(properties_of(service.properties)):
        end = PortRef(instance, port)
        if end not in ends:
            continue
        other = ends[1 - ends.index(end)]
        wanted_other = Polarity.REQUIRED
        if interface.polarity is Polarity.REQUIRED:
            wanted_other = Polarity.PROVIDED
        mirrored = replace(interface, polarity=wanted_other)
        for ref, each in ((end, interface), (other, mirrored)):
            known = wiring.interfaces.get(ref, ())
            if all(
                (k.type_name, k.instance_name) != (each.type_name, each.instance_name)
                for k in known
            ):
                wiring.interfaces[ref] = (*known, each)


def _component(
    component: ComponentInstance, wiring: _Wiring, choices: _Choices, taken: set[str]
) -> tuple[WantedComponent, str]:
    own = properties_of(component.properties)
    is_marked = own.get(extension.STAND_IN, "").lower() in ("yes", "true", "1")
    is_stand_in = choices.stand_in or is_marked or component.instance_name in choices.stand_ins
    hosts = replace(choices.hosts, any_is_local=is_stand_in)
    where = place(component, hosts, taken)
    made = WantedComponent(
        id=component.id,
        instance=component.instance_name,
        name=where.name,
        path=where.path,
        is_required=component.is_required,
        ports=_ports(component, wiring),
        sets=sets_of(component.configuration_sets),
        active_set=component.active_configuration_set or "",
        contexts=contexts_of(component.execution_contexts),
        unknown_host=where.unknown_host,
        guests=guests_of(component),
        hot=listed_names(own.get(extension.HOT, "")),
        costs=_costs(component.instance_name, own.get(extension.COST, "")),
        manager=where.manager,
        rates=rates_of(component.execution_contexts),
        is_create_stated=extension.CREATE in own,
        may_move=extension.MOVABLE in own,
    )
    if made.may_move:
        read_movable(made.instance, own[extension.MOVABLE])
    known = choices.known_types.get(component.id)
    create = own.get(extension.CREATE, "") or (known.create if known is not None else "")
    policy = {k: v for k, v in own.items() if extension.is_policy(k)}
    settings = _context_settings(made.instance, own)
    if policy:
        _check_policy(policy)
    if is_stand_in:
        stand_in = _as_stand_in(made, component, create, choices, is_marked)
        made_by = _in_shared_slave(parse_create(stand_in.create), choices)
        text = _limited(made_by.with_options(**_policy(policy, made_by, choices)))
        return _supervised(replace(stand_in, create=text), policy), where.note
    module = own.get(extension.MODULE, "") or (known.module if known is not None else "")
    text = ""
    if create:
        made_by = _in_shared_slave(_create(create, made), choices)
        options = {**settings, **_policy(policy, made_by, choices)}
        text = _limited(made_by.with_options(**options))
    return _supervised(replace(made, create=text, module=module), policy), where.note


def _context_settings(instance: str, own: Mapping[str, str]) -> dict[str, str]:
    """Return the settings of contexts that a profile states beside the create string."""
    settings = {key: text for key, text in own.items() if is_setting(key)}
    try:
        check_settings(settings)
    except Malformed as error:
        raise Malformed(f"{instance}: {error}") from None
    return settings


def _in_shared_slave(create: CreateString, choices: _Choices) -> CreateString:
    slave = choices.slaves.get(create.instance_name)
    return create.with_options(manager_name=slave) if slave else create


def _limited(create: CreateString) -> str:
    """Return a create string as text.

    Raises:
        Malformed: It has limits, but its component would not be in a slave.
    """
    text = str(create)
    if extension.LIMIT in text and not (create.place or create.is_place_open):
        from rtkit.deployment.limits import needs_slave, read_limits

        if read_limits(create.options):
            raise Malformed(needs_slave(create.instance_name))
    return text


def _supervised(made: WantedComponent, own: Mapping[str, str]) -> WantedComponent:
    """Return a component with its policy, if the profile states one, or all of how it is made."""
    stated = {**own, **extension.policy_in(made.create)}
    policy = {key: value for key, value in stated.items() if value}
    return replace(made, policy=policy) if policy or made.is_create_stated else made


def _policy(own: Mapping[str, str], create: CreateString, choices: _Choices) -> Mapping[str, str]:
    """Return the policy of a component: its own, else what is stated of its slave."""
    of_slave = choices.restarts.get(create.place, "")
    if not of_slave or extension.RESTART in {**create.options, **own}:
        return own
    return {extension.RESTART: of_slave, **own}


def _restarts_of_slaves(profile: RtsProfile) -> dict[str, str]:
    """Return which restarts are stated for slaves, by name.

    Raises:
        Malformed: One makes no sense.
    """
    prefix = extension.SLAVE_RESTART
    restarts = {k: v for k, v in properties_of(profile.properties).items() if k.startswith(prefix)}
    if restarts:
        from rtkit.deployment.supervision import restart_of

        for key, word in restarts.items():
            restart_of(key, word)
    return {key.removeprefix(prefix): word for key, word in restarts.items()}


def _shared_slaves(profile: RtsProfile) -> dict[str, str]:
    """Return the slaves that components belong in as they share the process of others.

    Raises:
        BadComponent: Requirements of one make no sense.
    """
    stated = [properties_of(each.properties) for each in profile.components]
    if not any(extension.PLACE_WITH in own or extension.PLACE_APART in own for own in stated):
        return {}
    from rtkit.deployment.placement.profiles import requirements_of
    from rtkit.deployment.placement.requirements import shared_slaves

    required = requirements_of(profile)
    creates = (readable_create(own.get(extension.CREATE, "")).place for own in stated)
    names = (each.instance_name for each in profile.components)
    return dict(shared_slaves(required, dict(zip(names, creates, strict=True))))


def _check_policy(options: Mapping[str, str]) -> None:
    from rtkit.deployment.health import read_rules
    from rtkit.deployment.limits import read_limits
    from rtkit.deployment.placement.requirements import read_requirements
    from rtkit.deployment.supervision import read_policy

    read_policy(options)
    read_rules(options)
    read_limits(options)
    read_requirements(options)


def _costs(instance: str, text: str) -> dict[str, float]:
    """Return what kinds of steps cost by ``NUMBER``, any interruption, or ``KIND=NUMBER,…``."""
    costs: dict[str, float] = {}
    if not text:
        return costs
    from rtkit.deployment.planning.default_costs import DEFAULT_COSTS, INTERRUPTIONS, is_cost

    for item in listed_names(text):
        kind, equals, number = item.rpartition("=")
        kinds = (kind.strip(),) if equals else INTERRUPTIONS
        cost = finite(number) or 0.0
        if not is_cost(cost):
            raise Malformed(f"{instance}: {extension.COST}: not a number above 0: {item}")
        if not set(kinds) <= DEFAULT_COSTS.keys():
            known = ", ".join(DEFAULT_COSTS)
            raise Malformed(
                f"{instance}: {extension.COST}: no such kind of step: {kind}; there are {known}"
            )
        costs.update(dict.fromkeys(kinds, cost))
    return costs


def _create(text: str, made: WantedComponent) -> CreateString:
    try:
        create = parse_create(text)
    except Malformed as error:
        raise Malformed(f"{made.instance}: {extension.CREATE}: {error}") from error
    return create.with_options(instance_name=made.instance)


def _as_stand_in(
    made: WantedComponent,
    component: ComponentInstance,
    create: str,
    choices: _Choices,
    is_marked: bool,
) -> WantedComponent:
    given = _create(create, made).options if create else {}
    options = {
        **({k: v for k, v in given.items() if not k.startswith("rtkit.")} if is_marked else {}),
        "instance_name": made.instance,
        "manager_name": given.get("manager_name", "") if create else STAND_IN_SLAVE,
        **_stated(component, made),
    }
    scripted = f"{extension.STAND_IN}."
    properties = properties_of(component.properties).items()
    options.update((name, value) for name, value in properties if name.startswith(scripted))
    if choices.transmit:
        options[extension.TRANSMIT] = "default"
    identity = type_of(made.id)
    pattern = ComponentPattern(
        identity,
        made.ports,
        _pattern_sets(made),
        made.active_set or "default",
        made.contexts,
        script_of(component),
    )
    return replace(
        made,
        create=str(CreateString("StandIn").with_options(**options)),
        module="",
        pattern=pattern,
    )


def _pattern_sets(made: WantedComponent) -> dict[str, dict[str, str]]:
    sets = {name: dict(values) for name, values in made.sets.items()}
    sets.setdefault(made.active_set or "default", {})
    return sets


def _stated(component: ComponentInstance, made: WantedComponent) -> dict[str, str]:
    """Return what the profile states in words that no live component keeps."""
    stated = {}
    if type_of(component.id).id != component.id:
        stated[extension.STATED_ID] = component.id
    for context, live in zip(component.execution_contexts, made.contexts, strict=True):
        if context.kind and context.kind != kind_of(context.kind).value:
            stated[f"{extension.STATED_KIND}{live.id}"] = context.kind
    open_points = [] if made.active_set else ["active-set"]
    open_points += [f"set:{name}" for name in _pattern_sets(made) if name not in made.sets]
    if open_points:
        stated[extension.UNSTATED] = ",".join(open_points)
    return stated


def _ports(component: ComponentInstance, wiring: _Wiring) -> tuple[PortProfile, ...]:
    instance = component.instance_name
    ports: dict[str, PortProfile] = {}
    for port in component.data_ports:
        ref = PortRef(instance, strip_instance(port.name, instance))
        made = data_port(port, instance, wiring.kinds.get(ref), wiring.types.get(ref, ""))
        ports.setdefault(made.name, made)
    for port in component.service_ports:
        ref = PortRef(instance, strip_instance(port.name, instance))
        made = service_port(port, instance, wiring.interfaces.get(ref, ()))
        ports.setdefault(made.name, made)
    return tuple(ports.values())


def _ref(end: TargetPort) -> PortRef:
    return PortRef(end.instance_name, strip_instance(end.port_name, end.instance_name))


def _data(connector: DataPortConnector) -> tuple[ConnectorProfile, bool]:
    values = (
        connector.data_type,
        connector.interface_type,
        connector.dataflow_type,
        connector.subscription_type,
    )
    stated = {key: value for key, value in zip(DATA_ATTRIBUTES, values, strict=True) if value}
    if connector.push_interval:
        stated[PUSH_INTERVAL] = repr(connector.push_interval).removesuffix(".0")
    return _connector(connector, stated), True


def _service(connector: ServicePortConnector) -> tuple[ConnectorProfile, bool]:
    return _connector(connector, {"port.port_type": PortType.SERVICE.value}), False


def _connector(
    connector: DataPortConnector | ServicePortConnector, stated: Mapping[str, str]
) -> ConnectorProfile:
    ends = (_ref(connector.source), _ref(connector.target))
    merged = {**stated, **lasting(properties_of(connector.properties))}
    return ConnectorProfile(connector.connector_id, connector.name, ends, merged)


def _turned(
    connector: ConnectorProfile, components: Mapping[str, WantedComponent], is_data: bool
) -> WantedConnector:
    """Put the out port first, whatever the profile does."""
    kinds = []
    for end in connector.ports:
        port = components[end.instance].port(end.port)
        kinds.append(port.port_type if port is not None else None)
    if is_data and are_reversed(kinds):
        connector = replace(connector, ports=connector.ports[::-1])
    is_required = all(components[end.instance].is_required for end in connector.ports)
    return WantedConnector(connector, is_data, is_required)
