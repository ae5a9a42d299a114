"""Partial order: turns one valid order of steps into layers of steps that may run at once.

Two steps must keep their order when one changes what the other reads or changes.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from typing import NamedTuple


class Touch(NamedTuple):
    """The variables that a step reads, and those that it changes."""

    reads: frozenset[Hashable]
    changes: frozenset[Hashable]


def predecessors(touches: Iterable[Touch]) -> list[set[int]]:
    """Return for each step, by its place, the steps that must be done before it.

    Only those nearest before it for each variable are listed; the others follow from these.
    """
    found: list[set[int]] = []
    changed_by: dict[Hashable, int] = {}
    read_by: dict[Hashable, list[int]] = {}
    for place, touch in enumerate(touches):
        before: set[int] = set()
        for variable in touch.reads | touch.changes:
            if variable in changed_by:
                before.add(changed_by[variable])
        for variable in touch.changes:
            before.update(read_by.pop(variable, ()))
            changed_by[variable] = place
        for variable in touch.reads - touch.changes:
            read_by.setdefault(variable, []).append(place)
        found.append(before - {place})
    return found


def layers(before: Sequence[set[int]]) -> list[list[int]]:
    """Return the steps, by their places, in layers that need nothing of each other.

    Each is as early as it can be. `before` names for each step earlier ones.
    """
    depths: list[int] = []
    made: list[list[int]] = []
    for place, earlier in enumerate(before):
        depth = max((depths[each] + 1 for each in earlier), default=0)
        depths.append(depth)
        if depth == len(made):
            made.append([])
        made[depth].append(place)
    return made
