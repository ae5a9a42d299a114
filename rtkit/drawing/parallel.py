"""Draws wires between the same two ports beside each other: they would be one line."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

from rtkit.drawing.columns import simplified
from rtkit.drawing.scene import Point, Wire

_APART = 4
_WIDTH = 8
"""Of all wires of one port: less than that of the port, and than from one wire to the next."""


def apart(
    wires: Iterable[Wire], paths: Mapping[str, Sequence[Point]]
) -> dict[str, Sequence[Point]]:
    """Return the paths of wires by their tips, those with the same ends led beside each other."""
    same = defaultdict(list)
    for wire in wires:
        if wire.tip in paths:
            same[wire.source, wire.target].append(wire.tip)
    found = dict(paths)
    for tips in same.values():
        gap = min(_APART, _WIDTH / max(1, len(tips) - 1))
        for place, tip in enumerate(tips):
            away = round((place - (len(tips) - 1) / 2) * gap)
            if away:
                found[tip] = _beside(simplified(paths[tip]), away)
    return found


def _beside(path: Sequence[Point], away: int) -> list[Point]:
    """Return a path that runs beside a right-angled one, at the same distance everywhere."""
    moved = []
    for number, (x, y) in enumerate(path):
        pieces = [*path[max(0, number - 1) : number + 2]]
        for one, other in pairwise(pieces):
            if one[1] == other[1]:
                y = path[number][1] - (away if other[0] > one[0] else -away)
            else:
                x = path[number][0] + (away if other[1] > one[1] else -away)
        moved.append((x, y))
    return moved
