"""Choice of places: the cheapest ones that meet all requirements, or why there are none.

Pure code: what hosts have is an argument. Components that share a process are placed as one. The
search tries every combination, cheapest first, with the cost of all that is left as bound; of
equally cheap ones it takes that with the fewest connections between hosts, then the places that
stand first. A system of many components is settled by the best of so many tries, and the choice
tells by how much it may be too dear.

See decision 81.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import accumulate
from math import inf

from rtkit.deployment.placement.requirements import (
    NOTHING_REQUIRED,
    DevicePolicy,
    Requirements,
    process_groups,
)
from rtkit.fast_dataclass import dataclass, field

_TRIES = 20_000
"""How many places are tried at least before the best choice so far is taken."""
_TRIES_EACH = 50
"""How many more for each component."""

_DIGITS = 6
"""Decimals to which costs count: their sums differ by the order of summation."""

Extras = Mapping[str, float]
"""Costs that are paid once for all who need something, by its name."""


@dataclass(frozen=True, slots=True)
class PlacedComponent:
    """A component whose place is to be chosen, or checked.

    Attributes:
        required: Its requirements.
        stated: The place that its path names; empty where that is open.
        home: Where it lives; empty for nowhere.
        making: Cost of making it.
        leaving: Further cost of its end at its home.
        is_required: The system makes no sense without it.
    """

    name: str
    required: Requirements = NOTHING_REQUIRED
    stated: str = ""
    home: str = ""
    making: float = 1.0
    leaving: float = 0.0
    is_required: bool = True


@dataclass(frozen=True, slots=True)
class PlaceCandidate:
    """A manager in which components may be made, and what its host has.

    Attributes:
        place: The manager as paths begin: ``localhost``, ``localhost/m1.mgr``, ``robot1``.
        tags: Words that its host has.
        memory: Free memory [bytes]; infinite where it is not known.
        devices: Of the required devices those that are there.
        why_not: Why nothing can be made there, which counts for what does not live there.
        lacks: By component, why it cannot be made there.
        extras: By component, what has to be there for it and is not, with its cost.
    """

    place: str
    tags: frozenset[str] = frozenset()
    memory: float = inf
    devices: frozenset[str] = frozenset()
    why_not: str = ""
    lacks: Mapping[str, str] = field(default_factory=dict)
    extras: Mapping[str, Extras] = field(default_factory=dict)

    @property
    def host(self) -> str:
        """Return its host."""
        return self.place.partition("/")[0]

    @property
    def is_usual(self) -> bool:
        """Return whether it is chosen where nothing names it."""
        return "/" not in self.place


@dataclass(frozen=True, slots=True)
class PlacementProblem:
    """Components, and where they may be.

    Attributes:
        links: Pairs of components that are connected.
    """

    components: tuple[PlacedComponent, ...]
    candidates: tuple[PlaceCandidate, ...]
    links: tuple[tuple[str, str], ...] = ()

    def without(self, names: Collection[str]) -> PlacementProblem:
        """Return the same without some components, and what is required about them."""
        left = tuple(each for each in self.components if each.name not in names)
        links = tuple(each for each in self.links if not {*each} & {*names})
        return PlacementProblem(left, self.candidates, links)


@dataclass(frozen=True, slots=True)
class PlacementChoice:
    """The places of all components.

    Attributes:
        places: By component, the place of its candidate.
        cost: Cost of making, or moving, the components there.
        crossings: Connections between hosts.
        gap: By how much a cheaper choice could be cheaper at most.
    """

    places: Mapping[str, str]
    cost: float = 0.0
    crossings: int = 0
    gap: float = 0.0


def misfits(component: PlacedComponent, candidate: PlaceCandidate) -> Iterator[tuple[str, str]]:
    """Yield what speaks against a place of one component: which requirement, and why."""
    required, is_home = component.required, component.home == candidate.place
    if candidate.why_not and not is_home:
        yield "", candidate.why_not
        return
    if component.name in candidate.lacks and not is_home:
        yield "", candidate.lacks[component.name]
    if required.hosts and candidate.host not in required.hosts:
        yield "hosts", f"not one of {', '.join(required.hosts)}"
        return
    missing = [each for each in required.tags if each not in candidate.tags]
    if missing:
        yield "tags", f"lacks tag {', '.join(missing)}"
    if not is_home and required.memory > candidate.memory:
        free, asked = int(candidate.memory) >> 20, required.memory >> 20
        yield "memory", f"{free} MiB free, {asked} asked"
    may_lack = is_home and required.device_policy is DevicePolicy.KEEP
    absent = [each for each in required.devices if each not in candidate.devices]
    if absent and not may_lack:
        yield "devices", f"no {', '.join(absent)}"


def choose(problem: PlacementProblem) -> PlacementChoice | None:
    """Return the cheapest choice; None where there is none."""
    return _Search(problem).run()


class _Option:
    """Place of a group of components that share a process: its cost there, and what it takes."""

    def __init__(
        self, group: Sequence[PlacedComponent], candidate: PlaceCandidate, rank: int
    ) -> None:
        coming = [each for each in group if each.home != candidate.place]
        self.place, self.host, self.rank = candidate.place, candidate.host, rank
        self.cost = sum(c.making + (c.leaving if c.home else 0.0) for c in coming)
        self.memory = sum(each.required.memory for each in coming)
        self.extras: dict[str, float] = {}
        for each in coming:
            self.extras.update(candidate.extras.get(each.name, {}))


class _Search:
    """Depth-first search with a bound; groups with the fewest places come first."""

    def __init__(self, problem: PlacementProblem) -> None:
        known = {each.name: each for each in problem.components}
        required = {name: each.required for name, each in known.items()}
        names = [[n for n in group if n in known] for group in process_groups(required)]
        candidates = [*enumerate(problem.candidates)]
        groups = []
        for each in filter(None, names):
            group = [known[name] for name in each]
            groups.append((each, [_Option(group, c, n) for n, c in candidates if _fits(group, c)]))
        groups.sort(key=lambda each: len(each[1]))
        self._names = [each for each, _ in groups]
        self._options = [options for _, options in groups]
        number = {name: n for n, each in enumerate(self._names) for name in each}
        self._near = _pairs(number, problem.links)
        apart = ((n, each) for n, own in required.items() for each in own.apart if each in known)
        self._apart = _pairs(number, apart)
        self._is_split = any(
            number[n] == number[each] for n, own in required.items() for each in own.apart
            if each in known
        )  # fmt: skip
        self._free = {c.host: c.memory for c in problem.candidates}
        least = [min((each.cost for each in own), default=inf) for own in self._options]
        self._rest = [*accumulate(reversed(least), initial=0.0)][::-1]
        once = max((_least_extras(each) for each in self._options), default=0.0)
        self._least = round(self._rest[0] + once, _DIGITS)
        self._best: tuple[float, int] = (inf, 0)
        self._found: list[_Option] = []
        self._chosen: list[_Option] = []
        self._taken: Counter[str] = Counter()
        self._paid: Counter[str] = Counter()

    def run(self) -> PlacementChoice | None:
        """Search; the best choice so far counts when the tries are used up."""
        if self._is_split or not all(self._options):
            return None
        count = len(self._options)
        if not count:
            return PlacementChoice({})
        self._best, self._found = (inf, 0), []
        is_whole = self._descend(_TRIES + _TRIES_EACH * count)
        if not self._found:
            return None
        places = {
            name: option.place
            for names, option in zip(self._names, self._found, strict=True)
            for name in names
        }
        gap = 0.0 if is_whole else max(0.0, self._best[0] - self._least)
        return PlacementChoice(places, *self._best, gap)

    def _descend(self, tries: int) -> bool:
        """Try places; return whether no untried one can be better."""
        stack = [self._sorted((0.0, 0))]
        while stack and tries and self._best > (self._least, 0):
            tries -= 1
            so_far, option = next(stack[-1], (self._best, None))
            depth = len(self._chosen) + 1
            bound = (round(so_far[0] + self._rest[depth], _DIGITS), so_far[1])
            if option is None or bound >= self._best:  # and so is all that comes after it
                stack.pop()
                if self._chosen:
                    self._leave()
            elif depth == len(self._options):
                self._best, self._found = so_far, [*self._chosen, option]
            else:
                self._enter(option)
                stack.append(self._sorted(so_far))
        return bool(tries)

    def _enter(self, option: _Option) -> None:
        self._chosen.append(option)
        self._taken[option.host] += option.memory
        self._paid.update(option.extras.keys())

    def _leave(self) -> None:
        option = self._chosen.pop()
        self._taken[option.host] -= option.memory
        self._paid.subtract(option.extras.keys())

    def _sorted(self, so_far: tuple[float, int]) -> Iterator[tuple[tuple[float, int], _Option]]:
        """Return the places of the next group with the costs up to there, the cheapest first."""
        chosen, number = self._chosen, len(self._chosen)
        apart = {chosen[n].host for n in self._apart[number] if n < number}
        near = [chosen[n].host for n in self._near[number] if n < number]
        found = []
        for option in self._options[number]:
            memory = self._taken[option.host] + option.memory
            if option.host in apart or (option.memory and memory > self._free[option.host]):
                continue
            extra = sum(cost for key, cost in option.extras.items() if not self._paid[key])
            cost = round(so_far[0] + option.cost + extra, _DIGITS)
            crossings = so_far[1] + sum(host != option.host for host in near)
            found.append(((cost, crossings), option))
        return iter(sorted(found, key=lambda each: (each[0], each[1].rank)))


def _fits(group: Sequence[PlacedComponent], candidate: PlaceCandidate) -> bool:
    stated = {each.stated for each in group if each.stated}
    is_open = candidate.is_usual or any(each.home == candidate.place for each in group)
    if stated != {candidate.place} if stated else not is_open:
        return False
    return not any(reason for each in group for reason in misfits(each, candidate))


def _pairs(number: Mapping[str, int], names: Iterable[tuple[str, str]]) -> list[list[int]]:
    """Return the groups that each group has to do with; once for each pair of names."""
    found: list[list[int]] = [[] for _ in range(max(number.values(), default=-1) + 1)]
    for one, other in names:
        if one in number and other in number and number[one] != number[other]:
            found[number[one]].append(number[other])
            found[number[other]].append(number[one])
    return found


def _least_extras(options: Sequence[_Option]) -> float:
    return min((sum(each.extras.values()) for each in options), default=0.0)
