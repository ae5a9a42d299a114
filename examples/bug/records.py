"""Results of runs as files: rows as CSV, a result as JSON, tables of many runs as CSV and Markdown.

Numbers are rounded where they are written, so that one seed gives the same bytes everywhere: no
dates, host names or paths are in them.
"""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import hypot
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from .environments import Environment

SCHEMA = "rtkit.bug-run/1"
REACHED, UNREACHABLE, GAVE_UP = "reached", "unreachable", "gave-up"
GOAL, FOLLOW = "goal", "follow"
COLUMNS = ("t", "x", "y", "theta", "mode")
ODOMETRY = ("odom_x", "odom_y", "odom_theta")
TABLE = (
    "environment",
    "variant",
    "sensors",
    "direction",
    "status",
    "path_length",
    "ratio",
    "time",
    "hits",
    "leaves",
    "reversals",
    "collisions",
    "min_clearance",
)
_DIGITS = 6
Point = tuple[float, float]


class Row(NamedTuple):
    """Where the body was at the end of a control step, and what the navigator was doing.

    Attributes:
        t: Simulated time [s].
        x: True place of its centre [m].
        y: The same.
        theta: Its heading [rad], counter-clockwise from +x, in (-pi, pi].
        mode: ``goal`` or ``follow``.
        odometry: Where odometry took it to be (m, m, rad); None where that is the true place.
    """

    t: float
    x: float
    y: float
    theta: float
    mode: str
    odometry: tuple[float, float, float] | None = None


class Choice(NamedTuple):
    """What one run is of; its order is that of tables."""

    environment: str
    variant: str
    sensors: str
    direction: str
    seed: int = 0

    @property
    def folder(self) -> Path:
        """The folder of its files, below that of the call."""
        return Path(self.environment, f"{self.variant}-{self.sensors}-{self.direction}")

    def __str__(self) -> str:
        return f"{self.environment}/{self.variant}-{self.sensors}-{self.direction}"


class Record(NamedTuple):
    """One run with all that is written of it.

    Attributes:
        choice: What it is of.
        environment: Its world.
        status: ``reached``, ``unreachable`` or ``gave-up``.
        rows: One for each control step, the start first.
        hits: Places at which following began [m].
        leaves: Places at which it ended [m].
        reversals: How often it turned round at an earlier point.
        collisions: How often the body was pressed into a wall.
        min_clearance: Least distance of its centre from a wall along the path [m].
        has_line: Whether its variant goes along the m-line.
        shortest: Path of a point robot [m]; None where there is none.
        bound: Published bound of the variant for a point robot [m]; None where there is none.
    """

    choice: Choice
    environment: Environment
    status: str
    rows: Sequence[Row]
    hits: Sequence[Point]
    leaves: Sequence[Point]
    reversals: int
    collisions: int
    min_clearance: float
    has_line: bool = False
    shortest: float | None = None
    bound: float | None = None

    @property
    def path_length(self) -> float:
        """Length of the path through the rows as they are written [m]."""
        places = [(_rounded(row.x), _rounded(row.y)) for row in self.rows]
        return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(places))

    @property
    def ratio(self) -> float | None:
        """How many times the shortest path it took; None where there is none."""
        return self.path_length / self.shortest if self.shortest else None

    @property
    def is_right(self) -> bool:
        """Whether the status is the right answer and no collision was counted."""
        reachable = self.environment.reachable
        right = {None: (REACHED, UNREACHABLE), True: (REACHED,), False: (UNREACHABLE,)}[reachable]
        return self.status in right and not self.collisions


def trajectory_csv(rows: Iterable[Row]) -> str:
    """Return the rows as CSV."""
    rows = list(rows)
    is_noisy = any(row.odometry is not None for row in rows)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS + ODOMETRY if is_noisy else COLUMNS)
    for row in rows:
        odometry = row.odometry or (row.x, row.y, row.theta)
        place = (_text(row.t), _text(row.x), _text(row.y), _angle(row.theta), row.mode)
        noisy = (_text(odometry[0]), _text(odometry[1]), _angle(odometry[2]))
        writer.writerow(place + noisy if is_noisy else place)
    return out.getvalue()


def result_of(record: Record) -> dict[str, Any]:
    """Return what ``result.json`` says of a run."""
    choice = record.choice
    return {
        "schema": SCHEMA,
        "status": record.status,
        "variant": choice.variant,
        "sensors": choice.sensors,
        "environment": choice.environment,
        "direction": choice.direction,
        "seed": choice.seed,
        "path_length": _rounded(record.path_length),
        "time": _rounded(record.rows[-1].t),
        "steps": len(record.rows) - 1,
        "hits": [[_rounded(x), _rounded(y)] for x, y in record.hits],
        "leaves": [[_rounded(x), _rounded(y)] for x, y in record.leaves],
        "reversals": record.reversals,
        "collisions": record.collisions,
        "min_clearance": _rounded(record.min_clearance),
        "shortest": None if record.shortest is None else _rounded(record.shortest),
        "bound": None if record.bound is None else _rounded(record.bound),
    }


def result_json(record: Record) -> str:
    """Return ``result.json`` of a run."""
    return json.dumps(result_of(record), indent=1) + "\n"


def line_of(record: Record) -> str:
    """Return what people are told of a run, on one line."""
    ratio = f" (x{record.ratio:.2f})" if record.ratio and record.status == REACHED else ""
    parts = [
        f"{record.status} after {record.path_length:.1f} m{ratio}",
        f"{record.rows[-1].t:.1f} s",
        _counted(len(record.hits), "hit"),
    ]
    parts += [_counted(record.reversals, "turn-round")] if record.reversals else []
    parts += [_counted(record.collisions, "collision")] if record.collisions else []
    return f"{record.choice}: {', '.join(parts)}{'' if record.is_right else ': WRONG'}"


def table_rows(records: Iterable[Record]) -> list[tuple[str, ...]]:
    """Return the cells of the table of some runs, sorted by its columns from the left."""
    rows = [
        (
            *record.choice[:4],
            record.status,
            round(record.path_length, 3),
            "" if record.ratio is None else round(record.ratio, 3),
            round(record.rows[-1].t, 3),
            len(record.hits),
            len(record.leaves),
            record.reversals,
            record.collisions,
            round(record.min_clearance, 3),
        )
        for record in records
    ]
    rows.sort(key=lambda row: row[:6])
    return [tuple(f"{c:.3f}" if isinstance(c, float) else str(c) for c in row) for row in rows]


def table_csv(records: Iterable[Record]) -> str:
    """Return the table of some runs as CSV."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([TABLE, *table_rows(records)])
    return out.getvalue()


def table_md(records: Sequence[Record]) -> str:
    """Return the table of some runs as Markdown, with what it says on the whole above it."""
    right = sum(record.is_right for record in records)
    lines = [
        f"# {len(records)} runs of Bug navigation",
        "",
        f"{right} of {len(records)} runs gave the right answer without a collision. Lengths in"
        " metres, times in simulated seconds;",
        "ratio: to the shortest path of a point robot to the goal itself. A run ends at the"
        " goal_margin of its world before the goal,",
        "so a ratio may be below 1.",
        "",
        "| " + " | ".join(name.replace("_", " ") for name in TABLE) + " |",
        "| " + " | ".join("---" if i < 5 else "---:" for i in range(len(TABLE))) + " |",
    ]
    for row in table_rows(records):
        lines.append("| " + " | ".join(_short(cell) for cell in row) + " |")
    return "\n".join([*lines, ""])


def write(folder: Path, name: str, text: str) -> None:
    """Write a file under another name and rename it: it is there as a whole or not at all.

    Raises:
        OSError: It cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    draft = folder / f".{name}.{os.getpid()}"
    try:
        draft.write_text(text, encoding="utf-8")
        draft.replace(folder / name)
    finally:
        draft.unlink(missing_ok=True)


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"


def _rounded(value: float) -> float:
    return round(value, _DIGITS) + 0.0  # no -0.0


def _text(value: float) -> str:
    return f"{_rounded(value):.{_DIGITS}f}"


def _angle(value: float) -> str:
    """Return an angle cut, not rounded: that could lead out of (-pi, pi]."""
    scale = 10**_DIGITS
    return f"{int(value * scale) / scale + 0.0:.{_DIGITS}f}"


def _short(cell: str) -> str:
    """Return a number with two decimals, for people."""
    return f"{float(cell):.2f}" if "." in cell else cell
