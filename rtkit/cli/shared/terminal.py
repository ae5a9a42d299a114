"""Formats results: columns, colours of states, differences between a terminal and a pipe."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterable, Sequence

_STATE_STYLES = {
    "Inactive": "bold blue",
    "Active": "bold green",
    "Error": "bold white on red",
    "Unknown": "bold red",
}
STYLES = {
    "directory": "bold blue",
    "manager": "bold green",
    "zombie": "dim white",
    "name": "bold",
    "active-set": "bold green",
}
_FINDING_STYLES = {
    "error": "bold red",
    "warning": "bold yellow",
    "note": "cyan",
    "valid": "bold green",
    "name": "bold",
    "path": "dim",
}
_ATTRIBUTES = ("bold", "dim", "reverse")


def printable(text: str) -> str:
    """Return `text` with everything that could steer a terminal written as an escape."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or _is_blank(c) else _escaped(c) for c in text)


def of_file(line: str) -> str:
    """Return a line of a file: as it is, but printable with its tabs where a terminal shows it.

    What a pipe takes may be written to a file again, and is to be the same there.
    """
    return "\t".join(map(printable, line.split("\t"))) if is_terminal() else line


def _is_blank(c: str) -> bool:
    return c.isspace() and ord(c) > 0x9F and c not in "\u2028\u2029"


def _escaped(c: str) -> str:
    return c.encode("unicode_escape").decode("ascii")


def write(lines: Iterable[str]) -> None:
    """Write lines on stdout, all at once."""
    text = "".join(f"{line}\n" for line in lines)
    if text:
        sys.stdout.write(text)


def write_now(lines: Iterable[str]) -> None:
    """Write lines on stdout and flush it, for readers that follow them live."""
    write(lines)
    sys.stdout.flush()


def is_terminal() -> bool:
    """Return whether stdout is a terminal."""
    return sys.stdout.isatty()


def has_colour() -> bool:
    """Return whether to colour what goes to stdout (NO_COLOR, FORCE_COLOR, TERM=dumb respected)."""
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return is_terminal() and os.environ.get("TERM") != "dumb"


def styled(text: str, style: str | None) -> str:
    """Return `text`, made printable, in a style, ``bold white on red``, if colours are wanted."""
    safe = printable(text)
    if not style or not has_colour():
        return safe
    import click

    front, _, bg = style.partition(" on ")
    words = front.split()
    fg = next((word for word in words if word not in _ATTRIBUTES), None)
    return click.style(safe, fg, bg or None, **{each: True for each in words if each != fg})


def finding_style(text: str, role: str) -> str:
    """Return a part of a finding as a terminal shows it."""
    return styled(text, _FINDING_STYLES.get(role))


def state(text: str, width: int = 0) -> str:
    """Return a life-cycle state in its colour, padded to `width` columns."""
    return styled(text, _STATE_STYLES.get(text)) + " " * (width - len(text))


def pairs(items: Sequence[tuple[str, str]], indent: str = "  ") -> list[str]:
    """Return ``key  value`` lines, keys padded to the longest plus two blanks."""
    safe = [(printable(key), printable(value)) for key, value in items]
    width = max((display_width(key) for key, _ in safe), default=0) + 2
    return [f"{indent}{padded(key, width)}{value}".rstrip() for key, value in safe]


def table(rows: Iterable[Sequence[str]]) -> list[str]:
    """Return rows of as many cells each as lines, columns two blanks apart."""
    cells = [tuple(map(printable, row)) for row in rows]
    widths = [max(map(display_width, column)) + 2 for column in zip(*cells, strict=True)]
    return ["".join(map(padded, row, widths)).rstrip() for row in cells]


def padded(text: str, width: int, shown: str | None = None) -> str:
    """Return `shown` (by default `text`) followed by blanks up to `width` columns of `text`."""
    return (text if shown is None else shown) + " " * (width - display_width(text))


def display_width(text: str) -> int:
    """Return the number of columns that a terminal uses for `text`."""
    if text.isascii():
        return len(text)
    import unicodedata

    return sum(
        0 if unicodedata.combining(c) else 1 + (unicodedata.east_asian_width(c) in "WF")
        for c in text
    )


def columns(cells: Sequence[tuple[str, str]], width: int = 0) -> list[str]:
    """Lay (plain, styled) cells out row by row, two blanks apart; 0 is the terminal's width."""
    if not cells:
        return []
    from shutil import get_terminal_size

    width = width or get_terminal_size().columns
    sizes = [display_width(plain) for plain, _ in cells]
    count = _column_count(sizes, width)
    widths = [max(sizes[i::count]) for i in range(count)]
    lines = []
    for start in range(0, len(cells), count):
        row = cells[start : start + count]
        fields = [
            padded(plain, size, shown) for (plain, shown), size in zip(row, widths, strict=False)
        ]
        lines.append("  ".join(fields).rstrip())
    return lines


def _column_count(sizes: Sequence[int], width: int) -> int:
    most = min(len(sizes), (width + 2) // (min(sizes) + 2))
    for count in range(most, 1, -1):
        if sum(max(sizes[i::count]) for i in range(count)) + 2 * (count - 1) <= width:
            return count
    return 1


def clock(moment: float) -> str:
    """Return the local time of day of a moment [s since 1970]: ``12:00:00.250``."""
    return f"{time.strftime('%H:%M:%S', time.localtime(moment))}.{int(moment % 1 * 1000):03}"
