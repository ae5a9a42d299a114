"""Ports that composites show: each is a port of a member, under ``MEMBER.PORT``.

A connection is always one of the member's own port, whichever name the request has.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Protocol

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.fast_dataclass import replace
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef


class ComponentPorts(Protocol):
    """A component, as far as it says whose ports it shows."""

    @property
    def members(self) -> Sequence[str]:
        """Instance names of its members."""

    def port(self, name: str) -> PortProfile | None:
        """Return its port of that name, or None."""


class OwnEnds:
    """Finds the own names of ports: those of members, where composites show them."""

    def __init__(self, components: Mapping[str, ComponentPorts]) -> None:
        self._components = components

    @classmethod
    def of(cls, snapshot: Snapshot) -> OwnEnds:
        """Return what finds them by a snapshot."""
        return cls({facts.instance: facts for facts in snapshot.components})

    def end(self, end: PortRef) -> PortRef:
        """Return a port by its own name."""
        for member in self._members(end.instance):
            port = end.port.removeprefix(f"{member}.")
            component = self._components.get(member)
            if port != end.port and component is not None and component.port(port) is not None:
                return self.end(PortRef(member, port))
        return end

    def connector(self, connector: ConnectorProfile) -> ConnectorProfile:
        """Return a connector that joins ports by their own names."""
        ends = tuple(map(self.end, connector.ports))
        return connector if ends == connector.ports else replace(connector, ports=ends)

    def ends(self, facts: ComponentFacts) -> dict[str, PortRef]:
        """Return the ports of a component by their own names."""
        return {port.name: self.end(PortRef(facts.instance, port.name)) for port in facts.ports}

    def connectors(
        self, facts: ComponentFacts, connectors: Collection[ConnectorProfile]
    ) -> list[ConnectorProfile]:
        """Return those connectors that have an end at a port of a component."""
        ends = set(self.ends(facts).values())
        return [connector for connector in connectors if not ends.isdisjoint(connector.ports)]

    def inner(self, instance: str) -> set[str]:
        """Return the members of a component, and theirs."""
        members = self._members(instance)
        return {*members}.union(*map(self.inner, members))

    def _members(self, instance: str) -> Sequence[str]:
        component = self._components.get(instance)
        return component.members if component is not None else ()
