"""Draws runs live in a terminal, in dots of braille."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import groupby, pairwise
from math import ceil, cos, hypot, sin
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .environments import Environment
    from .messages import PathRow
    from .records import Choice, Point
    from .running import Runner

_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
_COLOURS = {"wall": "\x1b[37m", "goal": "\x1b[34m", "follow": "\x1b[33m", "name": "\x1b[1;31m"}
_RESET = "\x1b[0m"
_MARGIN_M = 0.6


class Canvas:
    """A world in characters of two by four dots each; what is drawn later is above.

    Args:
        environment: The world; all of it fits.
        columns: Width [characters].
        lines: Height [characters].
    """

    def __init__(self, environment: Environment, columns: int, lines: int) -> None:
        points = [environment.start, environment.goal]
        points += [point for outer, *_ in environment.obstacles for point in outer]
        self._left = min(x for x, _ in points) - _MARGIN_M
        self._top = max(y for _, y in points) + _MARGIN_M
        width = max(x for x, _ in points) + _MARGIN_M - self._left
        height = self._top - min(y for _, y in points) + _MARGIN_M
        self._scale = min(2 * columns / width, 4 * lines / height)
        self._columns = ceil(width * self._scale / 2)
        self._lines = ceil(height * self._scale / 4)
        self._dots: dict[tuple[int, int], int] = {}
        self._kinds: dict[tuple[int, int], str] = {}
        self._names: dict[tuple[int, int], str] = {}
        for rings in environment.obstacles:
            for ring in rings:
                self.line("wall", [*ring, ring[0]])

    def line(self, kind: str, points: Sequence[Point]) -> None:
        """Draw a line through points."""
        for a, b in pairwise(points):
            steps = max(1, ceil(hypot(b[0] - a[0], b[1] - a[1]) * self._scale))
            for i in range(steps + 1):
                part = i / steps
                self._dot(kind, (a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])))

    def name(self, text: str, point: Point) -> None:
        """Write a text at a point."""
        x, y = self._place(point)
        for i, letter in enumerate(text):
            self._names[x // 2 + i, y // 4] = letter

    def text(self, *, has_colour: bool) -> list[str]:
        """Return the picture, a text for each line."""
        lines = []
        for y in range(self._lines):
            cells = [self._cell((x, y)) for x in range(self._columns)]
            parts = (
                (kind, "".join(shown for _, shown in some))
                for kind, some in groupby(cells, key=lambda cell: cell[0])
            )
            coloured = (
                f"{_COLOURS[kind]}{text}{_RESET}" if has_colour and kind else text
                for kind, text in parts
            )
            lines.append("".join(coloured).rstrip())
        return lines

    def _place(self, point: Point) -> tuple[int, int]:
        x = int((point[0] - self._left) * self._scale)
        return x, int((self._top - point[1]) * self._scale)

    def _dot(self, kind: str, point: Point) -> None:
        x, y = self._place(point)
        cell = x // 2, y // 4
        self._dots[cell] = self._dots.get(cell, 0) | _DOTS[y % 4][x % 2]
        self._kinds[cell] = kind

    def _cell(self, at: tuple[int, int]) -> tuple[str, str]:
        """Return what is in a cell: its kind, and a character."""
        letter = self._names.get(at)
        if letter:
            return "name", letter
        return self._kinds.get(at, ""), chr(0x2800 + self._dots[at]) if at in self._dots else " "


class Watcher:
    """Draws the run under way over what it drew before.

    Args:
        worlds: Worlds by name.
        write: Writes lines on the terminal.
        has_colour: Whether it shows colours.
    """

    def __init__(
        self,
        worlds: Mapping[str, Environment],
        write: Callable[[Iterable[str]], object],
        *,
        has_colour: bool,
    ) -> None:
        self._worlds = worlds
        self._write = write
        self._has_colour = has_colour
        self._choice: Choice | None = None
        self._rows: list[PathRow] = []

    def __call__(self, runner: Runner, choice: Choice) -> None:
        """Fetch what is new of the run, and draw it."""
        outcome = runner.outcome()
        if choice != self._choice or outcome.rows < len(self._rows):
            self._choice, self._rows = choice, []
        self._rows += runner.rows(len(self._rows))
        if self._rows:
            self._write(self._page(choice, outcome.status or outcome.state))

    def _page(self, choice: Choice, state: str) -> list[str]:
        size = shutil.get_terminal_size()
        canvas = drawn(self._worlds[choice.environment], self._rows, size.columns, size.lines - 3)
        last = self._rows[-1]
        head = f"{choice}: {last.t:.1f} s, {state}"[: size.columns]
        lines = [head, *canvas.text(has_colour=self._has_colour)]
        # Home, each line to its end, and what is below: nothing flickers.
        return ["\x1b[H" + "\x1b[K\n".join(lines) + "\x1b[K\x1b[J"]


def drawn(environment: Environment, rows: Sequence[PathRow], columns: int, lines: int) -> Canvas:
    """Return a picture of a run so far."""
    canvas = Canvas(environment, max(columns, 20), max(lines, 5))
    for a, b in pairwise(rows):
        canvas.line(a.mode, [(a.x, a.y), (b.x, b.y)])
    hits = leaves = 0
    for a, b in pairwise(rows):
        if (a.mode, b.mode) == ("goal", "follow"):
            hits += 1
            canvas.name(f"H{hits}", (b.x, b.y))
        elif (a.mode, b.mode) == ("follow", "goal"):
            leaves += 1
            canvas.name(f"L{leaves}", (b.x, b.y))
    canvas.name("S", environment.start)
    canvas.name("T", environment.goal)
    last = rows[-1]
    ahead = (last.x + 0.3 * cos(last.theta), last.y + 0.3 * sin(last.theta))
    canvas.line(last.mode, [(last.x, last.y), ahead])
    canvas.name("@", (last.x, last.y))
    return canvas
