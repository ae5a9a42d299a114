"""Orders nodes within columns so that few wires cross; long wires become chains of nodes."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Sequence
from typing import NamedTuple

_SWEEPS = 16
_MANY = 1500
"""Beyond so many links the order is only improved roughly."""


class EdgePiece(NamedTuple):
    """A piece of a wire between two nodes of neighbouring columns, or of one column.

    Attributes:
        left: The node at its left; of a turn in one column, the node with the port.
        right: The node at its right; of a turn, the node that stands for the wire.
        left_at: Its position at the left node, from 0 (top) to 1 (bottom).
        right_at: The same at the right node.
        turn: 0, or 1 where it turns at the right side of its column, -1 at the left side.
    """

    left: int
    right: int
    left_at: float = 0.5
    right_at: float = 0.5
    turn: int = 0


def ordered(
    columns: Sequence[Sequence[int]],
    links: Sequence[EdgePiece],
    chains: Sequence[Sequence[int]] = (),
) -> list[list[int]]:
    """Return the columns with their nodes in an order in which few links cross.

    Chains are nodes of one wire; those that turn are also tried above and below everything.
    """
    ordering = _Ordering(columns, links)
    best = ordering.best()
    turning = {node for link in links if link.turn for node in (link.left, link.right)}
    lead_back = [chain for chain in chains if chain and turning & {chain[0], chain[-1]}]
    return ordering.with_detours(best, lead_back) if len(links) <= _MANY else best


class _Ordering:
    def __init__(self, columns: Sequence[Sequence[int]], links: Sequence[EdgePiece]) -> None:
        self._columns = [list(column) for column in columns]
        self._column = {node: i for i, column in enumerate(columns) for node in column}
        self._place: dict[int, int] = {}
        self._lefts: dict[int, list[tuple[int, float, float]]] = {}
        self._rights: dict[int, list[tuple[int, float, float]]] = {}
        self._turns: dict[int, list[int]] = {}
        self._between: list[list[EdgePiece]] = [[] for _ in columns]
        self._turning: list[list[EdgePiece]] = [[] for _ in columns]
        self._ends: list[dict[int, list[tuple[int, float]]]] = [{1: [], -1: []} for _ in columns]
        self._is_large = len(links) > _MANY
        for link in links:
            self._add(link)
        self._number()

    def _add(self, link: EdgePiece) -> None:
        if link.turn:
            self._turns.setdefault(link.left, []).append(link.right)
            self._turns.setdefault(link.right, []).append(link.left)
            self._turning[self._column[link.left]].append(link)
            return
        self._ends[self._column[link.left]][1].append((link.left, link.left_at))
        self._ends[self._column[link.right]][-1].append((link.right, link.right_at))
        self._rights.setdefault(link.left, []).append((link.right, link.right_at, link.left_at))
        self._lefts.setdefault(link.right, []).append((link.left, link.left_at, link.right_at))
        self._between[self._column[link.left]].append(link)

    def _number(self) -> None:
        for column in self._columns:
            for place, node in enumerate(column):
                self._place[node] = place

    def best(self) -> list[list[int]]:
        """Sweep to and fro and return the best that was seen."""
        best, least = self._copy(), self._crossings()
        for sweep in range(4 if self._is_large else _SWEEPS):
            if least == 0:
                break
            is_forward = sweep % 2 == 0
            order = range(1, len(self._columns)) if is_forward else range(len(self._columns) - 1)
            for index in order if is_forward else reversed(order):
                self._sort(index, self._lefts if is_forward else self._rights)
            if not self._is_large:
                self._swap_neighbours()
            crossings = self._crossings()
            if crossings < least:
                best, least = self._copy(), crossings
        return best

    def with_detours(
        self, best: list[list[int]], chains: Sequence[Sequence[int]]
    ) -> list[list[int]]:
        """Lead wires above or below everything where fewer cross then."""
        self._take(best)
        least = self._crossings()
        for chain in chains:
            for is_above in (True, False):
                self._take(best)
                for node in chain:
                    column = self._columns[self._column[node]]
                    column.remove(node)
                    column.insert(0 if is_above else len(column), node)
                self._number()
                self._swap_neighbours()
                crossings = self._crossings()
                if crossings < least:
                    best, least = self._copy(), crossings
        return best

    def _take(self, columns: Sequence[Sequence[int]]) -> None:
        self._columns = [list(column) for column in columns]
        self._number()

    def _copy(self) -> list[list[int]]:
        return [list(column) for column in self._columns]

    def _sort(self, index: int, neighbours: dict[int, list[tuple[int, float, float]]]) -> None:
        """Sort a column by the positions of the neighbours of its nodes."""
        column = self._columns[index]

        def wish(node: int) -> float:
            known = neighbours.get(node, ())
            places = [self._place[other] + at - own + 0.5 for other, at, own in known]
            places = places or [self._place[other] for other in self._turns.get(node, ())]
            return sum(places) / len(places) if places else self._place[node]

        wishes = {node: wish(node) for node in column}
        column.sort(key=lambda node: wishes[node])
        for place, node in enumerate(column):
            self._place[node] = place

    def _swap_neighbours(self) -> None:
        for index, column in enumerate(self._columns):
            is_better = True
            rounds = 0
            while is_better and rounds < 8:
                is_better = False
                rounds += 1
                for place in range(len(column) - 1):
                    is_better |= self._swap(index, place)

    def _swap(self, index: int, place: int) -> bool:
        """Swap two neighbours if fewer links cross then."""
        column = self._columns[index]
        upper, lower = column[place], column[place + 1]
        gain = self._crossed(upper, lower) - self._crossed(lower, upper)
        before = self._turn_crossings(index)
        self._exchange(column, place)
        if gain + before - self._turn_crossings(index) > 0:
            return True
        self._exchange(column, place)
        return False

    def _exchange(self, column: list[int], place: int) -> None:
        column[place], column[place + 1] = column[place + 1], column[place]
        self._place[column[place]], self._place[column[place + 1]] = place, place + 1

    def _crossed(self, upper: int, lower: int) -> int:
        """Count how many links of two nodes cross when the one is above the other."""
        count = 0
        for side in (self._lefts, self._rights):
            others = [self._place[node] + at for node, at, _ in side.get(upper, ())]
            for node, at, _ in side.get(lower, ()):
                place = self._place[node] + at
                count += sum(other > place for other in others)
        return count

    def _crossings(self) -> int:
        columns = range(len(self._columns))
        return sum(self._between_crossings(i) + self._turn_crossings(i) for i in columns)

    def _between_crossings(self, index: int) -> int:
        ends = sorted(
            (self._place[each.left] + each.left_at, self._place[each.right] + each.right_at)
            for each in self._between[index]
        )
        return count_crossings(ends)

    def _turn_crossings(self, index: int) -> int:
        """Count the crossings of a column's turns: ends of links that lie between theirs."""
        spans = [self._span(link) for link in self._turning[index]]
        count = 0
        for place, (link, (low, high)) in enumerate(zip(self._turning[index], spans, strict=True)):
            ends = self._ends[index][link.turn]
            count += sum(low < self._place[node] + at < high for node, at in ends)
            for other, (least, most) in zip(
                self._turning[index][:place], spans[:place], strict=True
            ):
                if other.turn == link.turn:
                    count += (low < least < high) != (low < most < high)
        return count

    def _span(self, link: EdgePiece) -> tuple[float, float]:
        one = self._place[link.left] + link.left_at
        other = self._place[link.right] + link.right_at
        return min(one, other), max(one, other)


def count_crossings(ends: Sequence[tuple[float, float]]) -> int:
    """Count how many pairs of links cross, given their left and right places, sorted.

    >>> count_crossings([(0, 1), (1, 0), (2, 2)])
    1
    """
    seen: list[float] = []
    count = 0
    start = 0
    for index, (left, right) in enumerate(ends):
        if index and ends[index - 1][0] != left:
            # Links from one place cross none of each other.
            for _, earlier in ends[start:index]:
                insort(seen, earlier)
            start = index
        count += len(seen) - bisect_left(seen, right + 1e-9)
    return count
