"""Computes the heights of the nodes of each column, so that most wires run straight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

_SWEEPS = 10


class Pull(NamedTuple):
    """Demand of a wire on a node: its distance below another node."""

    other: int
    distance: float
    weight: int


def heights(
    columns: Sequence[Sequence[int]],
    gaps: Sequence[Sequence[float]],
    pulls: Sequence[Sequence[tuple[Sequence[Pull], Sequence[Pull]]]],
) -> dict[int, float]:
    """Return the upper edge of each node.

    Args:
        columns: The nodes of each column, from above.
        gaps: For each column, how far below the one above each node at least is (the first: 0).
        pulls: For each node of each column, demands of its wires to the left and to the right.
    """
    place: dict[int, float] = {}
    for column, room in zip(columns, gaps, strict=True):
        down = 0.0
        for node, gap in zip(column, room, strict=True):
            down += gap
            place[node] = down
    for sweep in range(_SWEEPS):
        is_forward = sweep % 2 == 0
        order = list(range(len(columns)))
        for index in order if is_forward else reversed(order):
            is_last = sweep >= _SWEEPS - 2
            desired = [
                _wishes(place, left, right, is_forward=is_forward, takes_both=is_last)
                for left, right in pulls[index]
            ]
            for node, down in zip(
                columns[index], _settled(columns[index], gaps[index], desired, place), strict=True
            ):
                place[node] = down
    return place


_WeightedPlaces = list[tuple[float, int]]


def _wishes(
    place: dict[int, float],
    left: Sequence[Pull],
    right: Sequence[Pull],
    *,
    is_forward: bool,
    takes_both: bool,
) -> _WeightedPlaces:
    near, far = (left, right) if is_forward else (right, left)
    asking = [*near, *far] if takes_both or not near else near
    return [(place[pull.other] + pull.distance, pull.weight) for pull in asking]


def _settled(
    column: Sequence[int],
    gaps: Sequence[float],
    desired: Sequence[_WeightedPlaces],
    place: dict[int, float],
) -> list[float]:
    """Return ordered and separated places that are as near as possible to the desired ones.

    Neighbours that would overlap become a block, which stands at the median of its desired places
    (isotonic regression), so that at least one wire of each block runs straight.
    """
    above: list[float] = []
    total = 0.0
    for gap in gaps:
        total += gap
        above.append(total)
    blocks: list[tuple[_WeightedPlaces, int, float]] = []
    for node, down, asked in zip(column, above, desired, strict=True):
        own = [(goal - down, weight) for goal, weight in asked] or [(place[node] - down, 0)]
        block = (own, 1, _median(own))
        while blocks and blocks[-1][2] > block[2]:
            merged = [*blocks[-1][0], *block[0]]
            block = (merged, blocks[-1][1] + block[1], _median(merged))
            blocks.pop()
        blocks.append(block)
    starts = [value for _, count, value in blocks for _ in range(count)]
    return [start + down for start, down in zip(starts, above, strict=True)]


def _median(desired: _WeightedPlaces) -> float:
    """Return the weighted median; items of weight 0 count only where no others exist."""
    counted = sorted(goal for goal in desired if goal[1]) or sorted(desired)
    half = sum(weight for _, weight in counted) / 2
    passed = 0
    for value, weight in counted:
        passed += weight
        if passed >= half:
            return value
    return counted[-1][0]


class Chain(NamedTuple):
    """The nodes by which a wire passes columns, and the nodes and offsets of its ports."""

    nodes: tuple[int, ...]
    start: tuple[int, float]
    end: tuple[int, float]


def slide(
    place: dict[int, float],
    columns: Sequence[Sequence[int]],
    gaps: Sequence[Sequence[float]],
    chains: Sequence[Chain],
) -> None:
    """Move the level pieces of long wires, each as a whole, to where their ends are nearest.

    Node by node they could not be moved: each is held by its neighbours in the same wire.
    """
    around = {
        node: (column, index, room)
        for column, room in zip(columns, gaps, strict=True)
        for index, node in enumerate(column)
    }

    def bounds(node: int) -> tuple[float, float]:
        column, index, room = around[node]
        low = place[column[index - 1]] + room[index] if index else float("-inf")
        is_last = index + 1 == len(column)
        high = float("inf") if is_last else place[column[index + 1]] - room[index + 1]
        return low, high

    for _ in range(2):
        for chain in chains:
            for piece, goal in _level_pieces(chain, place):
                limits = [bounds(node) for node in piece]
                low = max(limit for limit, _ in limits)
                high = min(limit for _, limit in limits)
                for node in piece:
                    place[node] = min(max(goal, low), high)


def _level_pieces(chain: Chain, place: dict[int, float]) -> list[tuple[list[int], float]]:
    """Return the pieces of a wire at one height, with the height at which it would bend least."""
    pieces: list[list[int]] = []
    for node in chain.nodes:
        if pieces and place[pieces[-1][0]] == place[node]:
            pieces[-1].append(node)
        else:
            pieces.append([node])
    ends = [place[node] + offset for node, offset in (chain.start, chain.end)]
    levels = [ends[0], *(place[piece[0]] for piece in pieces), ends[1]]
    found = []
    for index, piece in enumerate(pieces, 1):
        now, before, after = levels[index], levels[index - 1], levels[index + 1]
        low, high = sorted((before, after))
        found.append((piece, min(max(now, low), high)))
    return found
