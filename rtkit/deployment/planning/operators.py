"""Operators: the commands of a deployment, with preconditions, effects and costs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rtkit.deployment.planning.model import (
    ABSENT,
    ACTIVE,
    DOWN,
    ERROR,
    INACTIVE,
    LOADED,
    NO,
    OTHER,
    UP,
    YES,
    ComponentVariable,
    Model,
    is_inproc,
    manager_of,
    owner_of,
)
from rtkit.fast_dataclass import dataclass


class Requirement(NamedTuple):
    """Requirement on a variable: one of these values, or none of them."""

    variable: str
    values: tuple[str, ...]
    is_not: bool = False

    def holds(self, value: str) -> bool:
        """Return whether it holds of a value."""
        return (value in self.values) != self.is_not

    def __str__(self) -> str:
        return f"{self.variable} is {'not ' if self.is_not else ''}{' or '.join(self.values)}"


@dataclass(frozen=True, slots=True)
class Operator:
    """A command of a deployment.

    Attributes:
        kind: Of the table of costs.
        subject: What it is done to: a manager, ``M/X``, a component, ``C.KEY``, a connection.
        text: Words for it.
        needs: All of them must hold.
        changes: Values after it.
        value: Place or value that is given; empty for most.
        heeds: Variables that it should find settled, though it needs nothing of them.
    """

    kind: str
    subject: str
    text: str
    needs: tuple[Requirement, ...]
    changes: tuple[tuple[str, str], ...]
    cost: float
    value: str = ""
    heeds: tuple[str, ...] = ()


class Operators:
    """Makes the commands of one model."""

    def __init__(self, model: Model) -> None:
        self._model = model

    def start(self, manager: str) -> Operator:
        """Start a manager."""
        variable = f"mgr:{manager}"
        return Operator(
            "start_manager",
            manager,
            f"start manager {manager}",
            (Requirement(variable, (DOWN,)),),
            ((variable, UP),),
            self._model.cost("start_manager", manager),
        )

    def load(self, name: str) -> Operator:
        """Load a module: ``M/X``."""
        manager, _, module = name.partition("/")
        return Operator(
            "load",
            name,
            f"load {module} on {manager}",
            (Requirement(f"mgr:{manager}", (UP,)), Requirement(f"mod:{name}", (ABSENT,))),
            ((f"mod:{name}", LOADED),),
            self._model.cost("load", name),
        )

    def unload(self, name: str) -> Operator:
        """Unload a module: ``M/X``."""
        manager, _, module = name.partition("/")
        held = tuple(
            Requirement(f"cmp:{unit.name}", (f"{manager}:inproc",), is_not=True)
            for unit in self._model.units.values()
            if unit.module == module
        )
        return Operator(
            "unload",
            name,
            f"unload {module} from {manager}",
            (Requirement(f"mod:{name}", (LOADED,)), *held),
            ((f"mod:{name}", ABSENT),),
            self._model.cost("unload", name),
        )

    def create(self, name: str, place: str) -> Operator:
        """Make a component at a place."""
        unit = self._model.units[name]
        needs = [
            Requirement(f"mgr:{manager_of(place)}", (UP,)),
            Requirement(f"cmp:{name}", (ABSENT,)),
        ]
        module = self._model.needed_module(unit, place)
        if module:
            needs.append(Requirement(f"mod:{module}", (LOADED,)))
        needs += [Requirement(f"cmp:{each}", (ABSENT,), is_not=True) for each in unit.members]
        manager, _, how = place.partition(":")
        slave = how.partition("/")[2]
        where = "" if is_inproc(place) else f" in slave {slave}" if slave else " in a slave"
        kind = "create" if is_inproc(place) else "create_slave"
        return Operator(
            kind,
            name,
            f"create {name} on {manager}{where}",
            tuple(needs),
            ((f"cmp:{name}", place),),
            self._model.cost(kind, name),
            place,
            heeds=tuple(f"cmp:{each}" for each in unit.mates),
        )

    def delete(self, name: str) -> Operator:
        """End a component; its configuration returns to the defaults."""
        model = self._model
        reset = [(f"cfg:{key}", model.keys[key].default) for key in model.keys_of[name]]
        return Operator(
            "delete",
            name,
            f"delete {name}",
            (
                Requirement(f"cmp:{name}", (ABSENT,), is_not=True),
                Requirement(f"act:{name}", (INACTIVE, ERROR)),
                *(Requirement(f"con:{wire}", (NO,)) for wire in model.wires_of[name]),
                *(Requirement(f"cmp:{whole}", (ABSENT,)) for whole in model.wholes_of[name]),
            ),
            ((f"cmp:{name}", ABSENT), (f"act:{name}", INACTIVE), *reset),
            model.cost("delete", name),
        )

    def connect(self, name: str) -> Operator:
        """Make a connection."""
        ends = dict.fromkeys(self._model.wires[name].ends)
        return Operator(
            "connect",
            name,
            f"connect {self._told(name)}",
            (
                Requirement(f"con:{name}", (NO,)),
                *(Requirement(f"cmp:{end}", (ABSENT,), is_not=True) for end in ends),
            ),
            ((f"con:{name}", YES),),
            self._model.cost("connect", name),
        )

    def disconnect(self, name: str) -> Operator:
        """Remove a connection."""
        ends = dict.fromkeys(self._model.wires[name].ends)
        return Operator(
            "disconnect",
            name,
            f"disconnect {self._told(name)}",
            (Requirement(f"con:{name}", (YES, OTHER)),),
            ((f"con:{name}", NO),),
            self._model.cost("disconnect", name),
            heeds=tuple(f"act:{end}" for end in ends),
        )

    def configure(self, key: str, value: str) -> Operator:
        """Set a parameter: ``C.KEY``."""
        name, told = owner_of(key), self._model.keys[key].text or f"set {key}="
        needs = [Requirement(f"cmp:{name}", (ABSENT,), is_not=True)]
        if not self._model.keys[key].is_hot:
            needs.append(Requirement(f"act:{name}", (INACTIVE,)))
        return Operator(
            "configure",
            key,
            f"{told}{value}",
            tuple(needs),
            ((f"cfg:{key}", value),),
            self._model.cost("configure", key),
            value,
            heeds=tuple(f"cfg:{each}" for each in self._model.keys_of[name] if key.endswith(".@")),
        )

    def activate(self, name: str) -> Operator:
        """Activate a component: after its connections and its parameters."""
        model = self._model
        return Operator(
            "activate",
            name,
            f"activate {name}",
            (
                Requirement(f"cmp:{name}", (ABSENT,), is_not=True),
                Requirement(f"act:{name}", (INACTIVE,)),
            ),
            ((f"act:{name}", ACTIVE),),
            model.cost("activate", name),
            heeds=(
                *(f"con:{wire}" for wire in model.wires_of[name]),
                *(f"cfg:{key}" for key in model.keys_of[name]),
                *(f"cmp:{whole}" for whole in model.wholes_of[name]),
            ),
        )

    def deactivate(self, name: str) -> Operator:
        """Deactivate a component."""
        variable = f"act:{name}"
        cost = self._model.cost("deactivate", name)
        need = Requirement(variable, (ACTIVE,))
        return Operator(
            "deactivate", name, f"deactivate {name}", (need,), ((variable, INACTIVE),), cost
        )

    def reset(self, name: str) -> Operator:
        """Reset a component that is in Error."""
        variable = f"act:{name}"
        cost = self._model.cost("reset", name)
        return Operator(
            "reset",
            name,
            f"reset {name}",
            (Requirement(variable, (ERROR,)),),
            ((variable, INACTIVE),),
            cost,
        )

    def every(self) -> Iterator[Operator]:
        """Yield every command that may be possible at some time; for models that are small."""
        model = self._model
        yield from (self.start(manager) for manager in model.managers)
        for variable in model.variables():
            if variable.startswith("mod:"):
                if self.finds(variable[4:]):
                    yield self.load(variable[4:])
                yield self.unload(variable[4:])
        for name, unit in model.units.items():
            for place in unit.places:
                # What must be loaded before is looked for when it is loaded.
                if model.needed_module(unit, place) or self._finds_for(unit, place):
                    yield self.create(name, place)
            yield from (self.delete(name), self.activate(name))
            yield from (self.deactivate(name), self.reset(name))
        for key in (each for each in model.keys if not model.keys[each].is_fixed):
            yield from (self.configure(key, value) for value in self._values(key))
        for name, wire in model.wires.items():
            yield self.disconnect(name)
            if not wire.why_not:
                yield self.connect(name)

    def _told(self, name: str) -> str:
        return self._model.wires[name].text or name

    def finds(self, name: str) -> bool:
        """Return whether a manager finds a module: ``M/X``."""
        manager, _, module = name.partition("/")
        found = self._model.managers.get(manager, frozenset())
        return found is None or module in found

    def _finds_for(self, unit: ComponentVariable, place: str) -> bool:
        return not unit.module or self.finds(f"{manager_of(place)}/{unit.module}")

    def _values(self, key: str) -> list[str]:
        desired = self._model.desired.get(f"cfg:{key}", ())
        return [desired] if isinstance(desired, str) else list(desired)
