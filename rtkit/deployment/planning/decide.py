"""Decides the assignment of each component, so that the whole costs least.

First it strikes out each assignment that is dearer than another whatever the neighbours do
(Goldstein's criterion); mostly one is left. The open choices fall into independent clusters, and
each cluster is searched on its own. So independent components never multiply.

See decision 22.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from math import inf
from typing import NamedTuple

from rtkit.deployment.planning.assignment import Assignment, Assignments
from rtkit.deployment.planning.model import (
    ABSENT,
    DOWN,
    LOADED,
    UP,
    Model,
    is_inproc,
    manager_of,
)
from rtkit.errors import Impossible, LimitReached
from rtkit.fast_dataclass import dataclass
from rtkit.planner import Command, Condition, Limits, Problem, State, plan

SEARCH_LIMIT = 20_000
"""States that may be expanded before what is left settles for less, a little for each cluster."""
_ROUNDS = 10
"""How often a choice that is not proved to be the cheapest is gone through for a better one."""


class Stuck(Impossible):
    """Some components cannot be as desired.

    Attributes:
        units: Their names.
    """

    def __init__(self, units: Iterable[str]) -> None:
        self.units = tuple(units)
        super().__init__(f"cannot be as wished: {', '.join(self.units)}")


class Pair(NamedTuple):
    """Joint cost of two components (or of one with itself)."""

    one: str
    other: str
    cost: Callable[[Assignment, Assignment], float]


@dataclass(frozen=True, slots=True)
class Decision:
    """The assignment of each component.

    Attributes:
        gap: By how much it may be dearer than the cheapest; 0 when that is proved.
        looked_at: Combinations that were tried.
    """

    assignments: Mapping[str, Assignment]
    gap: float
    looked_at: int


def decide(model: Model) -> Decision:
    """Return the cheapest assignments of all components together.

    Raises:
        Stuck: There is none; names components of which one must be otherwise.
    """
    return _Deciding(model).run()


class _Deciding:
    def __init__(self, model: Model) -> None:
        self._model = model
        self._assignments = Assignments(model)
        self._left = {name: self._assignments.of(unit) for name, unit in model.units.items()}
        self._pairs: dict[str, list[Pair]] = {name: [] for name in model.units}
        self._known: dict[tuple[int, Assignment, Assignment], float] = {}
        for pair in self._all_pairs():
            self._pairs[pair.one].append(pair)
            if pair.other != pair.one:
                turned = Pair(pair.other, pair.one, lambda a, b, c=pair.cost: c(b, a))  # type: ignore[misc]
                self._pairs[pair.other].append(turned)
        self._users: dict[str, set[str]] = {}
        for name, assignments in self._left.items():
            for use in frozenset().union(*(assignment.uses for assignment in assignments)):
                self._users.setdefault(use, set()).add(name)
        self._paid = {use for use in self._users if not self._is_open(use)}
        self._looked_at = 0

    def run(self) -> Decision:
        self._hold_modules()
        self._hold_packages()
        self._strike_out()
        gap = 0.0
        for cluster in self._clusters():
            gap += self._settle(cluster)
        return Decision(
            {n: assignments[0] for n, assignments in self._left.items()}, gap, self._looked_at
        )

    def _all_pairs(self) -> Iterator[Pair]:
        model, assignments = self._model, self._assignments
        for name, connector in model.connectors.items():
            one, other = connector.ends[0], connector.ends[-1]
            yield Pair(one, other, lambda a, b, name=name: assignments.connector(name, (a, b)))  # type: ignore[misc]
        for unit in model.units.values():
            lives = model.now(f"cmp:{unit.name}") != ABSENT
            for member in unit.members:
                if member in model.units:
                    yield Pair(
                        member,
                        unit.name,
                        lambda a, b, lives=lives: assignments.whole(a, b, lives=lives),  # type: ignore[misc]
                    )

    def _is_open(self, use: str) -> bool:
        """Return whether it is open if somebody must pay for a missing module or manager."""
        return self._model.allows(use, self._model.now(use)) and (
            not use.startswith("mgr:") or not self._is_started(use[4:])
        )

    def _is_started(self, manager: str) -> bool:
        wished = (each for each in self._model.desired if each.startswith(f"mod:{manager}/"))
        return any(not self._model.allows(each, self._model.now(each)) for each in wished)

    def _hold_modules(self) -> None:
        """Have nobody stay in a process from which his module is to be unloaded."""
        for variable in [each for each in self._model.desired if each.startswith("mod:")]:
            if self._model.allows(variable, LOADED):
                continue
            manager, _, module = variable[4:].partition("/")
            for name, unit in self._model.units.items():
                if unit.module == module:
                    self._left[name] = [
                        assignment
                        for assignment in self._left[name]
                        if not (
                            is_inproc(assignment.place) and manager_of(assignment.place) == manager
                        )
                    ]

    def _hold_packages(self) -> None:
        """Have nobody stay on a host from which his package is to be removed."""
        model = self._model
        wished = [each for each in model.desired if each.startswith("pkg:")]
        changed = [each for each in wished if not model.allows(each, model.now(each))]
        gone = {each[4:] for each in changed if model.allows(each, ABSENT)}
        for name, unit in model.units.items() if gone else ():
            self._left[name] = [
                each
                for each in self._left[name]
                if not (each.is_there and model.needed_package(unit, each.place) in gone)
            ]

    # striking out

    def _strike_out(self) -> None:
        todo = dict.fromkeys(self._left)
        while todo:
            name, _ = todo.popitem()
            before = len(self._left[name])
            self._left[name] = [f for f in self._left[name] if self._can_be(name, f)]
            if not self._left[name]:
                raise Stuck([name, *self._neighbours(name)])
            self._strike_dearer(name)
            if len(self._left[name]) < before:
                todo.update(dict.fromkeys(self._neighbours(name)))
            certain = frozenset.intersection(*(assignment.uses for assignment in self._left[name]))
            for use in certain - self._paid:
                self._paid.add(use)
                todo.update(dict.fromkeys(self._users[use] - {name}))

    def _neighbours(self, name: str) -> list[str]:
        return [p.other for p in self._pairs[name] if p.other != name]

    def _can_be(self, name: str, assignment: Assignment) -> bool:
        return all(
            any(
                self._cost(pair, assignment, other) < inf
                for other in self._others(pair, assignment)
            )
            for pair in self._pairs[name]
        )

    def _others(self, pair: Pair, assignment: Assignment) -> list[Assignment]:
        return [assignment] if pair.one == pair.other else self._left[pair.other]

    def _cost(self, pair: Pair, one: Assignment, other: Assignment) -> float:
        key = (id(pair), one, other)
        if key not in self._known:
            self._known[key] = pair.cost(one, other)
        return self._known[key]

    def _strike_dearer(self, name: str) -> None:
        left = self._left[name]
        for worse in reversed(list(left)):
            if any(each is not worse and self._is_as_good(name, each, worse) for each in left):
                left.remove(worse)

    def _is_as_good(self, name: str, better: Assignment, worse: Assignment) -> bool:
        """Return whether one assignment costs no more than another, whatever the others become."""
        paid = sum(self._price(use) for use in better.uses - worse.uses - self._paid)
        more = better.cost - worse.cost + paid
        for pair in self._pairs[name]:
            if pair.one == pair.other:
                more += self._cost(pair, better, better) - self._cost(pair, worse, worse)
            else:
                more += max(self._differences(pair, better, worse), default=0)
            if more == inf:
                return False
        return more <= 0

    def _differences(self, pair: Pair, better: Assignment, worse: Assignment) -> Iterator[float]:
        for other in self._left[pair.other]:
            one, two = self._cost(pair, better, other), self._cost(pair, worse, other)
            if two < inf:
                yield one - two

    def _price(self, use: str) -> float:
        if use.startswith("pkg:"):
            return self._model.cost("install", use[4:])
        kind = "start_manager" if use.startswith("mgr:") else "load"
        is_to_go = kind == "load" and not self._model.allows(use, LOADED)
        after = self._model.cost("unload", use[4:]) if is_to_go else 0
        return self._model.cost(kind, use[4:]) + after

    # searching

    def _clusters(self) -> list[list[str]]:
        """Return who is still open, together with whom his choice has to do."""
        open_ = {name for name, assignments in self._left.items() if len(assignments) > 1}
        clusters = []
        while open_:
            cluster, todo = [], [min(open_)]
            open_ -= set(todo)
            while todo:
                name = todo.pop()
                cluster.append(name)
                uses = frozenset().union(*(f.uses for f in self._left[name])) - self._paid
                near = {pair.other for pair in self._pairs[name] if self._matters(pair)}
                near.update(*(self._users[use] for use in uses))
                todo += sorted(near & open_)
                open_ -= near
            clusters.append(cluster)
        return clusters

    def _matters(self, pair: Pair) -> bool:
        """Return whether what two cost together has to do with what becomes of them."""
        ones, others = self._left[pair.one], self._left[pair.other]
        first = self._cost(pair, ones[0], others[0])
        return any(self._cost(pair, one, other) != first for one in ones for other in others)

    def _settle(self, cluster: list[str]) -> float:
        """Settle one cluster; return by how much that may be dearer than need be."""
        search = _Cluster(cluster, self._left, self)
        most = max(SEARCH_LIMIT - self._looked_at, SEARCH_LIMIT // 100)
        try:
            found = plan(search.problem, search.heuristic, Limits(states=most))
        except LimitReached:
            self._looked_at += most
            choice, gap = search.good_enough()
        except Impossible as error:
            raise Stuck(cluster) from error
        else:
            self._looked_at += found.statistics.expanded
            choice, gap = found.steps[-1].after, 0.0
        for name, number in zip(cluster, choice, strict=True):
            self._left[name] = [self._left[name][number]]
        return gap

    def marginal(
        self, name: str, assignment: Assignment, settled: Mapping[str, Assignment]
    ) -> float:
        """Return what an assignment costs beside what is settled already."""
        used = frozenset().union(*(each.uses for each in settled.values()))
        cost = assignment.cost + sum(
            self._price(use) for use in assignment.uses - self._paid - used
        )
        for pair in self._pairs[name]:
            if pair.other == name:
                cost += self._cost(pair, assignment, assignment)
            elif pair.other in settled:
                cost += self._cost(pair, assignment, settled[pair.other])
            elif len(self._left[pair.other]) == 1:
                cost += self._cost(pair, assignment, self._left[pair.other][0])
        return cost

    def least(
        self, name: str, assignment: Assignment, before: Mapping[str, list[Assignment]]
    ) -> float:
        """Return what an assignment costs at least, beside any of those before it."""
        cost = assignment.cost
        for pair in self._pairs[name]:
            if pair.other in before or len(self._left[pair.other]) == 1 or pair.other == name:
                others = self._others(pair, assignment)
                cost += min(self._cost(pair, assignment, other) for other in others)
        return cost


class _Cluster:
    """The choices of one cluster as a problem: one component after the other is settled.

    A state has the number of each chosen assignment. Each choice costs 1 more than it does, as
    commands cost something; all ways have the same number of choices.
    """

    def __init__(
        self, names: list[str], left: Mapping[str, list[Assignment]], deciding: _Deciding
    ) -> None:
        self._names = names
        self._assignments = [left[name] for name in names]
        self._marginal = deciding.marginal
        self._least = [0.0]
        for number in reversed(range(len(names))):
            before = dict(zip(names[:number], self._assignments[:number], strict=True))
            left_here = self._assignments[number]
            cost = min(deciding.least(names[number], each, before) for each in left_here)
            self._least.append(self._least[-1] + 1 + cost)
        self._least.reverse()
        variables = {name: [None, *range(len(left[name]))] for name in names}
        self.problem = Problem(
            variables,
            (None,) * len(names),
            lambda state: state[-1] is not None,
            self._choices,
            lambda command, before, _: 1 + self._cost(before, command.parameters[0]),
        )

    def heuristic(self, state: State) -> float:
        """Return what is left to be paid at least."""
        return self._least[_settled(state)]

    def good_enough(self) -> tuple[State, float]:
        """Return a choice that no other choice for one component betters; and its gap.

        Raises:
            Stuck: None was found; that does not prove that there is none.
        """
        best = min((self._bettered(s) for s in self._guesses()), key=self._whole)
        cost = self._whole(best)
        if cost == inf:
            raise Stuck(self._names)
        return best, cost + len(self._names) - self._least[0]

    def _guesses(self) -> Iterator[State]:
        state = self.problem.start
        for assignments in self._assignments:
            prices = [self._cost(state, number) for number in range(len(assignments))]
            state = _with(state, prices.index(min(prices)))
        yield state
        costs = [
            [assignment.cost for assignment in assignments] for assignments in self._assignments
        ]
        yield tuple(each.index(min(each)) for each in costs)

    def _bettered(self, state: State) -> State:
        for _ in range(_ROUNDS):
            before = state
            for place, assignments in enumerate(self._assignments):
                settled = {
                    n: f[c] for n, f, c in zip(self._names, self._assignments, state, strict=True)
                }
                del settled[self._names[place]]
                costs = [
                    self._marginal(self._names[place], assignment, settled)
                    for assignment in assignments
                ]
                state = (*state[:place], costs.index(min(costs)), *state[place + 1 :])
            if state == before:
                break
        return state

    def _whole(self, state: State) -> float:
        empty = [None] * len(state)
        return sum(self._cost((*state[:n], *empty[n:]), each) for n, each in enumerate(state))

    def _choices(self, state: State) -> Iterator[Command]:
        for number in range(len(self._assignments[_settled(state)])):
            possible = Condition("fits", lambda s, n=number: self._cost(s, n) < inf)  # type: ignore[misc]
            yield Command(
                "choose",
                lambda s, n=number: _with(s, n),  # type: ignore[misc]
                (possible,),
                (number,),
            )

    def _cost(self, state: State, number: int) -> float:
        count = _settled(state)
        chosen = zip(self._names[:count], self._assignments[:count], state[:count], strict=True)
        settled = {name: assignments[each] for name, assignments, each in chosen}
        return self._marginal(self._names[count], self._assignments[count][number], settled)


def _settled(state: State) -> int:
    return next((n for n, each in enumerate(state) if each is None), len(state))


def _with(state: State, number: int) -> State:
    count = _settled(state)
    return (*state[:count], number, *state[count + 1 :])


def check_managers(model: Model) -> None:
    """Refuse desired managers and modules that nothing can bring about.

    Raises:
        Impossible: Names the desired value.
    """
    for variable, desired in model.desired.items():
        kind, _, name = variable.partition(":")
        if kind == "mgr" and model.now(variable) == UP and not model.allows(variable, UP):
            raise Impossible(f"{variable}={desired}: nothing ends a manager")
        if kind == "mod" and not model.allows(variable, model.now(variable)):
            manager, _, module = name.partition("/")
            found = model.managers.get(manager, frozenset())
            is_found = found is None or module in found
            can_be = is_found and not (
                model.now(f"mgr:{manager}") == DOWN and not model.allows(f"mgr:{manager}", UP)
            )
            if model.allows(variable, LOADED) and not can_be:
                raise Impossible(f"{variable}={desired}: {manager} does not find module {module}")
