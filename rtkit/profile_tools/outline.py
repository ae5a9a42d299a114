"""Outline of a text in levels: the content of a summary, apart from its layout."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

_INDENT = "  "
_GAP = "  "

Width = Callable[[str], int]
"""Function that returns the number of columns a text takes."""


class Outline(NamedTuple):
    """An entry: cells side by side, and what is below it.

    Attributes:
        cells: The first one names the entry; cells of neighbours stand in columns.
    """

    cells: tuple[str, ...]
    children: tuple[Outline, ...] = ()


def entry(*cells: str, below: Iterable[Outline] = ()) -> Outline:
    """Return an entry; empty cells at its end are left out."""
    kept = list(cells)
    while len(kept) > 1 and not kept[-1]:
        kept.pop()
    return Outline(tuple(kept), tuple(below))


def outline_lines(
    entries: Sequence[Outline], width: Width = len, indent: str = ""
) -> Iterator[str]:
    """Yield the entries as lines, two blanks further in for each level."""
    for each, line in zip(entries, aligned(entries, width), strict=True):
        yield indent + line
        yield from outline_lines(each.children, width, indent + _INDENT)


def aligned(entries: Sequence[Outline], width: Width = len) -> list[str]:
    """Return a line for each entry, its cells in columns with those of the others."""
    widths: dict[int, int] = {}
    for each in entries:
        # A last cell needs no padding, and often is the longest by far.
        for column, cell in enumerate(each.cells[:-1]):
            widths[column] = max(widths.get(column, 0), width(cell))
    return [_line(each.cells, widths, width) for each in entries]


def _line(cells: tuple[str, ...], widths: dict[int, int], width: Width) -> str:
    parts = [
        cell + " " * (widths.get(column, 0) - width(cell)) for column, cell in enumerate(cells[:-1])
    ]
    return _GAP.join([*parts, cells[-1]]).rstrip()
