"""Grids: means of what was measured, cell by cell, as properties ``NAME`` and ``NAME.observe``."""

from __future__ import annotations

import math
import threading
from collections.abc import Collection, Sequence
from typing import Any

from rtkit import Names, PropertyError

Cell = tuple[int, int]
Sums = dict[Cell, tuple[int, float]]
"""How many values each cell has, and their sum."""
Share = tuple[str, float, Sequence[tuple[int, int, int, float]]]
"""Model that measured, side of cells [m]; of each its place, how many values, their sum."""

MOST_CELLS = 40_000
MOST_GRIDS = 100
_PARTS = ("observe", "counts", "origin", "shares")


class Grid:
    """Values in square cells of a plane; the order in which they come does not matter.

    Args:
        side: Of a cell [m]; one begins in the origin.
        model: Id of the model that has it.
    """

    def __init__(self, side: float, model: str = "") -> None:
        self._side, self._model = side, model
        self._of: dict[str, Sums] = {model: {}}
        self._low, self._high = (0, 0), (-1, -1)

    def observe(self, x: float, y: float, value: float) -> None:
        """Take a value at a place [m].

        Raises:
            PropertyError: ``bad-value``: no finite numbers; ``too-large``: too far from the others.
        """
        if not all(map(math.isfinite, (x, y, value))):
            raise PropertyError("bad-value", "finite numbers are needed")
        cell = self._cell(x, y)
        count, total = self._of[self._model].get(cell, (0, 0.0))
        self._stretch([cell])
        self._of[self._model][cell] = count + 1, total + value

    def shares(self) -> list[Share]:
        """Return what each model has measured by itself, as far as it is known here."""
        return [
            (model, self._side, [(*cell, *each) for cell, each in sums.items()])
            for model, sums in self._of.items()
        ]

    def merge(self, shares: Sequence[Share]) -> None:
        """Take what other models measured, where it is more than was known of them.

        Raises:
            PropertyError: ``too-large``: too far from the others; ``bad-value``: other cells.
        """
        for model, side, cells in shares:
            if side != self._side:
                raise PropertyError("bad-value", f"cells have sides of {side} m there")
            sums = {(column, row): (count, total) for column, row, count, total in cells}
            if model != self._model and _values_in(sums) > _values_in(self._of.get(model, {})):
                self._stretch(sums)
                self._of[model] = sums

    def at(self, x: float, y: float) -> tuple[int, float]:
        """Return how many values the cell at a place has, and their mean; nan of none.

        Raises:
            PropertyError: ``bad-parameter``: no finite numbers.
        """
        if not (math.isfinite(x) and math.isfinite(y)):
            raise PropertyError("bad-parameter", f"a place has finite numbers, not ({x} {y})")
        return self._at(self._cell(x, y))

    def rows(self, which: int) -> list[list[float]]:
        """Return all counts (0) or means (1): a row for each y, the least one first."""
        columns = range(self._low[0], self._high[0] + 1)
        rows = range(self._low[1], self._high[1] + 1)
        return [[self._at((column, row))[which] for column in columns] for row in rows]

    def origin(self) -> tuple[float, float, float]:
        """Return the corner where the first row begins, and the side of a cell [m]."""
        return self._low[0] * self._side, self._low[1] * self._side, self._side

    def _cell(self, x: float, y: float) -> Cell:
        return math.floor(x / self._side), math.floor(y / self._side)

    def _at(self, cell: Cell) -> tuple[int, float]:
        found = [each[cell] for each in self._of.values() if cell in each]
        count = sum(each[0] for each in found)
        return count, math.fsum(each[1] for each in found) / count if count else math.nan

    def _stretch(self, cells: Collection[Cell]) -> None:
        if not cells:
            return
        ends = [self._low, self._high] if self._low <= self._high else []
        columns, rows = zip(*ends, *cells, strict=True)
        low, high = (min(columns), min(rows)), (max(columns), max(rows))
        if (high[0] - low[0] + 1) * (high[1] - low[1] + 1) > MOST_CELLS:
            raise PropertyError("too-large", f"the grid would have more than {MOST_CELLS} cells")
        self._low, self._high = low, high


def _values_in(sums: Sums) -> int:
    return sum(count for count, _ in sums.values())


class Grids(Names):
    """Grids by name; the first value makes one.

    Args:
        side: Of a cell [m].
        model: Id of the model that has them.
    """

    def __init__(self, side: float, model: str) -> None:
        self._side, self._model = side, model
        self._grids: dict[str, Grid] = {}
        self._names: tuple[str, ...] = ()
        self._lock = threading.Lock()

    def names(self) -> Collection[str]:
        """See `rtkit.Names.names`."""
        return self._names

    def hint(self, name: str) -> Any:
        """See `rtkit.Names.hint`."""
        return tuple[float, float, float] if name.endswith((".observe", ".origin")) else object

    def get(self, name: str, at: tuple[float, float] | None = None) -> Any:
        """See `rtkit.Names.get`: all values, or the one at a place ``x y`` [m]."""
        grid, _, part = name.partition(".")
        if part == "observe":
            raise PropertyError("write-only", f"cannot be read: {name}")
        with self._lock:
            found = self._grids[grid]
            if part in ("origin", "shares"):
                return getattr(found, part)()
            which = 0 if part == "counts" else 1
            return found.rows(which) if at is None else found.at(*at)[which]

    def set(self, name: str, value: Any) -> None:
        """See `rtkit.Names.set`: take a value at a place, ``x y v``."""
        grid, _, part = name.partition(".")
        if part != "observe":
            code = "read-only" if name in self._names else "unknown"
            raise PropertyError(code, f"cannot be set: {name}")
        with self._lock:
            self._grid(grid).observe(*value)

    def _merge(self, name: str, shares: Sequence[Share]) -> None:
        """Take what other models have measured in a grid."""
        with self._lock:
            self._grid(name).merge(shares)

    def _grid(self, name: str) -> Grid:
        if name not in self._grids:
            if len(self._grids) >= MOST_GRIDS:
                raise PropertyError("too-large", f"there are {MOST_GRIDS} grids")
            self._grids[name] = Grid(self._side, self._model)
            below = [f".{part}" for part in _PARTS]
            self._names = tuple(grid + each for grid in self._grids for each in ("", *below))
        return self._grids[name]
