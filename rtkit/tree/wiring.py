"""Which connections two ports may have, and which they have: pure rules over facts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.errors import NotFound, Refused
from rtkit.rtc.enums import PortType
from rtkit.rtc.names import Path
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef
from rtkit.tree.resolve import component_of_port
from rtkit.tree.view import Node

DATA_DEFAULTS = {
    "dataport.dataflow_type": "push",
    "dataport.interface_type": "corba_cdr",
    "dataport.subscription_type": "new",
}
SERVICE_DEFAULTS = {"port.port_type": PortType.SERVICE.value}
_NO_CHOICE = ("dataport.data_type", "port.port_type", "description")


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


def check_pair(one: End, other: End, properties: Mapping[str, str]) -> None:
    """Refuse ports that cannot be connected with these properties.

    Raises:
        Refused: Tells why.
    """
    from rtkit.component.check import INCOMPATIBLE, WRONG_TYPE, refusal

    why = refusal((one.port, other.port), properties)
    if one.ref == other.ref:
        why = WRONG_TYPE
    elif not why and not all(_allows(one.port, other.port, *each) for each in properties.items()):
        why = INCOMPATIBLE
    if why:
        raise Refused(why)


def _allows(one: PortProfile, other: PortProfile, key: str, value: str) -> bool:
    if key in _NO_CHOICE or ".buffer." in key:
        return True
    lists = [port.properties[key] for port in (one, other) if key in port.properties]
    return len(lists) < 2 or all(_is_listed(value, listed) for listed in lists)


def _is_listed(value: str, listed: str) -> bool:
    from rtkit.component.options import interface_name

    words = [interface_name(word) for word in listed.split(",")]
    return "any" in words or interface_name(value) in words


def make_connector(
    one: End, other: End, connector_id: str, name: str, given: Mapping[str, str]
) -> ConnectorProfile:
    """Return the connector of two ports, out port first, defaults filled in.

    Raises:
        Refused: The ports cannot be connected with these properties; tells why.
    """
    check_pair(one, other, given)
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
