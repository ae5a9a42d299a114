"""Models a deployment as state variables: their domains, present values and desired values.

A variable is a text, ``mgr:M`` (down, up), ``pkg:H/P==V`` (absent, installed on a host),
``mod:M/X`` (absent, loaded), ``cmp:C`` (absent, or a place), ``act:C`` (inactive, active, error),
``cfg:C.KEY`` (a value), ``con:K`` (no, yes, other: of that name, but not as desired). A place is
``M:inproc`` or ``M:slave``, with ``/NAME`` behind it for a certain slave.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Container, Iterable, Iterator, Mapping
from functools import cached_property

from rtkit.deployment.planning.default_costs import DEFAULT_COSTS
from rtkit.fast_dataclass import dataclass

DOWN, UP = "down", "up"
ABSENT, LOADED, INSTALLED = "absent", "loaded", "installed"
INACTIVE, ACTIVE, ERROR = "inactive", "active", "error"
NO, YES, OTHER = "no", "yes", "other"
ANY = "*"
"""As a desired value: anything but absent."""
_DOT = "\1"  # stands for a dot in the name of a component
HERE = "localhost"
"""The host of managers of which nothing else is said."""
UNKNOWN = "\0"
"""As a default: nobody knows which value a new component has."""

Facts = Mapping[str, str]
Wish = str | tuple[str, ...]
"""A value, `ANY`, or several of which each will do."""


@dataclass(frozen=True, slots=True)
class ComponentVariable:
    """Component variable: the places and states that a component may have.

    Attributes:
        module: Module that must be loaded to make it; empty for none.
        package: Package that must be installed to make it, ``P==V``; empty for none.
        places: Where it may be made.
        why_not: Why it cannot be made, where there is no place for it.
        members: Other components that must be there while it is, as it is composed of them.
        mates: Others that must have ended before it is created again, as they share a process.
    """

    name: str
    module: str = ""
    places: tuple[str, ...] = ()
    why_not: str = ""
    members: tuple[str, ...] = ()
    mates: tuple[str, ...] = ()
    package: str = ""


@dataclass(frozen=True, slots=True)
class ParameterVariable:
    """A configuration parameter.

    Attributes:
        default: Its value in a component just made; `UNKNOWN` if nobody knows.
        is_hot: It may be set while the component is active.
        text: Words for setting it, up to the value; ``set C.KEY=`` if empty.
        is_fixed: It is never set: only a component created again has the default.
    """

    default: str = UNKNOWN
    is_hot: bool = False
    text: str = ""
    is_fixed: bool = False


@dataclass(frozen=True, slots=True)
class ConnectionVariable:
    """A connection between two components, or that one drives the other.

    Attributes:
        text: Words for it, if not its name.
        why_not: Why it cannot be made.
    """

    ends: tuple[str, ...]
    why_not: str = ""
    text: str = ""


@dataclasses.dataclass(frozen=True)
class Model:
    """Model of a deployment: all variables, present values, and desired values.

    Attributes:
        managers: Modules that each manager finds; None where it may find any.
        keys: Parameters by ``C.KEY``.
        live: Present values; a variable that is not named has its usual one (see `usual`).
        desired: The desired values; what is not named may be anything.
        costs: Of each kind of command; ``KIND NAME`` for what concerns one component only, or one
            parameter, or one connection.
        slaves_need_modules: A module must be loaded also for what is made in a slave.
        hosts: The host of each manager, where it is not `HERE`.
    """

    managers: Mapping[str, frozenset[str] | None]
    units: Mapping[str, ComponentVariable]
    connectors: Mapping[str, ConnectionVariable] = dataclasses.field(default_factory=dict)
    keys: Mapping[str, ParameterVariable] = dataclasses.field(default_factory=dict)
    live: Facts = dataclasses.field(default_factory=dict)
    desired: Mapping[str, Wish] = dataclasses.field(default_factory=dict)
    costs: Mapping[str, float] = dataclasses.field(default_factory=lambda: DEFAULT_COSTS)
    slaves_need_modules: bool = False
    hosts: Mapping[str, str] = dataclasses.field(default_factory=dict)

    def usual(self, variable: str) -> str:
        """Return the value of a variable of which nothing is known."""
        kind, _, name = variable.partition(":")
        if kind == "cfg":
            return self.keys[name].default
        usual = {"mgr": DOWN, "act": INACTIVE, "con": NO}
        return usual.get(kind, ABSENT)

    def now(self, variable: str) -> str:
        """Return the value that a variable has in what lives."""
        found = self.live.get(variable)
        return self.usual(variable) if found is None else found

    def allows(self, variable: str, value: str) -> bool:
        """Return whether a value of a variable is as desired."""
        desired = self.desired.get(variable)
        return desired is None or is_granted(desired, value)

    def cost(self, kind: str, subject: str = "") -> float:
        """Return what a command costs, for what it is done to."""
        return self.costs[cost_name(self.costs, kind, subject)]

    @cached_property
    def keys_of(self) -> dict[str, list[str]]:
        """The parameters of each component, by its name."""
        found: dict[str, list[str]] = {name: [] for name in self.units}
        for key in self.keys:
            found[owner_of(key)].append(key)
        return found

    @cached_property
    def connectors_of(self) -> dict[str, list[str]]:
        """The connections of each component, by its name."""
        found: dict[str, list[str]] = {name: [] for name in self.units}
        for name, connector in self.connectors.items():
            for end in dict.fromkeys(connector.ends):
                found[end].append(name)
        return found

    @cached_property
    def wholes_of(self) -> dict[str, list[str]]:
        """Return the composites of each component, by its name."""
        found: dict[str, list[str]] = {name: [] for name in self.units}
        for unit in self.units.values():
            for member in unit.members:
                if member in found:
                    found[member].append(unit.name)
        return found

    def needed_module(self, unit: ComponentVariable, place: str) -> str:
        """Return the ``M/X`` that must be loaded to make a component at a place; or nothing."""
        if not unit.module or not (is_inproc(place) or self.slaves_need_modules):
            return ""
        return f"{manager_of(place)}/{unit.module}"

    def needed_package(self, unit: ComponentVariable, place: str) -> str:
        """Return the ``H/P==V`` that must be installed to make a component at a place; or none."""
        return f"{self.host_of(manager_of(place))}/{unit.package}" if unit.package else ""

    def host_of(self, manager: str) -> str:
        """Return the host of a manager."""
        return self.hosts.get(manager, HERE)

    def text_of(self, variable: str) -> str:
        """Return words for a variable; those for a parameter go before its value."""
        kind, _, name = variable.partition(":")
        match kind:
            case "cfg":
                return self.keys[name].text.removeprefix("set ") or f"{name}="
            case "con":
                return f"connection {self.connectors[name].text or name}"
            case "mod":
                manager, _, module = name.partition("/")
                return f"module {module} on {manager}"
            case "pkg":
                host, _, package = name.partition("/")
                return f"package {package} on {host}"
        return f"manager {name}" if kind == "mgr" else name

    def wishing(self, desired: Iterable[tuple[str, Wish]]) -> Model:
        """Return the same with other desired values."""
        return dataclasses.replace(self, desired=dict(desired))

    def variables(self) -> Iterator[str]:
        """Yield every variable."""
        yield from (f"mgr:{name}" for name in self.managers)
        modules = dict.fromkeys(
            f"{manager_of(place)}/{unit.module}"
            for unit in self.units.values()
            for place in unit.places
            if unit.module
        )
        named = (name[4:] for name in (*self.live, *self.desired) if name.startswith("mod:"))
        yield from (f"mod:{name}" for name in dict.fromkeys([*modules, *named]))
        packages = (
            f"pkg:{self.needed_package(unit, place)}"
            for unit in self.units.values()
            for place in unit.places
            if unit.package
        )
        others = (name for name in (*self.live, *self.desired) if name.startswith("pkg:"))
        yield from dict.fromkeys([*packages, *others])
        for name in self.units:
            yield f"cmp:{name}"
            yield f"act:{name}"
        yield from (f"cfg:{key}" for key in self.keys)
        yield from (f"con:{name}" for name in self.connectors)


def cost_name(costs: Container[str], kind: str, subject: str) -> str:
    """Return under which name a table has what a command costs, the most special one it has."""
    owner = owner_of(subject) if kind == "configure" else subject
    names = (f"{kind} {subject}", f"{kind} {owner}")
    return next((name for name in names if name in costs), kind)


def is_granted(desired: Wish, value: str) -> bool:
    """Return whether a value is the desired one."""
    if isinstance(desired, tuple):
        return any(is_granted(each, value) for each in desired)
    return value != ABSENT if desired == ANY else value == desired


def owner_of(key: str) -> str:
    """Return the component of a parameter: ``C.KEY``."""
    return key.partition(".")[0].replace(_DOT, ".")


def key_of(name: str, parameter: str) -> str:
    """Return how a parameter of a component is called here."""
    return f"{name.replace('.', _DOT)}.{parameter}"


def manager_of(place: str) -> str:
    """Return the manager of a place."""
    return place.partition(":")[0]


def is_inproc(place: str) -> bool:
    """Return whether a place is the process of the manager itself."""
    return place.endswith(":inproc")
