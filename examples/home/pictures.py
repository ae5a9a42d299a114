"""Draws what came of a run: the home from above, with ways, sightings and what was made of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from xml.sax.saxutils import escape

Point = Sequence[float]
_PIXELS = 90.0
"""Of a metre."""
_EDGE = 0.45
_MAGNIFIED = 10.0
"""Ellipses of what is known to a few centimetres are drawn larger by this."""
_COLOURS = ("#1769aa", "#b3541e", "#2e7d32", "#6a3d9a")


@dataclass
class Outcome:
    """What came of a run; lengths in metres.

    Attributes:
        rooms: Corners of each room, by name.
        walls: Rings of what is solid.
        lights: Whether each shines, and where it hangs, by name.
        paths: Where each robot went, by name.
        truth: Where the ball is.
        sightings: Where each robot saw it, by name.
        fused: Where the model has it.
        covariance: Of that [m²].
    """

    rooms: Mapping[str, Sequence[Point]]
    walls: Sequence[Sequence[Point]]
    lights: Mapping[str, tuple[bool, Point]]
    paths: Mapping[str, Sequence[Point]]
    truth: Point
    sightings: Mapping[str, Sequence[Point]] = field(default_factory=dict)
    fused: Point = ()
    covariance: Sequence[Sequence[float]] = ()


def plan(outcome: Outcome) -> str:
    """Return the home from above [SVG]."""
    corners = [corner for ring in outcome.rooms.values() for corner in ring]
    left, right = min(x for x, _ in corners), max(x for x, _ in corners)
    low, top = min(y for _, y in corners), max(y for _, y in corners)
    width, height = (right - left + 2 * _EDGE) * _PIXELS, (top - low + 2 * _EDGE) * _PIXELS

    def at(point: Point) -> tuple[float, float]:
        x, y = (point[0] - left + _EDGE) * _PIXELS, (top - point[1] + _EDGE) * _PIXELS
        return round(x, 1), round(y, 1)

    def ring(points: Sequence[Point]) -> str:
        return "M" + "L".join(f"{x} {y}" for x, y in map(at, points)) + "Z"

    legend = 28 + 22 * (len(outcome.paths) + 2)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height + legend:.0f}"'
        ' font-family="Helvetica, Arial, sans-serif" font-size="14" fill="none">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    parts += [_room(name, ring(points), at(points[3]), outcome) for name, points in
              outcome.rooms.items()]  # fmt: skip
    solid = "".join(map(ring, outcome.walls))
    parts.append(f'<path d="{solid}" fill="#4a5563" fill-rule="evenodd"/>')
    parts += [_lamp(name, is_on, at(place)) for name, (is_on, place) in outcome.lights.items()]
    for path, colour in zip(outcome.paths.values(), _COLOURS, strict=False):
        parts += _way([at(each) for each in path], colour)
    x, y = at(outcome.truth)
    parts.append(f'<circle cx="{x}" cy="{y}" r="{0.15 * _PIXELS}" fill="#f2a3a9"/>')
    for seen, colour in zip(outcome.sightings.values(), _COLOURS, strict=False):
        parts += [_cross(at(each), colour) for each in seen]
    if outcome.fused:
        parts.append(_ellipse(at(outcome.fused), outcome.covariance))
    parts += _legend(outcome, height + 8)
    return "\n".join([*parts, "</svg>"]) + "\n"


def _room(name: str, path: str, corner: Point, outcome: Outcome) -> str:
    lit = outcome.lights.get(name, (True, ()))[0]
    fill = "#fff6d6" if lit else "#dfe3e8"
    word = f"{name}, {'light' if lit else 'dark'}"
    return (
        f'<path d="{path}" fill="{fill}"/>'
        f'<text x="{corner[0] + 20}" y="{corner[1] + 22}" fill="#4a5563">{escape(word)}</text>'
    )


def _lamp(name: str, is_on: bool, place: Point) -> str:
    x, y = place
    fill = "#f5b301" if is_on else "white"
    rays = "".join(
        f"M{x + 13 * math.cos(a):.1f} {y + 13 * math.sin(a):.1f}"
        f"L{x + 19 * math.cos(a):.1f} {y + 19 * math.sin(a):.1f}"
        for a in (number * math.pi / 4 for number in range(8))
    )
    shine = f'<path d="{rays}" stroke="#b07d00" stroke-width="2"/>' if is_on else ""
    label = f"<title>{escape(name)} {'on' if is_on else 'off'}</title>"
    return f'<g>{label}<circle cx="{x}" cy="{y}" r="9" fill="{fill}" stroke="#4a5563"/>{shine}</g>'


def _way(points: Sequence[Point], colour: str) -> list[str]:
    if not points:
        return []
    line = " ".join(f"{x},{y}" for x, y in points)
    (x, y), (u, v) = points[0], points[-1]
    return [
        f'<polyline points="{line}" stroke="{colour}" stroke-width="3" stroke-linejoin="round"/>',
        f'<circle cx="{x}" cy="{y}" r="5" fill="white" stroke="{colour}" stroke-width="3"/>',
        f'<circle cx="{u}" cy="{v}" r="9" fill="{colour}"/>',
    ]


def _cross(place: Point, colour: str) -> str:
    x, y = place
    return (
        f'<path d="M{x - 4} {y - 4}L{x + 4} {y + 4}M{x - 4} {y + 4}L{x + 4} {y - 4}"'
        f' stroke="{colour}" stroke-width="1.5"/>'
    )


def _ellipse(place: Point, covariance: Sequence[Sequence[float]]) -> str:
    """Return the ellipse of one standard deviation, magnified, and the point in it."""
    x, y = place
    a, b, d = covariance[0][0], covariance[0][1], covariance[1][1]
    middle, half = (a + d) / 2, math.hypot((a - d) / 2, b)
    axes = [
        _PIXELS * _MAGNIFIED * math.sqrt(max(0.0, each)) for each in (middle + half, middle - half)
    ]
    angle = -math.degrees(math.atan2(2 * b, a - d) / 2)
    return (
        f'<ellipse cx="{x}" cy="{y}" rx="{axes[0]:.1f}" ry="{axes[1]:.1f}" stroke="#111"'
        f' stroke-width="1.5" stroke-dasharray="5 3" transform="rotate({angle:.1f} {x} {y})"/>'
        f'<circle cx="{x}" cy="{y}" r="3.5" fill="#111"/>'
    )


def _legend(outcome: Outcome, top: float) -> list[str]:
    rows = [
        (colour, f"{name}: its way from the ring to the disc, crosses where it saw the ball")
        for name, colour in zip(outcome.paths, _COLOURS, strict=False)
    ]
    rows.append(("#f2a3a9", "where the ball is"))
    if outcome.fused:
        off = 1000 * math.dist(outcome.fused[:2], outcome.truth[:2])
        text = f"where the environment model has it, {off:.0f} mm off;"
        text += f" its standard deviation is drawn {_MAGNIFIED:.0f} times as large"
        rows.append(("#111", text))
    return [
        f'<rect x="24" y="{top + 22 * row:.0f}" width="14" height="14" rx="3" fill="{colour}"/>'
        f'<text x="46" y="{top + 22 * row + 12:.0f}" fill="#1f2933">{escape(text)}</text>'
        for row, (colour, text) in enumerate(rows)
    ]
