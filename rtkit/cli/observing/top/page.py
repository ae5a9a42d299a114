"""Lays rows out as a page: columns, their order, what fits and what stands out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from rtkit.api.rates import RateRow
from rtkit.cli.shared import terminal

SLOW = 0.9
"""Below that part of the rate that was asked for, the one that is reached stands out."""

_GAP = 2
_NARROWEST = 10
_RANKS = {"Zombie": 0, "Error": 1, "Unknown": 2, "Active": 3}
_UNITS = ((1e9, "G"), (1e6, "M"), (1e3, "k"))


class Column(NamedTuple):
    """A column.

    Attributes:
        width: Least width, where there is room for no more.
        key: Column that it sorts by; greatest first if `is_falling`, and None last.
        order: In which order columns are left out where there is no room, from 1; 0 for never.
    """

    title: str
    width: int
    text: Callable[[RateRow], str]
    key: Callable[[RateRow], Any]
    is_falling: bool = True
    is_number: bool = True
    order: int = 0


def short(value: float | None) -> str:
    """Return a number with three digits: ``0.12``, ``9.87``, ``98.7``, ``987``, ``9.87k``."""
    if value is None:
        return "-"
    if value == 0:
        return "0"
    for size, unit in _UNITS:
        if value >= size * 0.9995:
            return _three(value / size) + unit
    return _three(value)


def _three(value: float) -> str:
    for bound, digits in ((9.995, 2), (99.95, 1)):
        if value < bound:
            return f"{value:.{digits}f}"
    return f"{value:.0f}"


def _ms(seconds: float | None) -> str:
    return short(None if seconds is None else seconds * 1000)


def memory(size: int | None) -> str:
    """Return a size in MiB or GiB: ``35.9M``, ``1.93G``."""
    if size is None:
        return "-"
    mib = size / 2**20
    return f"{short(mib)}M" if mib < 999.5 else f"{short(mib / 1024)}G"


def rate(row: RateRow) -> str:
    """Return the rate that is reached, and the one asked for: ``99.8/100``, ``-/100``."""
    if row.asked_hz is None:
        return short(row.reached_hz)
    return f"{short(row.reached_hz)}/{short(row.asked_hz)}"


COLUMNS = (
    Column("NAME", 12, lambda row: row.path, lambda row: row.path, False, False),
    Column(
        "STATE",
        8,
        lambda row: row.state,
        lambda row: (_RANKS.get(row.state, 4), row.path),
        False,
        False,
    ),
    Column("RATE/Hz", 9, rate, lambda row: row.reached_hz),
    Column("MEAN/ms", 7, lambda row: _ms(row.mean_s), lambda row: row.mean_s, order=8),
    Column("MAX/ms", 6, lambda row: _ms(row.longest_s), lambda row: row.longest_s, order=6),
    Column("MISS/s", 6, lambda row: short(row.missed_hz), lambda row: row.missed_hz, order=1),
    Column("CPU%", 5, lambda row: short(row.cpu_percent), lambda row: row.cpu_percent),
    Column("MEM", 5, lambda row: memory(row.memory_bytes), lambda row: row.memory_bytes, order=7),
    Column("IN/s", 5, lambda row: short(row.in_hz), lambda row: row.in_hz, order=5),
    Column("OUT/s", 5, lambda row: short(row.out_hz), lambda row: row.out_hz, order=4),
    Column("RST", 4, lambda row: str(row.restarts), lambda row: row.restarts, order=3),
    Column("PROCESS", 8, lambda row: row.process, lambda row: row.process, False, False, order=2),
)
TITLES = tuple(column.title for column in COLUMNS)


class Look(NamedTuple):
    """Layout options of a page.

    Attributes:
        sort: Index of the column that it is sorted by.
        is_reversed: The other way round.
        selected: Path of the row that keys act on; empty for none.
        width: Columns of the terminal; None for as many as it takes.
        height: Lines for the table; None likewise.
    """

    sort: int = 0
    is_reversed: bool = False
    selected: str = ""
    width: int | None = None
    height: int | None = None


def ordered(rows: Sequence[RateRow], look: Look) -> list[RateRow]:
    """Return rows in the order of a column; what has nothing in it comes last."""
    column = COLUMNS[look.sort]
    by_name = sorted(rows, key=lambda row: row.path)
    known = [row for row in by_name if column.key(row) is not None]
    known.sort(key=column.key, reverse=column.is_falling is not look.is_reversed)
    return known + [row for row in by_name if column.key(row) is None]


def table(rows: Sequence[RateRow], look: Look) -> list[str]:
    """Return the lines of the table: titles, then each row in order.

    A line below a row tells why it is in Error or does not answer. Nothing is cut where the look
    has no width.
    """
    columns = list(COLUMNS)
    leaving = sorted((c for c in COLUMNS if c.order), key=lambda c: -c.order)
    while True:
        cells = [[terminal.printable(column.text(row)) for column in columns] for row in rows]
        titles = [_title(column, look) for column in columns]
        widths = _widths(columns, titles, cells, look.width)
        if look.width is None or not leaving or _total(widths, look.width) <= look.width:
            break
        columns.remove(leaving.pop())
    has_marker = bool(look.width)
    is_tight = look.width is not None and _total(widths, look.width) > look.width
    head = _fields(columns, titles, widths)
    lines = [_whole(head, look, " " if has_marker else "", "title")]
    for row, texts in zip(rows, cells, strict=True):
        is_selected = has_marker and row.path == look.selected
        marker = (">" if is_selected else " ") if has_marker else ""
        fields = _fields(columns, texts, widths)
        if not is_selected and not is_tight:
            fields = [
                _coloured(column, row, field) for column, field in zip(columns, fields, strict=True)
            ]
        line = _whole(fields, look, marker, "selected" if is_selected else "")
        lines.append(cut(line, look.width) if is_tight and not is_selected else line)
        if row.why:
            why = cut(f"{marker and ' '}  {terminal.printable(row.why)}", look.width)
            lines.append(terminal.styled(why, _STYLES["why"]))
    return _visible(lines, rows, look)


def _visible(lines: list[str], rows: Sequence[RateRow], look: Look) -> list[str]:
    """Return the part of a table that has room, with the selected row in it."""
    if look.height is None or len(lines) <= look.height:
        return lines
    head, *body = lines
    end = 0
    for row in rows:
        end += 1 + bool(row.why)
        if row.path == look.selected:
            break
    else:
        end = 0
    room = max(1, look.height - 1)
    first = max(0, min(end - room, len(body) - room)) if end > room else 0
    return [head, *body[first : first + room]]


def _title(column: Column, look: Look) -> str:
    if column.title != TITLES[look.sort]:
        return column.title
    is_falling = column.is_falling is not look.is_reversed
    return f"{column.title}{'v' if is_falling else '^'}"


def _widths(
    columns: Sequence[Column],
    titles: Sequence[str],
    cells: Sequence[Sequence[str]],
    width: int | None,
) -> list[int]:
    """Return the width of each column; the first, of names, gives way and takes what is left."""
    widths = []
    for index, column in enumerate(columns):
        longest = max((terminal.display_width(texts[index]) for texts in cells), default=0)
        widths.append(max(longest, len(titles[index]), column.width))
    if width is not None:
        room = width - _total(widths, width) + widths[0]
        widths[0] = max(_NARROWEST, min(widths[0], room))
    return widths


def _total(widths: Sequence[int], width: int) -> int:
    return sum(widths) + _gap(width) * (len(widths) - 1) + 1


def _gap(width: int | None) -> int:
    return _GAP if width is None or width >= 100 else 1


def _fields(columns: Sequence[Column], texts: Sequence[str], widths: Sequence[int]) -> list[str]:
    fields = []
    for column, text, width in zip(columns, texts, widths, strict=True):
        fitting = cut(text, width)
        blank = " " * (width - terminal.display_width(fitting))
        fields.append(blank + fitting if column.is_number else fitting + blank)
    return fields


def cut(text: str, width: int | None) -> str:
    """Return text that takes at most so many columns; what was cut ends with a ``~``."""
    if width is None or terminal.display_width(text) <= width:
        return text
    while text and terminal.display_width(text) > width - 1:
        text = text[:-1]
    return f"{text}~" if width else ""


def _whole(fields: Sequence[str], look: Look, marker: str, style: str) -> str:
    line = marker + (" " * _gap(look.width)).join(fields)
    if not style:
        return line.rstrip()
    if look.width is not None:
        line = cut(line, look.width)
        line += " " * (look.width - terminal.display_width(line))
    return terminal.styled(line.rstrip() if look.width is None else line, _STYLES[style])


_STYLES = {"title": "reverse", "selected": "bold reverse", "why": "red", "slow": "bold yellow"}


def _coloured(column: Column, row: RateRow, field: str) -> str:
    if column.title == "STATE":
        text = field.rstrip()
        return terminal.state(text, len(field))
    if column.title == "RATE/Hz" and is_slow(row):
        return terminal.styled(field, _STYLES["slow"])
    return field


def is_slow(row: RateRow) -> bool:
    """Return whether a component does not reach the rate that it was asked for."""
    if row.asked_hz is None or row.reached_hz is None:
        return False
    return row.reached_hz < row.asked_hz * SLOW
