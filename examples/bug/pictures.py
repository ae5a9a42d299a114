"""Pictures of runs as SVG: one run with all its places named, and the runs of a world side by side.

Walls are grey, the way to the goal is blue, following of a wall orange, with arrows along it. S is
the start, T the goal, H1 … where following began, L1 … where it ended.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, pairwise
from math import atan2, cos, degrees, hypot, sin
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from xml.sax.saxutils import escape

if TYPE_CHECKING:
    from .environments import Environment
    from .records import Point, Record

COLOURS = {"goal": "#1f6fd0", "follow": "#e8730c"}
_STYLE = """
text{font-family:'Noto Sans','DejaVu Sans','Helvetica Neue',Arial,sans-serif;fill:#1a202c}
.wall{fill:#8a94a3;stroke:#4a5568;stroke-width:1;fill-rule:evenodd}
.line{stroke:#718096;stroke-width:1;stroke-dasharray:5 4;fill:none}
.way{fill:none;stroke-width:2.2;stroke-linejoin:round;stroke-linecap:round}
.goal{stroke:#1f6fd0}.follow{stroke:#e8730c}
.head{stroke:none}.head.goal{fill:#1f6fd0}.head.follow{fill:#e8730c}
.start{fill:#2f855a}.target{fill:#c53030}
.hit{fill:#c53030;stroke:#fff;stroke-width:1}
.leave{fill:#fff;stroke:#2f855a;stroke-width:2}
.end{fill:none;stroke:#1a202c;stroke-width:1.5}
.name{font-weight:bold;paint-order:stroke;stroke:#fff;stroke-width:2.4;stroke-linejoin:round}
.wrong{fill:#c53030;font-weight:bold}
.lead{stroke:#a0aec0;stroke-width:0.8;fill:none}
.cell{fill:#fff;stroke:#cbd5e0}
"""
_MARGIN_M = 0.6
_TOLERANCE_M = 0.01
_TURNS = 8
_FAR = (0.75, 1.4, 2.6, 3.8, 5.0)
"""How far from its place a name may stand [sizes of the letters]."""


class _Canvas:
    """A world drawn at a scale; y goes up."""

    def __init__(self, environment: Environment, ways: Iterable[Sequence[Point]]) -> None:
        points = [environment.start, environment.goal]
        points += [p for outer, *_ in environment.obstacles for p in outer]
        points += [p for way in ways for p in way]
        self.left = min(x for x, _ in points) - _MARGIN_M
        self.top = max(y for _, y in points) + _MARGIN_M
        self.width = max(x for x, _ in points) + _MARGIN_M - self.left
        self.height = self.top - min(y for _, y in points) + _MARGIN_M

    def scaled(self, room: float) -> float:
        """Return how many pixels a metre has, for the whole to fit into a square of that size."""
        return room / max(self.width, self.height)


class _View(NamedTuple):
    """A canvas at a place of the picture.

    Attributes:
        scale: Pixels of a metre.
        at: Upper left corner [pixels].
        font: Size of names [pixels].
        step: Metres between arrows.
    """

    canvas: _Canvas
    scale: float
    at: Point
    font: float
    step: float

    def place(self, point: Point) -> Point:
        """Return where a point of the world is in the picture."""
        x = self.at[0] + (point[0] - self.canvas.left) * self.scale
        return x, self.at[1] + (self.canvas.top - point[1]) * self.scale

    def path(self, points: Iterable[Point], *, is_closed: bool = False) -> str:
        """Return points as the data of a path."""
        text = "L".join("{:.1f} {:.1f}".format(*self.place(point)) for point in points)
        return f"M{text}{'Z' if is_closed else ''}"


def run_svg(record: Record) -> str:
    """Return the picture of one run."""
    way = [(row.x, row.y) for row in record.rows]
    canvas = _Canvas(record.environment, [way])
    scale = canvas.scaled(640)
    width, height = max(canvas.width * scale, 540), canvas.height * scale
    view = _View(canvas, scale, ((width - canvas.width * scale) / 2, 52), 13, 1.6)
    choice = record.choice
    title = f"{choice.variant}, {choice.sensors}, {choice.direction} first, in {choice.environment}"
    body = [
        f'<text x="12" y="22" font-size="16" font-weight="bold">{escape(title)}</text>',
        _verdict(record, 12, 41, 13),
        *_drawn(record, view),
        *_legend(record, 12, 52 + height + 16),
    ]
    return _document(width, height + 80, title, body)


def multiples_svg(records: Sequence[Record]) -> str:
    """Return the picture of the runs of one world: a row for sensors, a column for a variant."""
    environment = records[0].environment
    columns = list(dict.fromkeys(each.choice.variant for each in records))
    rows = list(dict.fromkeys((e.choice.sensors, e.choice.direction) for e in records))
    canvas = _Canvas(environment, [[(r.x, r.y) for r in each.rows] for each in records])
    scale = canvas.scaled(230)
    wide, high = max(canvas.width * scale, 200) + 12, canvas.height * scale + 50
    aside = (wide - 6 - canvas.width * scale) / 2
    width = max(wide * len(columns) + 20, 560)
    about = f" ({environment.note})" if environment.note else ""
    title = f"{environment.name}{about}"
    body = [f'<text x="10" y="24" font-size="17" font-weight="bold">{escape(title)}</text>']
    body += _legend(records[0], 10, 42)
    for record in records:
        choice = record.choice
        x = 10 + columns.index(choice.variant) * wide
        y = 54 + rows.index((choice.sensors, choice.direction)) * (high + 6)
        name = f"{choice.variant}, {choice.sensors}"
        name += "" if len({d for _, d in rows}) == 1 else f", {choice.direction}"
        view = _View(canvas, scale, (x + aside, y + 36), 8.5, 2.5)
        body += [
            f'<rect class="cell" x="{x:.1f}" y="{y:.1f}" width="{wide - 6:.1f}"'
            f' height="{high - 6:.1f}"/>',
            f'<text x="{x + 6:.1f}" y="{y + 15:.1f}" font-size="12" font-weight="bold">'
            f"{escape(name)}</text>",
            _verdict(record, x + 6, y + 29, 10),
            *_drawn(record, view),
        ]
    return _document(width, 60 + len(rows) * (high + 6), title, body)


def rendered(svg: Path) -> None:
    """Write the PNG of an SVG beside it where a renderer is installed; else nothing."""
    png = svg.with_suffix(".png")
    for name, *options in (("rsvg-convert", "-z", "2", "-o"), ("resvg", "--zoom", "2")):
        program = shutil.which(name)
        if program is None:
            continue
        draft = png.with_name(f".{png.name}")
        files = [draft, svg] if name == "rsvg-convert" else [svg, draft]
        subprocess.run([program, *options, *map(str, files)], check=True, timeout=60)
        draft.replace(png)
        return


def _document(width: float, height: float, title: str, body: Iterable[str]) -> str:
    size = f"{width:.0f} {height:.0f}"
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}"'
        f' viewBox="0 0 {size}" role="img">'
    )
    back = '<rect width="100%" height="100%" fill="#fff"/>'
    named = f"<title>{escape(title)}</title>"
    return "\n".join([head, named, f"<style>{_STYLE}</style>", back, *body, "</svg>", ""])


def _verdict(record: Record, x: float, y: float, size: float) -> str:
    """Return a line that tells how a run ended."""
    parts = [record.status, f"{record.path_length:.1f} m"]
    if record.ratio is not None and record.status == "reached":
        parts[1] += f" (x{record.ratio:.1f})"
    parts.append(f"{len(record.hits)} hit{'s' * (len(record.hits) != 1)}")
    if record.reversals:
        parts.append(f"{record.reversals} turn{'s' * (record.reversals != 1)}")
    if record.collisions:
        parts.append(f"{record.collisions} collision{'s' * (record.collisions != 1)}")
    kind = "right" if record.is_right else "wrong"
    text = escape(", ".join(parts))
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" font-size="{size}">{text}</text>'


def _legend(record: Record, x: float, y: float) -> Iterator[str]:
    """Yield a line of signs with what they mean."""
    signs = [
        ('<path class="way goal" d="M0 0H22"/>', "to the goal"),
        ('<path class="way follow" d="M0 0H22"/>', "follows a wall"),
        ('<path class="line" d="M0 0H22"/>', "m-line"),
        ('<circle class="hit" cx="16" r="4"/>', "H hit"),
        ('<circle class="leave" cx="16" r="4"/>', "L leave"),
        ('<circle class="end" cx="16" r="5"/>', "end"),
    ]
    for sign, text in signs:
        yield f'<g transform="translate({x:.1f} {y:.1f})">{sign}'
        yield f'<text x="27" y="4" font-size="11">{text}</text></g>'
        x += 40 + 6.2 * len(text)


def _drawn(record: Record, view: _View) -> Iterator[str]:
    """Yield a world with a run in it."""
    world = record.environment
    for each in world.obstacles:  # a ring, and its holes
        rings = "".join(view.path(r, is_closed=True) for r in each)
        yield f'<path class="wall" d="{rings}"/>'
    if record.has_line:
        yield f'<path class="line" d="{view.path([world.start, world.goal])}"/>'
    yield from _way(record, view)
    yield from _places(record, view)


def _way(record: Record, view: _View) -> Iterator[str]:
    """Yield the path, coloured by mode, with arrows."""
    legs = list(pairwise(record.rows))
    width = f' style="stroke-width:{view.font / 6:.1f}"'
    for mode, of_mode in groupby(legs, key=lambda leg: leg[0].mode):
        part = list(of_mode)
        points = [(part[0][0].x, part[0][0].y), *((b.x, b.y) for _, b in part)]
        yield f'<path class="way {mode}" d="{view.path(_simplified(points))}"{width}/>'
    gone, size = 0.0, view.font / 2.6
    for a, b in legs:
        before, gone = gone, gone + hypot(b.x - a.x, b.y - a.y)
        if int(before / view.step) != int(gone / view.step):
            x, y = view.place((b.x, b.y))
            turn = -degrees(atan2(b.y - a.y, b.x - a.x))
            yield (
                f'<path class="head {a.mode}" d="M{size:.1f} 0L{-size:.1f} {size * 0.8:.1f}V'
                f'{-size * 0.8:.1f}Z" transform="translate({x:.1f} {y:.1f}) rotate({turn:.0f})"/>'
            )


def _places(record: Record, view: _View) -> Iterator[str]:
    """Yield the start, the goal, hit and leave points and the end, each with its name."""
    size = view.font / 3
    world, last = record.environment, record.rows[-1]
    named: list[tuple[str, Point, str]] = [("S", world.start, "start"), ("T", world.goal, "target")]
    named += [(f"H{i}", point, "hit") for i, point in enumerate(record.hits, 1)]
    named += [(f"L{i}", point, "leave") for i, point in enumerate(record.leaves, 1)]
    for _, point, kind in named:
        x, y = view.place(point)
        big = size * 1.3 if kind in ("start", "target") else size
        shape = f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="{big:.1f}"/>'
        if kind == "target":
            shape = f'<path class="target" d="{_star(x, y, size * 2)}"/>'
        yield shape
    x, y = view.place((last.x, last.y))
    yield f'<circle class="end" cx="{x:.1f}" cy="{y:.1f}" r="{size * 1.9:.1f}"/>'
    busy = [view.place((row.x, row.y)) for row in record.rows]
    corners = [p for each in world.obstacles for ring in each for p in ring]
    busy += [view.place(point) for point in corners]
    places = [(name, view.place(point)) for name, point, _ in named]
    yield from _names(places, (x, y), busy, view.font)


def _names(
    named: Sequence[tuple[str, Point]], end: Point, busy: Sequence[Point], font: float
) -> Iterator[str]:
    """Yield names beside their places, where they cover least: not the end of the path."""
    taken: list[tuple[float, float, float, float]] = []
    marks = [place for _, place in named]
    marks += [(end[0] + dx, end[1] + dy) for dx in (-4, 0, 4) for dy in (-4, 0, 4)]
    for name, (x, y) in named:
        wide = font * 0.66 * len(name)

        def box(turn: int, far: float, x: float = x, y: float = y, wide: float = wide) -> _Box:
            angle = turn * 0.7854
            middle = x + cos(angle) * (font * far + wide / 2), y - sin(angle) * font * far * 1.15
            return (
                middle[0] - wide / 2,
                middle[1] - font / 2,
                middle[0] + wide / 2,
                middle[1] + font / 2,
            )

        boxes = [box(turn, far) for far in _FAR for turn in (1, 7, 3, 5, 0, 4, 2, 6)]
        best = min(
            range(len(boxes)),
            key=lambda i: (_cost(boxes[i], taken, marks, busy), i),
        )
        taken.append(boxes[best])
        left, _, right, bottom = boxes[best]
        if best >= 2 * _TURNS:
            end = f"{(left + right) / 2:.1f} {bottom - font / 2:.1f}"
            yield f'<path class="lead" d="M{x:.1f} {y:.1f}L{end}"/>'
        yield (
            f'<text class="name" x="{(left + right) / 2:.1f}" y="{bottom - font * 0.14:.1f}"'
            f' font-size="{font}" text-anchor="middle">{name}</text>'
        )


_Box = tuple[float, float, float, float]


def _cost(box: _Box, taken: Sequence[_Box], marks: Sequence[Point], busy: Sequence[Point]) -> float:
    """Return how much a box covers: other names count most, then marks, then the path."""
    left, top, right, bottom = box
    names = sum(
        left < other[2] and other[0] < right and top < other[3] and other[1] < bottom
        for other in taken
    )
    inside = [sum(left - 2 < x < right + 2 and top - 2 < y < bottom + 2 for x, y in each)
              for each in (marks, busy)]  # fmt: skip
    return 100.0 * names + 20.0 * inside[0] + inside[1]


def _star(x: float, y: float, size: float) -> str:
    """Return a star of five rays as the data of a path."""
    points = (
        (x + sin(i * 0.62832) * r, y - cos(i * 0.62832) * r)
        for i in range(10)
        for r in ((size, size * 0.42)[i % 2],)
    )
    return "M" + "L".join(f"{px:.1f} {py:.1f}" for px, py in points) + "Z"


def _simplified(points: Sequence[Point]) -> list[Point]:
    """Return points without those that lie between their neighbours (Douglas and Peucker)."""
    keep, todo = {0, len(points) - 1}, [(0, len(points) - 1)]
    while todo:
        first, last = todo.pop()
        a, b = points[first], points[last]
        far, at = max(
            ((_off(points[i], a, b), i) for i in range(first + 1, last)), default=(0.0, 0)
        )
        if far > _TOLERANCE_M:
            keep.add(at)
            todo += [(first, at), (at, last)]
    return [points[i] for i in sorted(keep)]


def _off(point: Point, a: Point, b: Point) -> float:
    """Return how far a point is from a segment [m]."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dy * dy
    along = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / square if square else 0.0
    along = min(1.0, max(0.0, along))
    return hypot(point[0] - a[0] - along * dx, point[1] - a[1] - along * dy)
