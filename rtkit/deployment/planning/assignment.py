"""Assignments: possible outcomes of each component, with their costs, alone and with neighbours.

An assignment settles whether a component stays, is deleted or is created (again). All the rest
follows from the assignments: the parameters to set, the connections to make. So the search covers
assignments only.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import NamedTuple

from rtkit.deployment.planning import model as var
from rtkit.deployment.planning.model import ComponentVariable, Model, is_inproc, manager_of


class Assignment(NamedTuple):
    """Outcome of a component.

    Attributes:
        place: Where it is at the end; `ABSENT` for nowhere.
        is_made: It is made, after it was ended where it lives.
        is_ended: The living one is ended.
        cost: Cost of it alone.
        uses: Modules (``mod:M/X``), packages (``pkg:H/P==V``) and managers (``mgr:M``) that must be
            there for it, and are not.
    """

    place: str
    is_made: bool
    is_ended: bool
    cost: float
    uses: frozenset[str] = frozenset()

    @property
    def is_there(self) -> bool:
        """Return whether it is there at the end."""
        return self.place != var.ABSENT


class Assignments:
    """The possible assignments of the components of one model."""

    def __init__(self, model: Model) -> None:
        self._model = model

    def of(self, unit: ComponentVariable) -> list[Assignment]:
        """Return what may become of a component, alone; the least change first."""
        return [assignment for assignment in self._all(unit) if assignment.cost < inf]

    def _all(self, unit: ComponentVariable) -> Iterator[Assignment]:
        model = self._model
        now = model.now(f"cmp:{unit.name}")
        lives = now != var.ABSENT
        if lives and model.allows(f"cmp:{unit.name}", now):
            yield Assignment(now, False, False, self._staying(unit))
        if model.allows(f"cmp:{unit.name}", var.ABSENT) and self._allows_usual(unit.name):
            yield Assignment(var.ABSENT, False, lives, self._ending(unit) if lives else 0)
        if unit.why_not:
            return
        for place in unit.places:
            if model.allows(f"cmp:{unit.name}", place):
                cost = self._making(unit, place) + (self._ending(unit) if lives else 0)
                yield Assignment(place, True, lives, cost, self._uses(unit, place))

    def _allows_usual(self, name: str) -> bool:
        """Return whether the desired state of a component can hold without it."""
        model = self._model
        keys = (f"cfg:{key}" for key in model.keys_of[name])
        return model.allows(f"act:{name}", var.INACTIVE) and all(
            model.allows(key, model.usual(key)) for key in keys
        )

    def _staying(self, unit: ComponentVariable) -> float:
        model, name = self._model, unit.name
        cost, is_cold = 0.0, False
        for key in model.keys_of[name]:
            if not model.allows(f"cfg:{key}", model.now(f"cfg:{key}")):
                if model.keys[key].is_fixed:
                    return inf
                cost += model.cost("configure", key)
                is_cold = is_cold or not model.keys[key].is_hot
        now = model.now(f"act:{name}")
        return cost + self._turning(name, now, is_rest_needed=is_cold)

    def _turning(self, name: str, now: str, *, is_rest_needed: bool) -> float:
        """Return what it costs to come from one state to a desired one, by rest if need be."""
        model = self._model
        if not is_rest_needed and model.allows(f"act:{name}", now):
            return 0
        cost = {var.ACTIVE: model.cost("deactivate", name), var.ERROR: model.cost("reset", name)}
        to_rest = cost.get(now, 0)
        if model.allows(f"act:{name}", var.INACTIVE):
            return to_rest
        return (
            to_rest + model.cost("activate", name)
            if model.allows(f"act:{name}", var.ACTIVE)
            else inf
        )

    def _ending(self, unit: ComponentVariable) -> float:
        model = self._model
        is_active = model.now(f"act:{unit.name}") == var.ACTIVE
        rest = model.cost("deactivate", unit.name) if is_active else 0
        return rest + model.cost("delete", unit.name)

    def _making(self, unit: ComponentVariable, place: str) -> float:
        model, name = self._model, unit.name
        needed = model.needed_module(unit, place)
        manager = model.managers.get(manager_of(place), frozenset())
        if manager_of(place) not in model.managers:
            return inf
        is_found = not unit.module or manager is None or unit.module in manager
        if not is_found and not (needed and model.now(f"mod:{needed}") == var.LOADED):
            return inf
        if needed and is_inproc(place) and not model.allows(f"mod:{needed}", var.LOADED):
            return inf
        if not model.allows(f"mgr:{manager_of(place)}", var.UP):
            return inf
        package = model.needed_package(unit, place)
        if package and not model.allows(f"pkg:{package}", var.INSTALLED):
            return inf
        cost = model.cost("create" if is_inproc(place) else "create_slave", name)
        for key in model.keys_of[name]:
            if not model.allows(f"cfg:{key}", model.usual(f"cfg:{key}")):
                if model.keys[key].is_fixed:
                    return inf
                cost += model.cost("configure", key)
        return cost + self._turning(name, var.INACTIVE, is_rest_needed=False)

    def _uses(self, unit: ComponentVariable, place: str) -> frozenset[str]:
        model = self._model
        needed = model.needed_module(unit, place)
        package = model.needed_package(unit, place)
        uses = [f"mgr:{manager_of(place)}", f"mod:{needed}", f"pkg:{package}"]
        there = (var.UP, var.LOADED, var.INSTALLED)
        return frozenset(use for use in uses if use[4:] and model.now(use) not in there)

    # with others

    def connector(self, name: str, assignments: tuple[Assignment, ...]) -> float:
        """Return what a connection costs when this becomes of its ends."""
        model = self._model
        variable = f"con:{name}"
        now = model.now(variable)
        may_be = now != var.NO and model.allows(variable, now)
        is_broken = any(assignment.is_ended for assignment in assignments)
        if may_be and not is_broken:
            return 0
        to_no = model.cost("disconnect", name) if now != var.NO else 0
        if model.allows(variable, var.NO):
            return to_no
        can_be = (
            all(assignment.is_there for assignment in assignments)
            and not model.connectors[name].why_not
        )
        can_be = can_be and model.allows(variable, var.YES)
        return to_no + model.cost("connect", name) if can_be else inf

    def whole(self, member: Assignment, whole: Assignment, *, lives: bool) -> float:
        """Return what it costs that one is composed of the other: nothing, or it cannot be."""
        if lives and member.is_ended and not whole.is_ended:
            return inf
        return inf if whole.is_made and not member.is_there else 0
