"""Multi-manager view: joins the facts of the managers of one host and splits actions by manager.

A name of another manager than the first appears below it: ``localhost/m1.mgr/Motor0.rtc`` is what
manager ``m1`` itself calls ``localhost/Motor0.rtc``.

See decision 33.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.deployment.facts import Snapshot
from rtkit.errors import Refused
from rtkit.fast_dataclass import dataclass, fields, replace
from rtkit.rtc.create import parse_create
from rtkit.rtc.names import LOCAL, MANAGER_SUFFIX
from rtkit.rtc.profiles import ConnectorProfile

Homes = Mapping[str, str]
"""Managers of components, by instance name."""


@dataclass(frozen=True, slots=True)
class JointSnapshot(Snapshot):
    """Joint facts of several managers at about one moment; never sent.

    Attributes:
        others: Those beside the first: their components and connectors are listed here too, their
            processes and modules only there.
    """

    others: tuple[Snapshot, ...] = ()


def joined(snapshots: Sequence[Snapshot], homes: Homes) -> Snapshot:
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
    for each in snapshots:
        for connector in _whole(each, bearers):
            is_home = all(homes.get(end.instance) == each.manager for end in connector.ports)
            if is_home or connector.connector_id not in connectors:
                connectors[connector.connector_id] = each.manager
    parts = [_part(each, bearers, connectors) for each in snapshots]
    shown = [parts[0], *map(_shown_below, parts[1:])]
    values = {each.name: getattr(first, each.name) for each in fields(first)}
    values["components"] = tuple(facts for each in shown for facts in each.components)
    values["connectors"] = tuple(connector for each in shown for connector in each.connectors)
    values["systems"] = tuple(system for each in snapshots for system in each.systems)
    return JointSnapshot(**values, others=tuple(shown[1:]))


def _part(each: Snapshot, bearers: Homes, connectors: Mapping[str, str]) -> Snapshot:
    """Return what counts of one manager's facts."""
    return replace(
        each,
        components=tuple(c for c in each.components if bearers[c.instance] == each.manager),
        connectors=tuple(
            connector
            for connector in _whole(each, bearers)
            if connectors[connector.connector_id] == each.manager
        ),
    )


def _whole(each: Snapshot, bearers: Homes) -> Iterator[ConnectorProfile]:
    """Yield the connectors of which both ends count."""
    for connector in each.connectors:
        if all(bearers.get(end.instance) == each.manager for end in connector.ports):
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
    below = f"{LOCAL}/{manager}{MANAGER_SUFFIX}/"
    if name.startswith(below) or not name.startswith(f"{LOCAL}/"):
        return name
    return below + name.removeprefix(f"{LOCAL}/")


def inward(name: str, manager: str) -> str:
    """Return the name that a manager itself has for what is shown below it."""
    below = f"{LOCAL}/{manager}{MANAGER_SUFFIX}/"
    return f"{LOCAL}/{name.removeprefix(below)}" if name.startswith(below) else name


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
    """Return which manager an action is for.

    Args:
        action: What is to be done.
        homes: Where components live, or belong.
        connectors: The connectors that there are.
        usual: The manager for what belongs to none.

    Raises:
        Refused: It is for two of them.
    """
    match action:
        case act.Load() | act.Unload():
            return action.manager or usual
        case act.Create():
            return homes.get(parse_create(action.create).instance_name, usual)
        case act.Connect():
            return _one_of(action.connector, homes, usual)
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


def sent(action: Action, manager: str) -> Action:
    """Return an action in the words of the manager that is to do it."""
    if isinstance(action, (act.Load, act.Unload)):
        return replace(action, manager="")
    if isinstance(action, act.Create):
        return replace(action, names=tuple(inward(name, manager) for name in action.names))
    if isinstance(action, (act.Register, act.Unregister)):
        return replace(action, name=inward(action.name, manager))
    return action


def parted(connector: ConnectorProfile, homes: Homes, usual: str) -> str:
    """Return why a connector cannot be, as its ends are in two managers; empty when they are not.

    Reported as what is wrong with the second end.
    """
    one, other = (
        homes.get(end.instance, usual) for end in (connector.ports[0], connector.ports[-1])
    )
    if one == other:
        return ""
    return f"its components are in two managers ({one} and {other}); a connection joins two of one"


def _one_of(connector: ConnectorProfile, homes: Homes, usual: str) -> str:
    why = parted(connector, homes, usual)
    if why:
        raise Refused(f"connection {connector.connector_id}: {why}")
    return homes.get(connector.ports[0].instance, usual)
