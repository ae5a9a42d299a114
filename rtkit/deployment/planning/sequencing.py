"""Sequences a plan: turns assignments into steps in a valid order, with parallel layers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise

from rtkit.deployment.planning import model as var
from rtkit.deployment.planning.assignment import Assignment
from rtkit.deployment.planning.model import Model, Wish, manager_of
from rtkit.deployment.planning.operators import Operator, Operators
from rtkit.planner import Touch, predecessors

_LAST_OF_ALL = 1 << 30


def sequence(
    model: Model, assignments: Mapping[str, Assignment], ranks: Mapping[str, int]
) -> list[Operator]:
    """Return the steps, first what rests and ends, then what is made, joined, set, activated.

    `ranks` orders the activation of components: those of lower numbers.
    """
    return list(_Emitting(model, assignments, ranks).run())


def order(moves: Iterable[Operator], ranks: Mapping[str, int]) -> list[set[int]]:
    """Return for each step the earlier ones that must be done before it."""
    steps = list(moves)
    before = predecessors(
        Touch(
            frozenset(need.variable for need in move.needs) | frozenset(move.heeds),
            frozenset(variable for variable, _ in move.changes),
        )
        for move in steps
    )
    for kind, sign in (("activate", 1), ("deactivate", -1)):
        _keep_ranks(steps, kind, {name: sign * rank for name, rank in ranks.items()}, before)
    return before


def _keep_ranks(
    steps: list[Operator], kind: str, ranks: Mapping[str, int], before: list[set[int]]
) -> None:
    """Have those of one rank wait for those of the next lower one."""
    by_rank: dict[int, list[int]] = {}
    for place, move in enumerate(steps):
        if move.kind == kind and move.subject in ranks:
            by_rank.setdefault(ranks[move.subject], []).append(place)
    groups = [by_rank[rank] for rank in sorted(by_rank)]
    for first, then in pairwise(groups):
        for place in then:
            before[place].update(first)


class _Emitting:
    def __init__(
        self, model: Model, assignments: Mapping[str, Assignment], ranks: Mapping[str, int]
    ) -> None:
        self._model = model
        self._moves = Operators(model)
        self._assignments = assignments
        self._ranks = ranks
        self._made = [name for name, assignment in assignments.items() if assignment.is_made]
        self._ended = [name for name, assignment in assignments.items() if assignment.is_ended]
        self._configured = list(self._configurations())
        self._packages = [each for each in model.desired if each.startswith("pkg:")]

    def run(self) -> Iterator[Operator]:
        model, moves = self._model, self._moves
        yield from self._rests()
        remade = list(self._disconnections())
        yield from remade
        yield from (moves.delete(name) for name in self._by_depth(self._ended, is_reversed=True))
        modules = [each[4:] for each in model.desired if each.startswith("mod:")]
        unwished = [m for m in modules if not model.allows(f"mod:{m}", var.LOADED)]
        needed = self._needed_modules(modules)
        yield from (moves.install(name) for name in self._needed_packages())
        yield from (moves.start_manager(name) for name in self._needed_managers(needed))
        yield from (moves.load(module) for module in needed)
        yield from (
            moves.create(name, self._assignments[name].place) for name in self._by_depth(self._made)
        )
        yield from (
            moves.unload(m) for m in unwished if m in needed or model.now(f"mod:{m}") == var.LOADED
        )
        yield from (moves.uninstall(name) for name in self._surplus_packages())
        yield from (move for _, move in self._configured)
        broken = {move.subject for move in remade}
        yield from (
            moves.connect(name)
            for name in model.connectors
            if (name in broken or model.now(f"con:{name}") == var.NO)
            and not model.allows(f"con:{name}", var.NO)
        )
        rising = [name for name in self._assignments if self._is_to_rise(name)]
        rising.sort(key=lambda name: self._ranks.get(name, _LAST_OF_ALL))
        yield from (moves.activate(name) for name in rising)

    def _rests(self) -> Iterator[Operator]:
        model, moves = self._model, self._moves
        to_rest = [name for name in reversed([*self._assignments]) if self._is_to_rest(name)]
        to_rest.sort(key=lambda name: -self._ranks.get(name, _LAST_OF_ALL))
        for name in to_rest:
            if model.now(f"act:{name}") == var.ACTIVE:
                yield moves.deactivate(name)
            elif not self._assignments[name].is_ended:
                yield moves.reset(name)

    def _is_to_rest(self, name: str) -> bool:
        model = self._model
        now = model.now(f"act:{name}")
        if now not in (var.ACTIVE, var.ERROR):
            return False
        if self._assignments[name].is_ended or not model.allows(f"act:{name}", now):
            return True
        return any(
            owner == name and not model.keys[move.subject].is_hot
            for owner, move in self._configured
        )

    def _is_to_rise(self, name: str) -> bool:
        model, assignment = self._model, self._assignments[name]
        if not assignment.is_there or model.allows(f"act:{name}", var.INACTIVE):
            return False
        return (
            assignment.is_made or self._is_to_rest(name) or model.now(f"act:{name}") == var.INACTIVE
        )

    def _configurations(self) -> Iterator[tuple[str, Operator]]:
        model = self._model
        for name, assignment in self._assignments.items():
            for key in model.keys_of[name] if assignment.is_there else ():
                variable = f"cfg:{key}"
                value = model.usual(variable) if assignment.is_made else model.now(variable)
                if not model.allows(variable, value):
                    yield name, self._moves.configure(key, _first(model.desired[variable]))

    def _disconnections(self) -> Iterator[Operator]:
        model = self._model
        ended = set(self._ended)
        for name, connector in model.connectors.items():
            now = model.now(f"con:{name}")
            is_broken = not ended.isdisjoint(connector.ends) or not model.allows(f"con:{name}", now)
            if now != var.NO and is_broken:
                yield self._moves.disconnect(name)

    def _needed_modules(self, wished: Iterable[str]) -> list[str]:
        model = self._model
        needed = [
            model.needed_module(model.units[name], self._assignments[name].place)
            for name in self._made
        ]
        needed += [module for module in wished if not model.allows(f"mod:{module}", var.ABSENT)]
        return [m for m in dict.fromkeys(needed) if m and model.now(f"mod:{m}") == var.ABSENT]

    def _needed_packages(self) -> list[str]:
        model = self._model
        needed = [
            model.needed_package(model.units[name], self._assignments[name].place)
            for name in self._made
        ]
        needed += [v[4:] for v in self._packages if not model.allows(v, var.ABSENT)]
        return [p for p in dict.fromkeys(needed) if p and model.now(f"pkg:{p}") == var.ABSENT]

    def _surplus_packages(self) -> list[str]:
        model = self._model
        unwished = [v for v in self._packages if not model.allows(v, var.INSTALLED)]
        return [v[4:] for v in unwished if model.now(v) == var.INSTALLED]

    def _needed_managers(self, modules: Iterable[str]) -> list[str]:
        model = self._model
        needed = [module.partition("/")[0] for module in modules]
        needed += [manager_of(self._assignments[name].place) for name in self._made]
        needed += [name for name in model.managers if not model.allows(f"mgr:{name}", var.DOWN)]
        return [name for name in dict.fromkeys(needed) if model.now(f"mgr:{name}") != var.UP]

    def _by_depth(self, names: list[str], *, is_reversed: bool = False) -> list[str]:
        """Return components in order, who is composed of others behind these; or the reverse."""
        model = self._model
        depths: dict[str, int] = {}

        def depth(name: str, above: frozenset[str]) -> int:
            if name not in depths:
                unit = model.units.get(name)
                members = set(unit.members) - above if unit is not None else set()
                depths[name] = 1 + max((depth(m, above | {name}) for m in members), default=0)
            return depths[name]

        return sorted(names, key=lambda name: depth(name, frozenset()), reverse=is_reversed)


def _first(desired: Wish) -> str:
    return desired if isinstance(desired, str) else desired[0]
