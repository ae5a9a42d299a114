"""Multi-manager view: joins the facts of several managers as one and splits actions by manager.

A name of another manager than the first appears below it: ``localhost/m1.mgr/Motor0.rtc`` is what
manager ``m1`` itself calls ``localhost/Motor0.rtc``; ``robot1/Motor0.rtc`` is what the manager of
host ``robot1`` calls so.

See decisions 33, 71 and 76.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.deployment.facts import Snapshot
from rtkit.fast_dataclass import dataclass, field, fields, replace
from rtkit.rtc.create import parse_create
from rtkit.rtc.far_ends import far_name, named_by, on_host, own_end, peer_of, split_far
from rtkit.rtc.names import LOCAL, MANAGER_SUFFIX, manager_on, split_manager
from rtkit.rtc.profiles import ConnectorProfile, PortRef

Homes = Mapping[str, str]
"""Managers of components, by instance name."""
NOWHERE: Homes = {}


@dataclass(frozen=True, slots=True)
class JointSnapshot(Snapshot):
    """Joint facts of several managers at about one moment; never sent.

    Attributes:
        others: Those beside the first: their components and connectors are listed here too, their
            processes and modules only there.
        unreachable: Why some of them cannot be asked though they may live, by their names.
    """

    others: tuple[Snapshot, ...] = ()
    unreachable: Mapping[str, str] = field(default_factory=dict)


def joined(snapshots: Sequence[Snapshot], homes: Homes, unreachable: Homes = NOWHERE) -> Snapshot:
    """Return what several managers know as one; it is otherwise that of the first.

    Of two components, or connectors, of one name the one at home is listed, else the first.
    """
    first, *others = snapshots
    if not others:
        return first
    bearers: dict[str, str] = {}
    connectors: dict[str, str] = {}
    for each in snapshots:
        for facts in each.components:
            is_home = homes.get(facts.instance) == each.manager
            if is_home or facts.instance not in bearers:
                bearers[facts.instance] = each.manager
    snapshots, crossing = _with_halves_joined(snapshots)
    first = snapshots[0]
    for each in snapshots:
        for connector in _whole(each, bearers, crossing):
            is_home = all(homes.get(end.instance) == each.manager for end in connector.ports)
            if is_home or connector.connector_id not in connectors:
                connectors[connector.connector_id] = each.manager
    parts = [_part(each, bearers, connectors, crossing) for each in snapshots]
    shown = [parts[0], *map(_shown_below, parts[1:])]
    values = {each.name: getattr(first, each.name) for each in fields(first)}
    values["components"] = tuple(facts for each in shown for facts in each.components)
    values["connectors"] = tuple(connector for each in shown for connector in each.connectors)
    values["systems"] = tuple(system for each in snapshots for system in each.systems)
    return JointSnapshot(**values, others=tuple(shown[1:]), unreachable=unreachable)


def _with_halves_joined(snapshots: Sequence[Snapshot]) -> tuple[list[Snapshot], Homes]:
    """Return snapshots in which two halves of one connector are one, where its out end lives.

    Besides, the managers of the other ends of these, by the ids of the connectors.

    A half whose other one is not there, or not joined, is none: a plan makes it whole.
    """
    halves: dict[str, dict[str, ConnectorProfile]] = {}
    for each in snapshots:
        for connector in each.connectors:
            if peer_of(connector) and not connector.trouble:
                between = named_by(connector, each.manager)
                halves.setdefault(connector.connector_id, {})[each.manager] = between
    found, crossing = list[Snapshot](), dict[str, str]()
    for each in snapshots:
        connectors = []
        for connector in each.connectors:
            peer = peer_of(connector)
            known = halves.get(connector.connector_id, {})
            if not peer:
                connectors.append(connector)
            elif own_end(connector)[0] == 0 and known.get(each.manager) == known.get(peer, ""):
                connectors.append(_plain(connector))
                crossing[connector.connector_id] = peer
        found.append(replace(each, connectors=tuple(connectors)))
    return found, crossing


def _plain(connector: ConnectorProfile) -> ConnectorProfile:
    ends = (PortRef(split_far(end.instance)[1], end.port) for end in connector.ports)
    return replace(connector, ports=tuple(ends))


def _part(each: Snapshot, bearers: Homes, connectors: Homes, crossing: Homes) -> Snapshot:
    """Return what counts of one manager's facts."""
    return replace(
        each,
        components=tuple(c for c in each.components if bearers[c.instance] == each.manager),
        connectors=tuple(
            connector
            for connector in _whole(each, bearers, crossing)
            if connectors[connector.connector_id] == each.manager
        ),
    )


def _whole(each: Snapshot, bearers: Homes, crossing: Homes) -> Iterator[ConnectorProfile]:
    """Yield the connectors of which both ends count."""
    for connector in each.connectors:
        managers = (each.manager, crossing.get(connector.connector_id, each.manager))
        if tuple(bearers.get(end.instance) for end in connector.ports) == managers:
            yield connector


def _shown_below(each: Snapshot) -> Snapshot:
    """Return facts of another manager with the names by which its components are shown here."""
    return replace(
        each,
        components=tuple(
            replace(facts, names=tuple(outward(name, each.manager) for name in facts.names))
            for facts in each.components
        ),
    )


def outward(name: str, manager: str) -> str:
    """Return how a name that another manager has is shown below that manager."""
    below = _below(manager)
    if name.startswith(below) or not name.startswith(f"{LOCAL}/"):
        return name
    return below + name.removeprefix(f"{LOCAL}/")


def inward(name: str, manager: str) -> str:
    """Return the name that a manager itself has for what is shown below it."""
    below = _below(manager)
    return f"{LOCAL}/{name.removeprefix(below)}" if name.startswith(below) else name


def _below(manager: str) -> str:
    own, host = split_manager(manager)
    return f"{host}/" if host else f"{LOCAL}/{own}{MANAGER_SUFFIX}/"


def homes_in(snapshot: Snapshot) -> dict[str, str]:
    """Return which manager each component lives in."""
    homes = {facts.instance: snapshot.manager for facts in snapshot.components}
    for each in snapshot.others:
        homes.update((facts.instance, each.manager) for facts in each.components)
    return homes


def down(host: str, manager: str) -> Snapshot:
    """Return what is to be seen of a manager that does not run."""
    return Snapshot(host, manager, 0, "")


def manager_for(
    action: Action, homes: Homes, connectors: Iterable[ConnectorProfile], usual: str
) -> str:
    """Return which manager an action is for: a connection is made by that of its out end.

    Args:
        action: Action that is to be done.
        homes: Where components live, or belong.
        connectors: The connectors that there are.
        usual: The manager for what belongs to none.
    """
    match action:
        case act.Load() | act.Unload():
            return action.manager or usual
        case act.Create():
            return action.manager or homes.get(parse_create(action.create).instance_name, usual)
        case act.Connect():
            return homes.get(action.connector.ports[0].instance, usual)
        case act.Disconnect():
            known = (each for each in connectors if each.connector_id == action.connector_id)
            connector = next(known, None)
            return usual if connector is None else homes.get(connector.ports[0].instance, usual)
        case act.Attach() | act.Detach():
            return homes.get(action.owner, usual)
        case act.Unregister():
            above = (m for m in homes.values() if inward(action.name, m) != action.name)
            return next(above, usual)
        case act.EndSlave():
            return usual
    return homes.get(action.instance, usual)


def sent(action: Action, manager: str, homes: Homes = NOWHERE, host: str = "") -> Action:
    """Return an action in the words of the manager that is to do it; `host` is this one."""
    if isinstance(action, act.Connect):
        return act.Connect(between_managers(action.connector, manager, homes, host))
    if isinstance(action, (act.Load, act.Unload)):
        return replace(action, manager="")
    if isinstance(action, act.Create):
        names = tuple(inward(name, manager) for name in action.names)
        return replace(action, names=names, manager="")
    if isinstance(action, (act.Register, act.Unregister)):
        return replace(action, name=inward(action.name, manager))
    return action


def between_managers(
    connector: ConnectorProfile, manager: str, homes: Homes, host: str = ""
) -> ConnectorProfile:
    """Return a connector in the words of a manager: ends elsewhere name theirs."""
    ends = tuple(
        end
        if homes.get(end.instance, manager) == manager
        else PortRef(
            far_name(end.instance, _seen_from(manager, homes[end.instance], host)), end.port
        )
        for end in connector.ports
    )
    return replace(connector, ports=ends)


def _seen_from(manager: str, other: str, host: str) -> str:
    """Return how a manager names another one, both given as in plans that are made on `host`."""
    (_, here), (name, there) = split_manager(manager), split_manager(other)
    return name if here == there else on_host(name, there or host)


def expected_at(
    connector: ConnectorProfile, homes: Homes, host: str
) -> tuple[str, ConnectorProfile] | None:
    """Return who is to expect a connector between hosts, and the connector as it is expected."""
    managers = [homes.get(end.instance, "") for end in connector.ports]
    hosts = [split_manager(each)[1] or host for each in managers]
    if len(set(hosts)) < 2:
        return None
    ends = tuple(
        PortRef(far_name(end.instance, on_host(split_manager(manager)[0], of)), end.port)
        for end, manager, of in zip(connector.ports, managers, hosts, strict=True)
    )
    return managers[1], replace(connector, ports=ends)


def in_plan(snapshot: Snapshot, manager: str, host: str) -> Snapshot:
    """Return what a manager knows with managers named as in plans that are made on `host`."""
    here = split_manager(manager)[1]
    connectors = tuple(
        replace(each, ports=tuple(_end_in_plan(end, here, host) for end in each.ports))
        if peer_of(each)
        else each
        for each in snapshot.connectors
    )
    return replace(snapshot, manager=manager, connectors=connectors)


def _end_in_plan(end: PortRef, here: str, host: str) -> PortRef:
    peer, instance = split_far(end.instance)
    if not peer:
        return end
    there, _, name = peer.rpartition("/")
    there = there or here
    return PortRef(
        far_name(instance, name if there in ("", host) else manager_on(name, there)), end.port
    )
