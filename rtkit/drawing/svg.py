"""Writes a laid-out scene as SVG without scripts or external resources; escapes every text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from rtkit.drawing import scene as s
from rtkit.drawing.frames import framed
from rtkit.drawing.layout import laid_out
from rtkit.xmltext import without_bad_characters

FONT = "font-family=\"'Noto Sans', 'DejaVu Sans', 'Helvetica Neue', Arial, sans-serif\""
_MARGIN = 24
_RADIUS = 6
_TITLE = 34
_TURN = 8
STYLE = """
.rt-box{fill:#ffffff;stroke:#4a5568;stroke-width:1.2}
.rt-head{fill:#e8eef6}
.rt-group{fill:#f7fafc;stroke:#a0aec0}
.rt-dashed{stroke-dasharray:5 3}
.rt-title{font-size:13px;font-weight:bold;fill:#1a202c;text-anchor:middle}
.rt-sub{font-size:10px;fill:#4a5568;text-anchor:middle}
.rt-name{font-size:11px;fill:#1a202c}
.rt-label{font-size:10px;fill:#2b6cb0;text-anchor:middle;paint-order:stroke;stroke:#ffffff;stroke-width:3}
.rt-end{text-anchor:end}
.rt-in,.rt-out,.rt-data{fill:#2b6cb0}
.rt-event{fill:#b7791f}
.rt-service{fill:#2f855a}
.rt-wire{fill:none;stroke:#2b6cb0;stroke-width:1.5}
.rt-wire.rt-w-service{stroke:#2f855a;stroke-dasharray:6 3}
.rt-wire.rt-w-event{stroke:#b7791f}
.rt-wire.rt-lead{stroke:#718096;stroke-width:1.2;stroke-dasharray:2 3}
.rt-halo{fill:none;stroke:#ffffff;stroke-width:5}
.rt-hit{fill:none;stroke:#000000;stroke-opacity:0;stroke-width:9}
.rt-link:hover .rt-wire{stroke-width:3}
.rt-joint{fill:#2b6cb0}
.rt-joint.rt-w-service{fill:#2f855a}
.rt-joint.rt-w-event{fill:#b7791f}
.rt-back{fill:#ffffff}
.rt-caption{font-size:15px;font-weight:bold;fill:#1a202c}
"""
_ESCAPES = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\n": "&#10;", "\r": "&#13;"}
)


def escaped(text: str) -> str:
    """Return a text as it may stand in SVG or HTML, inside elements and attributes."""
    return without_bad_characters(text).translate(_ESCAPES)


def picture(scene: s.Scene, title: str = "") -> str:
    """Return the picture of a system as SVG: members inside their composites, a title above."""
    whole = framed(scene)
    return scene_svg(whole, laid_out(whole), title)


def scene_svg(scene: s.Scene, layout: s.Layout, title: str = "") -> str:
    """Return the picture of a laid-out scene, with the title above it."""
    top = _MARGIN + (_TITLE if title else 0)
    width = layout.size.width + 2 * _MARGIN
    size = s.Size(max(width, 200), layout.size.height + top + _MARGIN)
    lines = [*opening(size, title), f'<g transform="translate({_MARGIN} {top})">']
    return "\n".join([*lines, *_scene_lines(scene, layout), "</g>", "</svg>"]) + "\n"


def _scene_lines(scene: s.Scene, layout: s.Layout) -> list[str]:
    """Return the wires of a scene, and before them its boxes."""
    lines: list[str] = []
    for group in _groups(scene):
        # Those that join are drawn together, so that none of them seems to cross the others.
        drawn = [(scene.wires[index], rounded(layout.paths[index])) for index in group]
        lines += [f'<path class="rt-halo" d="{path}"/>' for _, path in drawn]
        for wire, path in drawn:
            lines += _wire(wire, path)
        lines += [_label(scene.wires[i], layout.paths[i]) for i in group if scene.wires[i].label]
    lines += [_joint(point, scene, layout) for point in layout.joints]
    for box, place in zip(scene.boxes, layout.places, strict=True):
        lines += box_lines(box, place)
    return lines


def opening(size: s.Size, title: str, extra_style: str = "") -> Iterator[str]:
    """Yield the beginning of a picture, with its background and, if there is one, its title."""
    yield (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size.width} {size.height}"'
        f' width="{size.width}" height="{size.height}" role="img" {FONT}>'
    )
    if title:
        yield f"<title>{escaped(title)}</title>"
    yield f"<style>{STYLE}{extra_style}</style>"
    yield f'<rect class="rt-back" width="{size.width}" height="{size.height}"/>'
    if title:
        yield f'<text class="rt-caption" x="{_MARGIN}" y="{_MARGIN + 12}">{escaped(title)}</text>'


def box_lines(box: s.Box, place: s.Point) -> Iterator[str]:
    """Yield a component with its ports."""
    x, y = place
    size = s.box_size(box)
    head = s.header_height(box)
    dashed = " rt-group" * box.is_group + " rt-dashed" * box.is_dashed
    yield "<g>"
    if box.tip:
        yield f"<title>{escaped(box.tip)}</title>"
    frame = f'x="{x}" y="{y}" width="{size.width}"'
    yield f'<rect class="rt-box{dashed}" {frame} height="{size.height}" rx="4"/>'
    fill = box.fill or ("#edf2f7" if box.is_group else "")
    colour = f' style="fill:{fill}"' if fill else ""
    yield from head_lines(box.title, place, size.width, head - 3, colour)
    if box.subtitle:
        middle = x + size.width / 2
        yield f'<text class="rt-sub" x="{middle:g}" y="{y + 33}">{escaped(box.subtitle)}</text>'
    for index, port in enumerate(box.ports):
        left = x if port.side == s.LEFT else x + size.width
        yield from _port(port, left, y + s.port_offset(box, index))
    if box.inside is not None:
        yield from _inside(box, box.inside, place)
    yield "</g>"


def head_lines(
    title: str, place: s.Point, width: int, height: int, colour: str = ""
) -> Iterator[str]:
    """Yield the head of a box of this width, with the title."""
    x, y = place
    head = f"M{x + 1} {y + 1 + height}V{y + 4}q0 -3 3 -3h{width - 8}q3 0 3 3v{height - 3}z"
    yield f'<path class="rt-head"{colour} d="{head}"/>'
    yield f'<text class="rt-title" x="{x + width / 2:g}" y="{y + 18}">{escaped(title)}</text>'


def _inside(box: s.Box, inside: s.Inside, place: s.Point) -> Iterator[str]:
    """Yield the content of a frame, with lines from its own ports to those inside."""
    left, top = s.inside_offset(box)
    x, y = place[0] + left, place[1] + top
    yield f'<g transform="translate({x} {y})">'
    for port, end in inside.links:
        is_left = box.ports[port].side == s.LEFT
        edge = -left if is_left else s.box_size(box).width - left
        name = (
            round(s.text_width(box.ports[port].name, s.PORT_SIZE)) + 14 if not box.is_group else 0
        )
        start = (edge + (name if is_left else -name), s.port_offset(box, port) - top)
        inner, (inner_x, inner_y) = inside.scene.boxes[end.box], inside.layout.places[end.box]
        is_inner_left = inner.ports[end.port].side == s.LEFT
        stop = (
            inner_x + (0 if is_inner_left else s.box_size(inner).width),
            inner_y + s.port_offset(inner, end.port),
        )
        turn = start[0] + (_TURN if is_left else -_TURN)
        path = rounded((start, (turn, start[1]), (turn, stop[1]), stop))
        kind = box.ports[port].kind
        look = (f" rt-w-{kind}" * (kind in (s.SERVICE, s.EVENT))) if box.is_group else " rt-lead"
        yield f'<path class="rt-wire{look}" d="{path}"/>'
    yield from _scene_lines(inside.scene, inside.layout)
    yield "</g>"


def _port(port: s.PortPin, x: int, y: int) -> Iterator[str]:
    if not port.name:
        return
    yield "<g>"
    if port.tip:
        yield f"<title>{escaped(port.tip)}</title>"
    yield from port_lines(port, x, y)
    yield "</g>"


def port_lines(port: s.PortPin, x: int, y: int) -> Iterator[str]:
    """Yield the mark of a port at the edge of its box, and its name inside."""
    yield f'<path class="rt-{port.kind}" d="{port_shape(port.kind, x, y)}"/>'
    is_left = port.side == s.LEFT
    side = "" if is_left else " rt-end"
    at = x + 10 if is_left else x - 10
    yield f'<text class="rt-name{side}" x="{at}" y="{y + 4}">{escaped(port.name)}</text>'


def port_shape(kind: str, x: int, y: int) -> str:
    """Return the mark of a port at the edge of its box; those of data point where data go."""
    if kind in (s.SERVICE, s.DATA):
        return f"M{x - 5} {y - 5}h10v10h-10z"
    if kind == s.EVENT:
        return f"M{x - 6} {y}l6 -6l6 6l-6 6z"
    return f"M{x - 5} {y - 5}h6l5 5l-5 5h-6z"


def _groups(scene: s.Scene) -> list[list[int]]:
    """Return wires that have a port in common, as far as that goes."""
    groups: dict[s.WireEnd, list[int]] = {}
    for index, wire in enumerate(scene.wires):
        one, other = groups.get(wire.source, []), groups.get(wire.target, [])
        merged = [*one, *(() if one is other else other), index]
        for each in merged:
            groups[scene.wires[each].source] = groups[scene.wires[each].target] = merged
    return list({id(group): group for group in groups.values()}.values())


def _wire(wire: s.Wire, drawn: str) -> Iterator[str]:
    yield '<g class="rt-link">'
    if wire.tip:
        yield f"<title>{escaped(wire.tip)}</title>"
    yield f'<path class="rt-wire{_look(wire)}" d="{drawn}"/>'
    yield f'<path class="rt-hit" d="{drawn}"/>'
    yield "</g>"


def _label(wire: s.Wire, path: Sequence[s.Point]) -> str:
    """Return the label of a wire, above the longest of its level lines."""
    lines = [(abs(b[0] - a[0]), a, b) for a, b in pairwise(path) if a[1] == b[1]]
    _, one, other = max(lines, default=(0, path[0], path[-1]))
    middle = (one[0] + other[0]) / 2
    return f'<text class="rt-label" x="{middle:g}" y="{one[1] - 4}">{escaped(wire.label)}</text>'


def _look(wire: s.Wire) -> str:
    return f" rt-w-{wire.kind}" if wire.kind != s.DATA else ""


def _joint(point: s.Point, scene: s.Scene, layout: s.Layout) -> str:
    """Return the dot where wires part, which looks as they do."""
    through = (
        wire for wire, path in zip(scene.wires, layout.paths, strict=True) if _leads(path, point)
    )
    look = next(map(_look, through), "")
    return f'<circle class="rt-joint{look}" cx="{point[0]}" cy="{point[1]}" r="3"/>'


def _leads(path: Sequence[s.Point], point: s.Point) -> bool:
    """Return whether a path, upright and level lines only, leads over a point."""
    return any(
        min(one[0], other[0]) <= point[0] <= max(one[0], other[0])
        and min(one[1], other[1]) <= point[1] <= max(one[1], other[1])
        for one, other in pairwise(path)
    )


def rounded(points: Sequence[s.Point]) -> str:
    """Return the path through corners, which are rounded."""
    if not points:
        return ""
    parts = [f"M{points[0][0]} {points[0][1]}"]
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        room = min(_RADIUS, _length(before, corner) / 2, _length(corner, after) / 2)
        start, end = _towards(corner, before, room), _towards(corner, after, room)
        parts.append(f"L{start[0]:g} {start[1]:g}Q{corner[0]} {corner[1]} {end[0]:g} {end[1]:g}")
    parts.append(f"L{points[-1][0]} {points[-1][1]}")
    return "".join(parts)


def _length(one: s.Point, other: s.Point) -> int:
    return abs(one[0] - other[0]) + abs(one[1] - other[1])


def _towards(corner: s.Point, other: s.Point, distance: float) -> tuple[float, float]:
    length = _length(corner, other) or 1
    return (
        corner[0] + (other[0] - corner[0]) * distance / length,
        corner[1] + (other[1] - corner[1]) * distance / length,
    )
