"""Draws wires between the same two ports beside each other: they would be one line."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise

from rtkit.drawing.scene import Point, Wire

Path = tuple[Point, ...]
_APART = 4
_WIDTH = 8
"""Of all wires of one port: about that of the port."""


def apart(wires: Sequence[Wire], paths: Sequence[Path]) -> tuple[Path, ...]:
    """Return the paths of wires, those of wires with the same ends moved away from each other."""
    same = defaultdict(list)
    for number, wire in enumerate(wires):
        same[wire.source, wire.target].append(number)
    found = list(paths)
    for numbers in same.values():
        gap = min(_APART, _WIDTH / max(1, len(numbers) - 1))
        for place, number in enumerate(numbers):
            away = round((place - (len(numbers) - 1) / 2) * gap)
            if away:
                found[number] = tuple(_beside(paths[number], away))
    return tuple(found)


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
