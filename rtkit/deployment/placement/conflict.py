"""Conflicts: a minimal set of requirements that no places meet together, and words for it.

Nothing of such a set can be left out: without any one of them there are places for the components
that it names.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, TypeVar

from rtkit.deployment.placement.choice import (
    PlaceCandidate,
    PlacedComponent,
    PlacementChoice,
    PlacementProblem,
    choose,
    misfits,
)
from rtkit.deployment.placement.requirements import NOTHING_REQUIRED, Requirements
from rtkit.errors import Impossible
from rtkit.fast_dataclass import replace

T = TypeVar("T")
_TOGETHER = "{} is to be in the process of {}"
_APART = "{} is not to be on the host of {}"
_KINDS = ("hosts", "tags", "memory", "devices", "with_", "apart")


class Conflict(NamedTuple):
    """Requirements that exclude each other.

    Attributes:
        requirements: Component and kind of each; none for one that can be nowhere whatever it
            requires.
        problem: The components that are concerned, with these requirements only.
    """

    requirements: tuple[tuple[str, str], ...]
    problem: PlacementProblem


def placed(problem: PlacementProblem) -> tuple[PlacementChoice, dict[str, str]]:
    """Return the cheapest places, and why components that are not required have none.

    Raises:
        Impossible: Required ones have none; names a minimal set of reasons.
    """
    lacks: dict[str, str] = {}
    while (choice := choose(problem)) is None:
        found = conflict(problem)
        spare = [each for each in found.problem.components if not each.is_required]
        if not spare:
            raise Impossible(text_of(found))
        lacks[spare[-1].name] = text_of(found)
        problem = problem.without({spare[-1].name})
    return choice, lacks


def unmet(problem: PlacementProblem) -> dict[str, str]:
    """Return what components require that is not so where they live, by component."""
    known = {each.place: each for each in problem.candidates}
    at = {c.name: known[c.home] for c in problem.components if c.home in known}
    found = {}
    for each in problem.components:
        home = at.get(each.name)
        if home is None:
            continue
        far = [n for n in each.required.with_ if n in at and at[n].place != home.place]
        near = [n for n in each.required.apart if n in at and at[n].host == home.host]
        reasons = [why for _, why in misfits(each, home)]
        reasons += [_TOGETHER.format(each.name, n) for n in far]
        reasons += [_APART.format(each.name, n) for n in near]
        if reasons:
            found[each.name] = ", ".join(reasons)
    return found


def conflict(problem: PlacementProblem) -> Conflict:
    """Return a minimal conflict of a problem without a choice."""
    components = _least(
        [each.name for each in problem.components],
        lambda kept: choose(_only(problem, kept)) is None,
    )
    problem = _only(problem, components)
    stated = [
        (each.name, kind)
        for each in problem.components
        for kind in _KINDS
        if getattr(each.required, kind)
    ]
    kept = _least(stated, lambda some: choose(_requiring(problem, some)) is None)
    return Conflict(tuple(kept), _requiring(problem, kept))


def _least(items: Sequence[T], holds: Callable[[Sequence[T]], bool]) -> list[T]:
    """Return items of which none can be left out, or what holds no more; halves go first."""
    left, size = [*items], max(1, len(items) // 2)
    while True:
        start = 0
        while start < len(left):
            fewer = left[:start] + left[start + size :]
            if holds(fewer):
                left = fewer
            else:
                start += size
        if size == 1:
            return left
        size = max(1, size // 2)


def _only(problem: PlacementProblem, names: Sequence[str]) -> PlacementProblem:
    return problem.without({each.name for each in problem.components} - {*names})


def _requiring(problem: PlacementProblem, stated: Sequence[tuple[str, str]]) -> PlacementProblem:
    """Return a problem with some of its requirements."""

    def fewer(each: PlacedComponent) -> Requirements:
        values = {k: getattr(each.required, k) for k in _KINDS if (each.name, k) in stated}
        policy = each.required.device_policy
        return replace(NOTHING_REQUIRED, device_policy=policy, **values)

    components = tuple(replace(each, required=fewer(each)) for each in problem.components)
    return replace(problem, components=components)


def text_of(found: Conflict) -> str:
    """Return a conflict in words: what each place lacks, and what keeps components together."""
    components = found.problem.components
    names = " and ".join(each.name for each in components)
    together = " together" if len(components) > 1 else ""
    reasons = [*_bonds(components), *_places(found.problem)]
    return f"no place for {names}{together}: {'; '.join(reasons)}"


def _bonds(components: Sequence[PlacedComponent]) -> Iterator[str]:
    known = {each.name for each in components}
    for each in components:
        yield from (_TOGETHER.format(each.name, n) for n in each.required.with_ if n in known)
        yield from (_APART.format(each.name, n) for n in each.required.apart if n in known)


def _places(problem: PlacementProblem) -> Iterator[str]:
    components = problem.components
    stated = {each.stated: each.name for each in components if each.stated}
    for candidate in problem.candidates:
        others = [name for place, name in stated.items() if place != candidate.place]
        if others and (candidate.place not in stated or len(components) == 1):
            continue
        if not candidate.is_usual and candidate.place not in stated:
            continue
        reasons = _reasons(components, candidate)
        if reasons:
            yield f"{candidate.place}: {', '.join(reasons)}"
    unknown = {each.place for each in problem.candidates}
    yield from (f"no such place: {each}" for each in stated if each not in unknown)
    for each in components:
        yield from (f"{host} is no known host" for host in _unknown_hosts(each, problem))


def _unknown_hosts(component: PlacedComponent, problem: PlacementProblem) -> Iterator[str]:
    known = {each.host for each in problem.candidates}
    yield from (each for each in component.required.hosts if each not in known)


def _reasons(components: Sequence[PlacedComponent], candidate: PlaceCandidate) -> list[str]:
    """Return what speaks against a place, with names where several components are concerned."""
    found: dict[str, list[str]] = {}
    for each in components:
        for _, why in misfits(each, candidate):
            found.setdefault(why, []).append(each.name)
    if len(components) == 1:
        return [*found]
    texts = [f"{why} ({', '.join(names)})" for why, names in found.items()]
    asked = {each.name: each.required.memory for each in components if each.required.memory}
    total = sum(asked.values())
    if not texts and total > candidate.memory:
        free = int(candidate.memory) >> 20
        texts = [f"{free} MiB free, {total >> 20} asked by {', '.join(asked)}"]
    elsewhere = (each for each in components if each.stated not in ("", candidate.place))
    return [*texts, *(f"{each.name} is to be in {each.stated}" for each in elsewhere)]
