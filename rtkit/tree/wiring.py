"""Which connections two ports may have, and which they have: pure rules over facts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.errors import NotFound, Refused
from rtkit.rtc.enums import PortType
from rtkit.rtc.names import Path
from rtkit.rtc.profiles import ConnectorProfile, PortInterfaceProfile, PortProfile, PortRef
from rtkit.tree.resolve import component_of_port
from rtkit.tree.view import Node

ANY = "any"
DATA_DEFAULTS = {
    "dataport.dataflow_type": "push",
    "dataport.interface_type": "corba_cdr",
    "dataport.subscription_type": "new",
}
SERVICE_DEFAULTS = {"port.port_type": PortType.SERVICE.value}


class End(NamedTuple):
    """A port that a user named, found."""

    path: Path
    ref: PortRef
    port: PortProfile


def component_facts(snapshot: Snapshot, node: Node) -> ComponentFacts:
    """Return the facts of the component behind a node."""
    facts = snapshot.component(node.instance)
    if facts is None:
        raise NotFound(f"No such object: {node.path}")
    return facts


def find_end(snapshot: Snapshot, root: Node, path: Path) -> End:
    """Return the port at `path`.

    Raises:
        NotFound: Its component, or the port, does not exist.
        Refused: Something else than a living component is there.
    """
    facts = component_facts(snapshot, component_of_port(root, path, snapshot.host))
    port = facts.port(path.port or "")
    if port is None:
        raise NotFound(f"Port not found: {path.typed}")
    return End(path, PortRef(facts.instance, port.name), port)


def check_pair(one: End, other: End, given: Mapping[str, str], *, is_forced: bool = False) -> None:
    """Refuse ports that cannot be connected; forced, unlike data types are let pass.

    Raises:
        Refused: Tells why.
    """
    types = {one.port.port_type, other.port.port_type}
    is_service = types == {PortType.SERVICE}
    if one.ref == other.ref or not (is_service or types == {PortType.IN, PortType.OUT}):
        raise Refused("Wrong port type.")
    if not all(_allows(one.port, other.port, key, value) for key, value in given.items()):
        raise Refused("Incompatible connection properties.")
    if is_service:
        _check_interfaces(one.port.interfaces, other.port.interfaces)
    elif not is_forced:
        _check_data_types(one, other)


def _allows(one: PortProfile, other: PortProfile, key: str, value: str) -> bool:
    lists = [port.properties[key] for port in (one, other) if key in port.properties]
    if len(lists) < 2 or key == "dataport.data_type":
        return True
    return all(_is_listed(value, listed) for listed in lists)


def _is_listed(value: str, listed: str) -> bool:
    from rtkit.component.options import interface_name

    words = [interface_name(word) for word in listed.split(",")]
    return ANY in words or interface_name(value) in words


def _check_interfaces(
    one: Sequence[PortInterfaceProfile], other: Sequence[PortInterfaceProfile]
) -> None:
    if not one or not other:
        return
    pairs = [(a, b) for a in one for b in other if a.type_name == b.type_name]
    if not pairs:
        raise Refused("Interfaces do not match.")
    if all(a.polarity is b.polarity for a, b in pairs):
        raise Refused("Polarities do not match.")


def _check_data_types(one: End, other: End) -> None:
    from rtkit.component.typenames import is_same_type

    if not is_same_type(one.port.data_type, other.port.data_type):
        raise Refused(
            f"data types differ: {one.path.typed} has {one.port.data_type},"
            f" {other.path.typed} has {other.port.data_type}"
        )


def make_connector(
    one: End, other: End, connector_id: str, name: str, given: Mapping[str, str]
) -> ConnectorProfile:
    """Return the connector of two ports, out port first, defaults filled in."""
    if one.port.port_type is PortType.SERVICE:
        ends, properties = (one, other), {**SERVICE_DEFAULTS, **given}
    else:
        ends = (one, other) if one.port.port_type is PortType.OUT else (other, one)
        data_type = one.port.data_type or other.port.data_type
        properties = {**DATA_DEFAULTS, "dataport.data_type": data_type, **given}
    refs = tuple(end.ref for end in ends)
    chosen = name or f"{one.port.name}_{other.port.name}"
    return ConnectorProfile(connector_id, chosen, refs, properties)


def between(
    wires: Iterable[ConnectorProfile], one: PortRef, others: Sequence[PortRef] = ()
) -> list[ConnectorProfile]:
    """Return the connections of port `one`, where `others` are given only those with one."""
    return [
        wire
        for wire in wires
        if one in wire.ports and (not others or any(other in wire.ports for other in others))
    ]


def of_component(wires: Iterable[ConnectorProfile], instance: str) -> list[ConnectorProfile]:
    """Return the connections of every port of a component."""
    return [wire for wire in wires if any(end.instance == instance for end in wire.ports)]
