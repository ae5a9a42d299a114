"""Plots numbers over time as a chart of characters, for a terminal or a text file."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence

MARKS = "*+xo#@"
"""Marks of the curves; there are no more curves than marks."""

_KEPT = 4096
Paint = Callable[[str, int], str]
"""Gives a text the colour of a curve, by its number."""


def unpainted(text: str, _curve: int) -> str:
    """Leave a text without colour."""
    return text


class Chart:
    """Curves, each of its latest points.

    Attributes:
        left_out: Curves without a mark, because there are too few.
    """

    def __init__(self, span_s: float) -> None:
        self._span_s = span_s
        self._curves: dict[str, deque[tuple[float, float]]] = {}
        self._latest: dict[str, float] = {}
        self.left_out: set[str] = set()

    def add(self, curve: str, time_s: float, value: float) -> None:
        """Add a point; those that are older than the chart is wide go."""
        points = self._curves.get(curve)
        if points is None:
            if len(self._curves) == len(MARKS):
                self.left_out.add(curve)
                return
            points = self._curves[curve] = deque(maxlen=_KEPT)
        self._latest[curve] = value
        if math.isfinite(value):
            points.append((time_s, value))
        while points and points[0][0] < time_s - self._span_s:
            points.popleft()

    def lines(self, width: int, height: int, paint: Paint = unpainted) -> list[str]:
        """Return the chart in so many columns and lines, its legend last."""
        points = [point for each in self._curves.values() for point in each]
        legend = [
            paint(f"{MARKS[i]} {name or 'value'} {self._latest[name]:g}", i)
            for i, name in enumerate(self._curves)
        ]
        if self.left_out:
            legend.append(f"({len(self.left_out)} more: -f chooses)")
        if not points:
            return ["  ".join(legend) or "nothing came yet"]
        low, high = _bounds([value for _, value in points])
        begin, end = min(t for t, _ in points), max(t for t, _ in points)
        labels = [f"{high:.4g}", f"{low:.4g}"]
        margin = max(map(len, labels)) + 1
        rows, columns = max(2, height - 2), max(8, width - margin - 1)
        grid = self._grid(rows, columns, (begin, max(end - begin, 1e-9)), (low, high - low), paint)
        lines = []
        for number, cells in enumerate(grid):
            label = labels[0] if number == 0 else labels[1] if number == rows - 1 else ""
            lines.append(f"{label:>{margin - 1}} |{''.join(cells)}".rstrip())
        span = f"{end - begin:.3g} s"
        lines.append(f"{'':{margin - 1}} +{'-' * (columns - len(span) - 1)} {span}")
        return [*lines, "  ".join(legend)]

    def _grid(
        self,
        rows: int,
        columns: int,
        across: tuple[float, float],
        up: tuple[float, float],
        paint: Paint,
    ) -> Sequence[list[str]]:
        grid = [[" "] * columns for _ in range(rows)]
        for number, points in enumerate(self._curves.values()):
            mark = paint(MARKS[number], number)
            for time_s, value in points:
                column = round((time_s - across[0]) / across[1] * (columns - 1))
                row = round((value - up[0]) / up[1] * (rows - 1))
                grid[rows - 1 - row][column] = mark
        return grid


def _bounds(values: list[float]) -> tuple[float, float]:
    low, high = min(values), max(values)
    if low == high:
        room = abs(low) / 2 or 1.0
        return low - room, high + room
    return low, high
