"""Orders the vertical pieces of wires between two columns from left to right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

_NEAR = 5
"""Lines nearer than this look like one."""

_OVERLAP = 50
"""Lines that lie on one another are as bad as so many crossings."""

_MANY = 80
"""Beyond so many nets their order is only chosen roughly."""


class Net(NamedTuple):
    """Wires that share a vertical line: the heights at which they come and go.

    Attributes:
        lefts: At the left side of the channel.
        rights: At its right side.
    """

    lefts: tuple[int, ...]
    rights: tuple[int, ...]

    @property
    def low(self) -> int:
        """The upper end of the vertical line."""
        return min(self.lefts + self.rights)

    @property
    def high(self) -> int:
        """The lower end of the vertical line."""
        return max(self.lefts + self.rights)

    @property
    def is_straight(self) -> bool:
        """Return whether the net has no vertical line."""
        return self.low == self.high


class Piece(NamedTuple):
    """A vertical line and its track, from 0 at the left."""

    net: Net
    track: int


Route = tuple[Piece, ...]
"""Of a straight net none, mostly one; two with a level line between where a net gives way."""


def joints(net: Net) -> list[int]:
    """Return the heights at which more than two pieces of a net meet."""
    heights = sorted({*net.lefts, *net.rights})
    return [y for y in heights if _ways(net, y) > 2]


def _ways(net: Net, y: int) -> int:
    return (y in net.lefts) + (y in net.rights) + (y > net.low) + (y < net.high)


class _Line(NamedTuple):
    """A vertical line to be put in order; the parts of one net keep theirs."""

    number: int
    part: int
    net: Net


def routes(nets: Sequence[Net]) -> list[Route]:
    """Return the vertical lines of each net."""
    lines = [_Line(index, 0, net) for index, net in enumerate(nets) if not net.is_straight]
    order = _ordered(lines)
    if len(lines) <= _MANY:
        lines = _parted(order)
        order = _ordered(lines) if len(lines) > len(order) else order
    track: dict[tuple[int, int], int] = {}
    found: list[list[Piece]] = [[] for _ in nets]
    for place, line in enumerate(order):
        before = [track[other.number, other.part] for other in order[:place] if _meet(other, line)]
        track[line.number, line.part] = max(before, default=-1) + 1
    for line in sorted(order, key=lambda line: line.part):
        found[line.number].append(Piece(line.net, track[line.number, line.part]))
    return [tuple(pieces) for pieces in found]


def _ordered(lines: Sequence[_Line]) -> list[_Line]:
    order = sorted(lines, key=lambda line: (*_first_guess(line.net), line.number, line.part))
    return _improved(order) if len(order) <= _MANY else order


def _first_guess(net: Net) -> tuple[bool, int]:
    """Of nets that lead down the lower ones come first, of those that lead up the upper ones."""
    leads_down = sum(net.rights) * len(net.lefts) > sum(net.lefts) * len(net.rights)
    return (leads_down, -net.low if leads_down else net.low)


def _improved(order: list[_Line]) -> list[_Line]:
    """Move lines to where they cost less, until none can be moved."""
    for _ in range(6):
        has_moved = False
        for line in list(order):
            rest = [other for other in order if other is not line]
            costs = _costs_of_places(line, rest)
            place = min(range(len(costs)), key=lambda at: (costs[at], at))
            if costs[place] < costs[order.index(line)]:
                rest.insert(place, line)
                order = rest
                has_moved = True
        if not has_moved:
            break
    return order


def _costs_of_places(line: _Line, rest: Sequence[_Line]) -> list[int]:
    cost = sum(_cost(line, other) for other in rest)
    costs = [cost]
    for other in rest:
        cost += _cost(other, line) - _cost(line, other)
        costs.append(cost)
    return costs


def _cost(first: _Line, second: _Line) -> int:
    """Return the cost of the first line left of the second: crossings and overlaps."""
    if first.number == second.number:
        return 20 * _OVERLAP if first.part > second.part else 0
    one, two = first.net, second.net
    crossings = sum(one.low < y < one.high for y in two.lefts)
    crossings += sum(two.low < y < two.high for y in one.rights)
    return crossings + _OVERLAP * _overlaps(one, two)


def _overlaps(one: Net, two: Net) -> int:
    """Count the level lines of two nets that lie on one another, the first one being left."""
    return sum(abs(y - z) < _NEAR for y in one.rights for z in two.lefts)


def _meet(one: _Line, other: _Line) -> bool:
    return one.net.low - _NEAR < other.net.high and other.net.low - _NEAR < one.net.high


def _parted(order: Sequence[_Line]) -> list[_Line]:
    """Part nets in two that change places with another one, which no order would solve."""
    heights = [y for line in order for y in (*line.net.lefts, *line.net.rights)]
    lines = []
    for place, line in enumerate(order):
        net = line.net
        is_in_the_way = any(_overlaps(other.net, net) for other in order[:place])
        bend = _free_height(net, heights) if is_in_the_way and net.lefts and net.rights else None
        if bend is None:
            lines.append(line)
            continue
        heights.append(bend)
        lines.append(line._replace(net=Net(net.lefts, (bend,))))
        lines.append(line._replace(part=1, net=Net((bend,), net.rights)))
    return lines


def _free_height(net: Net, taken: Sequence[int]) -> int | None:
    """Return a height about the middle of a net that is near none of the others."""
    middle = (net.low + net.high) // 2
    for away in range((net.high - net.low) // 2):
        for y in (middle + away, middle - away):
            if all(abs(y - other) >= _NEAR for other in taken):
                return y
    return None
