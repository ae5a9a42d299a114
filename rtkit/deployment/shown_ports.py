"""Ports that composites show: each is a port of a member, under ``MEMBER.PORT``.

A connection is always one of the member's own port, whichever name the request has.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.fast_dataclass import replace
from rtkit.rtc.profiles import ConnectorProfile, PortRef


def own_end(
    end: PortRef, members: Callable[[str], Sequence[str]], has_port: Callable[[PortRef], bool]
) -> PortRef:
    """Return a port by its own name: that of the member, where a composite shows it."""
    for member in members(end.instance):
        port = end.port.removeprefix(f"{member}.")
        inner = PortRef(member, port)
        if port != end.port and has_port(inner):
            return own_end(inner, members, has_port)
    return end


def own_wire(
    connector: ConnectorProfile,
    members: Callable[[str], Sequence[str]],
    has_port: Callable[[PortRef], bool],
) -> ConnectorProfile:
    """Return a connector that joins ports by their own names."""
    ends = tuple(own_end(end, members, has_port) for end in connector.ports)
    return connector if ends == connector.ports else replace(connector, ports=ends)


class OwnEnds:
    """Finds the own names of ports, by the facts of components."""

    def __init__(self, components: Mapping[str, ComponentFacts]) -> None:
        self._components = components

    @classmethod
    def of(cls, snapshot: Snapshot) -> OwnEnds:
        """Return what finds them by a snapshot."""
        return cls({facts.instance: facts for facts in snapshot.components})

    def end(self, end: PortRef) -> PortRef:
        """Return a port by its own name."""
        return own_end(end, self._members, self._has_port)

    def wire(self, connector: ConnectorProfile) -> ConnectorProfile:
        """Return a connector that joins ports by their own names."""
        return own_wire(connector, self._members, self._has_port)

    def ends(self, facts: ComponentFacts) -> dict[str, PortRef]:
        """Return the ports of a component by their own names."""
        return {port.name: self.end(PortRef(facts.instance, port.name)) for port in facts.ports}

    def wires(
        self, facts: ComponentFacts, wires: Collection[ConnectorProfile]
    ) -> list[ConnectorProfile]:
        """Return those connectors that have an end at a port of a component."""
        ends = set(self.ends(facts).values())
        return [connector for connector in wires if not ends.isdisjoint(connector.ports)]

    def inner(self, instance: str) -> set[str]:
        """Return the members of a component, and theirs."""
        members = self._members(instance)
        return {*members}.union(*map(self.inner, members))

    def _members(self, instance: str) -> Sequence[str]:
        facts = self._components.get(instance)
        return facts.members if facts is not None else ()

    def _has_port(self, end: PortRef) -> bool:
        facts = self._components.get(end.instance)
        return facts is not None and facts.port(end.port) is not None
