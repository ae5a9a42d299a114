"""Chooses other places for components whose hosts are lost: of those named for each, the first.

Pure code, as the choice itself; see decisions 79 and 81.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rtkit.deployment.placement.choice import PlaceCandidate, PlacementProblem
from rtkit.deployment.placement.conflict import placed
from rtkit.deployment.placement.requirements import process_groups
from rtkit.errors import Impossible
from rtkit.fast_dataclass import replace

_RANK = 1e4
"""Extra cost of a place over the one that is named before it."""

Texts = Mapping[str, str]


def elsewhere(problem: PlacementProblem, named: Mapping[str, Sequence[str]]) -> tuple[Texts, Texts]:
    """Return places of the named components, and why there is none for some; all others stay.

    Each has the first of its places that meets what is required. Those that share a process go
    together, or stay.
    """
    components = (
        replace(each, home="", is_required=False) if each.name in named
        else replace(each, is_required=True)
        for each in problem.components
    )  # fmt: skip
    candidates = (_ranked(each, named) for each in problem.candidates)
    try:
        choice, found = placed(PlacementProblem(tuple(components), tuple(candidates)))
    except Impossible as error:  # what stays is not as required
        return {}, dict.fromkeys(named, str(error))
    lacks = {**found}
    for group in process_groups({each.name: each.required for each in problem.components}):
        why = next((found[name] for name in group if name in found), "")
        lacks |= {name: why for name in group if why and name in named}
    return {n: place for n, place in choice.places.items() if n in named.keys() - lacks}, lacks


def _ranked(candidate: PlaceCandidate, named: Mapping[str, Sequence[str]]) -> PlaceCandidate:
    """Return a candidate that costs components the more, the later it is named; others lack it."""
    lacks, extras = {**candidate.lacks}, {**candidate.extras}
    for name, places in named.items():
        if candidate.place in places:
            rank = places.index(candidate.place) * _RANK
            extras[name] = {**extras.get(name, {}), f"rank:{name}": rank}
        else:
            lacks[name] = "not named"
    return replace(candidate, lacks=lacks, extras=extras)
