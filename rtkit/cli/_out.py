"""How results look: columns, colours of states, what a terminal gets and what a pipe gets."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import click

_STATE_STYLES: dict[str, dict[str, object]] = {
    "Inactive": {"fg": "blue", "bold": True},
    "Active": {"fg": "green", "bold": True},
    "Error": {"fg": "white", "bg": "red", "bold": True},
    "Unknown": {"fg": "red", "bold": True},
}
STYLES: dict[str, dict[str, object]] = {
    "directory": {"fg": "blue", "bold": True},
    "manager": {"fg": "green", "bold": True},
    "zombie": {"fg": "white", "dim": True},
    "name": {"bold": True},
    "active-set": {"fg": "green", "bold": True},
}


def is_terminal() -> bool:
    """Whether stdout is a terminal."""
    return sys.stdout.isatty()


def has_colour() -> bool:
    """Whether to colour what goes to stdout (NO_COLOR, FORCE_COLOR, TERM=dumb respected)."""
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return is_terminal() and os.environ.get("TERM") != "dumb"


def styled(text: str, style: dict[str, object] | None) -> str:
    """Return `text` in a style where colours are wanted."""
    if not style or not has_colour():
        return text
    return click.style(text, **style)  # type: ignore[arg-type]


def state(text: str, width: int = 0) -> str:
    """Return a life-cycle state in its colour, padded to `width` columns."""
    return styled(text, _STATE_STYLES.get(text)) + " " * (width - len(text))


def pairs(items: Sequence[tuple[str, str]], indent: str = "  ") -> list[str]:
    """Return ``key  value`` lines, keys padded to the longest plus two blanks."""
    width = max((len(key) for key, _ in items), default=0) + 2
    return [f"{indent}{key:<{width}}{value}".rstrip() for key, value in items]


def columns(cells: Sequence[tuple[str, str]], width: int) -> list[str]:
    """Lay (plain, styled) cells out row by row, two blanks apart, in at most `width` columns."""
    if not cells:
        return []
    sizes = [len(plain) for plain, _ in cells]
    count = _column_count(sizes, width)
    widths = [max(sizes[i::count]) for i in range(min(count, len(sizes)))]
    lines = []
    for start in range(0, len(cells), count):
        row = cells[start : start + count]
        padded = [
            text + " " * (size - len(plain))
            for (plain, text), size in zip(row, widths, strict=False)
        ]
        lines.append("  ".join(padded).rstrip())
    return lines


def _column_count(sizes: Sequence[int], width: int) -> int:
    for count in range(len(sizes), 1, -1):
        if sum(max(sizes[i::count]) for i in range(count)) + 2 * (count - 1) <= width:
            return count
    return 1
