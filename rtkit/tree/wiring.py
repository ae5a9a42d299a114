"""Wiring rules over facts, pure: the connections that two ports may have, and those they have."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

from rtkit.deployment.shown_ports import OwnEnds
from rtkit.errors import NotFound, Refused, Unreachable
from rtkit.rtc.enums import PortType
from rtkit.rtc.far_ends import far_name, host_of, on_host
from rtkit.rtc.names import Path
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef
from rtkit.tree.resolve import component_of_port, no_port, node_at, nodes_at

if TYPE_CHECKING:
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.listing import Listing

DATA_DEFAULTS = {
    "dataport.dataflow_type": "push",
    "dataport.interface_type": "zenoh",
    "dataport.subscription_type": "new",
}
SERVICE_DEFAULTS = {"port.port_type": PortType.SERVICE.value}
_NO_CHOICE = ("dataport.data_type", "port.port_type", "description")


class ResolvedPort(NamedTuple):
    """A port that a user named, found; `ref` is its own name where a composite shows it.

    Attributes:
        manager: Which manager has it, as ``HOST/NAME``, where several are asked.
    """

    path: Path
    ref: PortRef
    port: PortProfile
    manager: str = ""

    def seen_from(self, manager: str) -> PortRef:
        """Return the port as a manager names it."""
        if self.manager == manager:
            return self.ref
        return PortRef(_far(self.ref.instance, self.manager, host_of(manager)), self.ref.port)


def _far(instance: str, manager: str, host: str) -> str:
    """Return how a manager of a host names a component of another manager, ``HOST/NAME``."""
    is_beside = host_of(manager) == host
    return far_name(instance, manager.rpartition("/")[2] if is_beside else manager)


class Facts(Protocol):
    """Source of facts: a `Tree`."""

    def listing(self) -> Listing:
        """Return the short list of components."""
        ...

    def listing_at(self, paths: Sequence[Path]) -> Listing:
        """Return one with the components at a few paths."""
        ...

    def part(self, instances: Sequence[str]) -> Snapshot:
        """Return what concerns a few components."""
        ...


class ManagerFacts(Facts, Protocol):
    """Source of facts that has the name of its manager: a `Tree`."""

    host: str
    manager: str


def find_ends(facts: Facts, paths: Sequence[Path]) -> tuple[Snapshot, list[ResolvedPort]]:
    """Return the ports at these paths, and what concerns their components.

    Raises:
        NotFound: A component, or a port, does not exist.
        Refused: Something else than a living component is there.
    """
    instances = [node.instance for node in nodes_at(facts, paths, component_of_port)]
    snapshot = facts.part(instances)
    own = OwnEnds.of(snapshot)
    ends = [_end(snapshot, own, *each) for each in zip(instances, paths, strict=True)]
    return snapshot, ends


def find_ends_at(
    at: Callable[[Path], ManagerFacts], paths: Sequence[Path]
) -> tuple[dict[str, Snapshot], list[ResolvedPort]]:
    """Return the ports at paths that may lead to several managers, and what each knows of them.

    Where they lead to one only, that goes by no name.

    Raises:
        NotFound: A component, or a port, does not exist.
        Refused: Something else than a living component is there.
        Unreachable: A manager does not run.
    """
    trees = [at(path) for path in paths]
    of_trees = [on_host(tree.manager, tree.host) for tree in trees]
    names = list(dict.fromkeys(of_trees))
    if len(names) < 2:
        snapshot, ends = find_ends(trees[0], paths)
        return {"": snapshot}, ends
    snapshots: dict[str, Snapshot] = {}
    found: dict[int, ResolvedPort] = {}
    for name in names:
        places = [number for number, each in enumerate(of_trees) if each == name]
        tree = trees[places[0]]
        snapshots[name], ends = find_ends(tree, [paths[number] for number in places])
        found.update(zip(places, (end._replace(manager=name) for end in ends), strict=True))
    return snapshots, [found[number] for number in range(len(paths))]


def between_paths(
    facts: ManagerFacts,
    at: Callable[[Path], ManagerFacts],
    is_near: Callable[[Path], bool],
    paths: Sequence[Path],
) -> list[ConnectorProfile]:
    """Return the connectors of the port at the first path, or those to the ports at the others.

    Args:
        facts: Of the manager to which the first path leads.
        at: Returns the facts of the manager that a path leads to.
        is_near: Whether a path leads to that of the first one.
        paths: Of ports.

    Raises:
        NotFound: A component, or a port, does not exist.
        Refused: Something else than a living component is there.
    """
    from rtkit.link.host_links import read

    snapshot, (first, *others) = find_ends(facts, [path for path in paths if is_near(path)])
    refs = [other.ref for other in others]
    for path in paths:
        if not is_near(path):
            linked = lambda host: read(host).far_manager  # noqa: E731
            refs.append(find_far_end(at, path, facts.host, linked))
    return between(snapshot.connectors, first.ref, refs)


def find_far_end(
    at: Callable[[Path], ManagerFacts], path: Path, host: str, far_manager: Callable[[str], str]
) -> PortRef:
    """Return a port in another manager as one of `host` names it, also while that one is away.

    `far_manager` returns which manager of another host is linked.

    Raises:
        NotFound: The other manager answers, and there is no such port.
    """
    from rtkit.rtc.names import COMPONENT_SUFFIX, MANAGER_SUFFIX, is_local_host

    try:
        tree = at(path)
        _, (end,) = find_ends(tree, [path])
    except Unreachable:
        above = (each for each in path.elements if each.endswith(MANAGER_SUFFIX))
        manager = next(above, "").removesuffix(MANAGER_SUFFIX)
        instance = path.elements[-1].removesuffix(COMPONENT_SUFFIX)
        far_host = path.elements[0]
        if not is_local_host(far_host, host):
            manager = on_host(manager or far_manager(far_host), far_host)
        return PortRef(far_name(instance, manager), path.port or "")
    manager = on_host(tree.manager, tree.host)
    return PortRef(_far(end.ref.instance, manager, host), end.ref.port)


def ports_of(facts: Facts, path: Path) -> tuple[PortProfile, ...]:
    """Return the ports of the component at a path, whatever port that names.

    Raises:
        NotFound: There is no such component.
        Refused: Something else than a living component is there.
    """
    instance = node_at(facts, path, component_of_port).instance
    known = facts.part([instance]).component(instance)
    return known.ports if known is not None else ()


def _end(snapshot: Snapshot, own: OwnEnds, instance: str, path: Path) -> ResolvedPort:
    facts = snapshot.component(instance)
    if facts is None:
        raise NotFound(f"No such object: {path.typed}")
    port = facts.port(path.port or "")
    if port is None:
        raise no_port(path, (each.name for each in facts.ports))
    return ResolvedPort(path, own.end(PortRef(instance, port.name)), port)


def check_pair(one: ResolvedPort, other: ResolvedPort, properties: Mapping[str, str]) -> None:
    """Refuse ports that cannot be connected with these properties.

    Raises:
        Refused: States why.
    """
    from rtkit.component.ports.port_matching import incompatible, refusal
    from rtkit.rtc.port_types import WRONG_TYPE

    why = refusal((one.port, other.port), properties)
    if (one.ref, one.manager) == (other.ref, other.manager):
        why = WRONG_TYPE
    elif not why:
        lacks = (_lacking(one.port, other.port, *each) for each in properties.items())
        key, port = next(filter(None, lacks), ("", one.port))
        why = incompatible(key, properties[key], port) if key else ""
    if why:
        raise Refused(why)


def _lacking(
    one: PortProfile, other: PortProfile, key: str, value: str
) -> tuple[str, PortProfile] | None:
    """Return a key with a port that does not offer its value, though both have a list of them."""
    is_chosen = key not in _NO_CHOICE and ".buffer." not in key
    if not is_chosen or key not in one.properties or key not in other.properties:
        return None
    lacking = (port for port in (one, other) if not _is_listed(value, port.properties[key]))
    return next(((key, port) for port in lacking), None)


def _is_listed(value: str, listed: str) -> bool:
    from rtkit.rtc.connector_properties import interface_name

    words = [interface_name(word) for word in listed.split(",")]
    return "any" in words or interface_name(value) in words


def make_connector(
    one: ResolvedPort, other: ResolvedPort, connector_id: str, name: str, given: Mapping[str, str]
) -> ConnectorProfile:
    """Return the connector of two ports, out port first, defaults filled in.

    It is in the words of the manager of its first port, which is to be asked for it.

    Raises:
        Refused: The ports cannot be connected with these properties; states why.
    """
    check_pair(one, other, given)
    ends = in_order(one, other)
    if one.port.port_type is PortType.SERVICE:
        properties = {**SERVICE_DEFAULTS, **given}
    else:
        data_type = one.port.data_type or other.port.data_type
        properties = {**DATA_DEFAULTS, "dataport.data_type": data_type, **given}
    refs = tuple(end.seen_from(ends[0].manager) for end in ends)
    chosen = name or f"{one.port.name}_{other.port.name}"
    return ConnectorProfile(connector_id, chosen, refs, properties)


def in_order(one: ResolvedPort, other: ResolvedPort) -> tuple[ResolvedPort, ResolvedPort]:
    """Return two ports, the out port of a data connection first."""
    from rtkit.rtc.port_types import are_reversed

    is_turned = are_reversed((one.port.port_type, other.port.port_type))
    return (other, one) if is_turned else (one, other)


def between(
    connectors: Iterable[ConnectorProfile], one: PortRef, others: Sequence[PortRef] = ()
) -> list[ConnectorProfile]:
    """Return the connections of port `one`, where `others` are given only those with one."""
    return [
        connector
        for connector in connectors
        if one in connector.ports
        and (not others or any(other in connector.ports for other in others))
    ]


def of_component(snapshot: Snapshot, instance: str) -> list[ConnectorProfile]:
    """Return the connections of every port of a component."""
    facts = snapshot.component(instance)
    return OwnEnds.of(snapshot).connectors(facts, snapshot.connectors) if facts is not None else []
