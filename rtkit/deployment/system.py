"""A wanted system as plain facts: the content of a system profile on this installation."""

from __future__ import annotations

from collections.abc import Container, Mapping

from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass, field, replace
from rtkit.rtc.create import listed_names, readable_create
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef

HIDDEN = "__"
"""Configuration sets whose names begin so hold hints about parameters, not their values."""


class BadComponent(Malformed):
    """The statements of a profile about a component make no sense.

    Attributes:
        position: Of the component within the profile, from 0.
    """

    def __init__(self, position: int, message: str) -> None:
        super().__init__(message)
        self.position = position


@dataclass(frozen=True, slots=True)
class KnownType:
    """Means of creating a component of some type.

    Attributes:
        create: Create string.
        module: ``PATH:INIT`` of the module to be loaded before; empty when none is needed.
    """

    create: str
    module: str = ""


@dataclass(frozen=True, slots=True)
class WantedComponent:
    """A component that shall exist.

    Attributes:
        id: Identity of its type as the profile states it.
        name: Name under which it shall be registered, ``localhost/dir/Motor0.rtc``.
        path: The same as users know it: the profile's own words, behind a slash.
        active_set: Empty when the profile states none.
        create: Create string that makes it; empty when nobody knows how.
        module: ``PATH:INIT`` of the module that it needs loaded; empty for none.
        pattern: Source of its stand-in; None when it is to be the real one.
        unknown_host: The host it names, when nobody knows that host.
        guests: Context id and instance name of other components that its contexts are to drive.
        hot: Parameters that may be changed while it is active; ``*`` for all.
        costs: Costs of kinds of steps that are done to it, where the profile states them.
        manager: Other manager of this host that is to hold it; empty for the first.
        rates: Of the contexts [Hz], in their order; 0 where the profile states none.
        policy: All that is done about its end and its health; None where nothing is stated of it.
        is_create_stated: The profile itself states the create string.
        kept: Set and name of parameters that are only set in a component just made.
        more_names: Further names under which it is registered when it is made.
        may_move: It is to leave the manager that it lives in if that is another one.
    """

    id: str
    instance: str
    name: str
    path: str
    is_required: bool = True
    ports: tuple[PortProfile, ...] = ()
    sets: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    active_set: str = ""
    contexts: tuple[ContextPattern, ...] = ()
    create: str = ""
    module: str = ""
    pattern: ComponentPattern | None = None
    unknown_host: str = ""
    guests: tuple[tuple[str, str], ...] = ()
    hot: tuple[str, ...] = ()
    costs: Mapping[str, float] = field(default_factory=dict)
    manager: str = ""
    rates: tuple[float, ...] = ()
    policy: Mapping[str, str] | None = None
    is_create_stated: bool = False
    kept: frozenset[tuple[str, str]] = frozenset()
    more_names: tuple[str, ...] = ()
    may_move: bool = False

    @property
    def members(self) -> tuple[str, ...]:
        """Instance names of its members, by its active set, else by its create string."""
        values = self.sets.get(self.active_set or "default", {})
        return listed_names(values.get("members", "")) or readable_create(self.create).members

    def port(self, name: str) -> PortProfile | None:
        """Return the port of that name, or None."""
        return next((port for port in self.ports if port.name == name), None)


@dataclass(frozen=True, slots=True)
class WantedConnector:
    """A connection that shall exist.

    Attributes:
        profile: A data connector names its out port first.
        is_data: It joins data ports, not service ports.
        is_required: Both components are required.
    """

    profile: ConnectorProfile
    is_data: bool
    is_required: bool


@dataclass(frozen=True, slots=True)
class WantedSystem:
    """A wanted system, in the order of its profile.

    Attributes:
        notes: Decisions on matters that the profile leaves open.
    """

    components: tuple[WantedComponent, ...] = ()
    connectors: tuple[WantedConnector, ...] = ()
    notes: tuple[str, ...] = ()

    def component(self, instance: str) -> WantedComponent:
        """Return the component of that instance name."""
        return next(c for c in self.components if c.instance == instance)


def without(system: WantedSystem, managers: Container[str]) -> WantedSystem:
    """Return a system without what belongs to some of its managers."""
    there = {each.instance for each in system.components if each.manager in managers}
    return replace(
        system,
        components=tuple(each for each in system.components if each.instance not in there),
        connectors=tuple(
            each
            for each in system.connectors
            if not any(end.instance in there for end in each.profile.ports)
        ),
    )


def address(system: WantedSystem, end: PortRef) -> str:
    """Return a port as users know it."""
    return f"{system.component(end.instance).path}:{end.port}"
