"""Writes what was measured into a page: the table between two marks, with machine and placement."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from pathlib import Path

from bench import placement as place
from bench.harness import Missing, Row

BEGIN, END = "<!-- bench: begin -->\n", "<!-- bench: end -->\n"
_HEAD = ("measured", "figure", "floor", "ratio", "target", "the floor is")


def section(rows: Sequence[Row | Missing], load: float, placement: str, day: str) -> str:
    """Return the text between the marks: where it was measured, and the table."""
    where = f"Measured on {day}: {place.machine()}; load average before {load:.1f}; {placement}."
    lines = ["| " + " | ".join(_HEAD) + " |", "| --- | ---: | ---: | ---: | ---: | --- |"]
    lines += ["| " + " | ".join(_cells(row)) + " |" for row in rows]
    return "\n".join([where, "", *lines, ""])


def _cells(row: Row | Missing) -> tuple[str, ...]:
    if isinstance(row, Missing):
        return (row.what, "-", "-", "-", "-", f"not measured: {row.why}")
    bound = "" if row.target is None else f"{row.target:g} {'x' if row.is_ratio else row.unit}"
    missed = f" {row.verdict}" if row.verdict in ("MISSED", "too noisy") else ""
    figure, floor, *_ = row.measured
    figures = (f"{figure:.3g} {row.unit}", f"{floor:.3g} {row.unit}", f"{row.ratio} x")
    return (row.what, *figures, bound + missed, row.floor_is)


def write(file: Path, rows: Sequence[Row | Missing], load: float, placement: str) -> None:
    """Put what was measured between the marks of a page."""
    day = datetime.datetime.now(tz=datetime.UTC).date().isoformat()
    put(file, "bench", section(rows, load, placement, day))


def put(file: Path, name: str, text: str) -> None:
    """Put a text between the marks of a name."""
    begin, end = f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->\n"
    before, _, rest = file.read_text(encoding="utf-8").partition(begin)
    _, found, after = rest.partition(end)
    if not found:
        raise ValueError(f"{file}: there is no place between {begin.strip()} and {end.strip()}")
    file.write_text(f"{before}{begin}{text}{end}{after}", encoding="utf-8")
