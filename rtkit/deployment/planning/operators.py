"""Operators: the commands of a deployment, with preconditions, effects and costs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from rtkit.deployment.planning import model as var
from rtkit.deployment.planning.model import Model, is_inproc, manager_of, owner_of
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
        subject: Its subject: a manager, ``M/X``, a component, ``C.KEY``, a connection.
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


def _there(name: str) -> Requirement:
    return Requirement(f"cmp:{name}", (var.ABSENT,), is_not=True)


class Operators:
    """Makes the commands of one model."""

    def __init__(self, model: Model) -> None:
        self._model = model

    def start_manager(self, manager: str) -> Operator:
        """Start a manager."""
        variable, text = f"mgr:{manager}", f"start manager {manager}"
        needs = [Requirement(variable, (var.DOWN,))]
        return self._made("start_manager", manager, text, needs, (variable, var.UP))

    def install(self, name: str) -> Operator:
        """Install a package on a host: ``H/P==V``."""
        needs = [Requirement(f"pkg:{name}", (var.ABSENT,))]
        host, _, package = name.partition("/")
        text = f"install {package} on {host}"
        return self._made("install", name, text, needs, (f"pkg:{name}", var.INSTALLED))

    def uninstall(self, name: str) -> Operator:
        """Remove a package from a host: ``H/P==V``, of which no component is there."""
        model = self._model
        needs = [Requirement(f"pkg:{name}", (var.INSTALLED,))]
        heeds = [f"cmp:{each}" for each in model.units]
        heeds += [v for v in model.desired if v[:4] == "mod:" and not model.allows(v, var.LOADED)]
        host, _, package = name.partition("/")
        for unit in model.units.values():
            if unit.package == package:
                places = {*unit.places, model.now(f"cmp:{unit.name}")} - {var.ABSENT}
                here = sorted(each for each in places if model.needed_package(unit, each) == name)
                needs += [Requirement(f"cmp:{unit.name}", tuple(here), is_not=True)] if here else []
                heeds += [f"mod:{m}" for m in (model.needed_module(unit, p) for p in here) if m]
        text = f"uninstall {package} from {host}"
        change = (f"pkg:{name}", var.ABSENT)
        return self._made("uninstall", name, text, needs, change, heeds=tuple(heeds))

    def load(self, name: str) -> Operator:
        """Load a module: ``M/X``."""
        manager, _, module = name.partition("/")
        needs = [
            Requirement(f"mgr:{manager}", (var.UP,)),
            Requirement(f"mod:{name}", (var.ABSENT,)),
        ]
        heeds = tuple(dict.fromkeys(self._packages_of(manager, module)))
        text = f"load {module} on {manager}"
        return self._made("load", name, text, needs, (f"mod:{name}", var.LOADED), heeds=heeds)

    def _packages_of(self, manager: str, module: str) -> Iterator[str]:
        for unit in self._model.units.values():
            if unit.module == module and unit.package:
                yield f"pkg:{self._model.host_of(manager)}/{unit.package}"

    def unload(self, name: str) -> Operator:
        """Unload a module: ``M/X``."""
        manager, _, module = name.partition("/")
        needs = [Requirement(f"mod:{name}", (var.LOADED,))]
        needs += [
            Requirement(f"cmp:{unit.name}", (f"{manager}:inproc",), is_not=True)
            for unit in self._model.units.values()
            if unit.module == module
        ]
        text = f"unload {module} from {manager}"
        return self._made("unload", name, text, needs, (f"mod:{name}", var.ABSENT))

    def create(self, name: str, place: str) -> Operator:
        """Make a component at a place."""
        unit = self._model.units[name]
        needs = [
            Requirement(f"mgr:{manager_of(place)}", (var.UP,)),
            Requirement(f"cmp:{name}", (var.ABSENT,)),
        ]
        module = self._model.needed_module(unit, place)
        if module:
            needs.append(Requirement(f"mod:{module}", (var.LOADED,)))
        package = self._model.needed_package(unit, place)
        if package:
            needs.append(Requirement(f"pkg:{package}", (var.INSTALLED,)))
        needs += map(_there, unit.members)
        manager, _, how = place.partition(":")
        slave = how.partition("/")[2]
        where = "" if is_inproc(place) else f" in slave {slave}" if slave else " in a slave"
        kind = "create" if is_inproc(place) else "create_slave"
        heeds = tuple(f"cmp:{each}" for each in unit.mates)
        text = f"create {name} on {manager}{where}"
        return self._made(kind, name, text, needs, (f"cmp:{name}", place), value=place, heeds=heeds)

    def delete(self, name: str) -> Operator:
        """End a component; its configuration returns to the defaults."""
        model = self._model
        needs = [
            _there(name),
            Requirement(f"act:{name}", (var.INACTIVE, var.ERROR)),
            *(Requirement(f"con:{each}", (var.NO,)) for each in model.connectors_of[name]),
            *(Requirement(f"cmp:{whole}", (var.ABSENT,)) for whole in model.wholes_of[name]),
        ]
        changes = [(f"cmp:{name}", var.ABSENT), (f"act:{name}", var.INACTIVE)]
        changes += ((f"cfg:{key}", model.keys[key].default) for key in model.keys_of[name])
        return self._made("delete", name, f"delete {name}", needs, *changes)

    def connect(self, name: str) -> Operator:
        """Make a connection."""
        ends = dict.fromkeys(self._model.connectors[name].ends)
        needs = [Requirement(f"con:{name}", (var.NO,)), *map(_there, ends)]
        text = f"connect {self._text(name)}"
        return self._made("connect", name, text, needs, (f"con:{name}", var.YES))

    def disconnect(self, name: str) -> Operator:
        """Remove a connection."""
        heeds = tuple(f"act:{end}" for end in dict.fromkeys(self._model.connectors[name].ends))
        needs = [Requirement(f"con:{name}", (var.YES, var.OTHER))]
        text = f"disconnect {self._text(name)}"
        return self._made("disconnect", name, text, needs, (f"con:{name}", var.NO), heeds=heeds)

    def configure(self, key: str, value: str) -> Operator:
        """Set a parameter: ``C.KEY``."""
        model, name = self._model, owner_of(key)
        needs = [_there(name)]
        if not model.keys[key].is_hot:
            needs.append(Requirement(f"act:{name}", (var.INACTIVE,)))
        heeds = tuple(f"cfg:{each}" for each in model.keys_of[name] if key.endswith(".@"))
        text = f"{model.keys[key].text or f'set {key}='}{value}"
        return self._made(
            "configure", key, text, needs, (f"cfg:{key}", value), value=value, heeds=heeds
        )

    def activate(self, name: str) -> Operator:
        """Activate a component: after its connections and its parameters."""
        model = self._model
        needs = [_there(name), Requirement(f"act:{name}", (var.INACTIVE,))]
        heeds = (
            *(f"con:{connector}" for connector in model.connectors_of[name]),
            *(f"cfg:{key}" for key in model.keys_of[name]),
            *(f"cmp:{whole}" for whole in model.wholes_of[name]),
        )
        change = (f"act:{name}", var.ACTIVE)
        return self._made("activate", name, f"activate {name}", needs, change, heeds=heeds)

    def deactivate(self, name: str) -> Operator:
        """Deactivate a component."""
        return self._to_rest("deactivate", name, var.ACTIVE)

    def reset(self, name: str) -> Operator:
        """Reset a component that is in Error."""
        return self._to_rest("reset", name, var.ERROR)

    def _to_rest(self, kind: str, name: str, state: str) -> Operator:
        variable = f"act:{name}"
        needs = [Requirement(variable, (state,))]
        return self._made(kind, name, f"{kind} {name}", needs, (variable, var.INACTIVE))

    def _made(
        self,
        kind: str,
        subject: str,
        text: str,
        needs: Sequence[Requirement],
        *changes: tuple[str, str],
        value: str = "",
        heeds: tuple[str, ...] = (),
    ) -> Operator:
        cost = self._model.cost(kind, subject)
        return Operator(kind, subject, text, tuple(needs), changes, cost, value, heeds)

    def _text(self, name: str) -> str:
        return self._model.connectors[name].text or name


def judge(model: Model, moves: Iterable[Operator]) -> str:
    """Return the first thing that is wrong with a plan, by the number of its step; or nothing.

    Has the same result as verifying it on the whole problem, and checks only what steps touch.
    """
    state = {variable: model.now(variable) for variable in model.variables()}
    for number, move in enumerate(moves, 1):
        broken = next((need for need in move.needs if not need.holds(state[need.variable])), None)
        if broken is not None:
            return f"step {number} ({move.text}): does not hold: {broken}"
        state.update(move.changes)
    for variable, value in state.items():
        if not model.allows(variable, value):
            return f"what is desired does not hold at the end: {variable}={value}"
    return ""
