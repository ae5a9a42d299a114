"""Writes a scene for Graphviz: boxes as records with their ports at both sides."""

from __future__ import annotations

import re
from collections.abc import Iterator

from rtkit.drawing.nesting import Nested, nested
from rtkit.drawing.scene import LEFT, RIGHT, SERVICE, Box, Scene, WireEnd

_NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_RECORD = str.maketrans({c: f"\\{c}" for c in "{}|<> \\"})


def dot_lines(scene: Scene, title: str = "") -> Iterator[str]:
    """Yield the lines of a digraph; service wires are dashed and end in a ring."""
    name = title if _NAME.fullmatch(title) else _quoted(title or "system")
    yield f"digraph {name} {{"
    yield "  rankdir=LR;"
    yield "  node [shape=record, fontname=sans];"
    for index, box in enumerate(scene.boxes):
        if box.is_group:
            continue
        style = f", style=filled, fillcolor={box.fill}" if box.fill else ""
        yield f"  c{index} [label={_quoted(_record(box))}{style}];"
    for frame in nested(scene):
        if frame.inside:
            yield f"  {_cluster(scene, frame)}"
    for wire in scene.wires:
        look = ["arrowhead=odot", "style=dashed"] if wire.kind == SERVICE else []
        look += [f"label={_quoted(wire.label)}"] if wire.label else []
        shown = f" [{', '.join(look)}]" if look else ""
        yield f"  {_end(scene, wire.source)} -> {_end(scene, wire.target)}{shown};"
    yield "}"


def _cluster(scene: Scene, frame: Nested) -> str:
    """Return a frame with all inside it, on one line; a group is no box of its own."""
    box = scene.boxes[frame.box]
    number = next(n for n, each in enumerate(scene.frames) if each.box == frame.box)
    parts = ["style=dashed", f"c{frame.box}"]
    if box.is_group:
        parts = ["style=rounded", f"label={_quoted(' '.join((box.title, box.subtitle)))}"]
    parts += [_cluster(scene, each) if each.inside else f"c{each.box}" for each in frame.inside]
    return f"subgraph cluster{number} {{ {'; '.join(parts)}; }}"


def _end(scene: Scene, end: WireEnd) -> str:
    side = scene.boxes[end.box].ports[end.port].side
    return f"c{end.box}:p{end.port}:{'e' if side == RIGHT else 'w'}"


def _record(box: Box) -> str:
    """Return ``{{in|in}|name|{out|out}}``, in which ports have anchors."""
    parts = [_side(box, LEFT), _text(box.title), _side(box, RIGHT)]
    return "{" + "|".join(part for part in parts if part) + "}"


def _side(box: Box, side: str) -> str:
    ports = [
        f"<p{index}> {_text(port.name)}"
        for index, port in enumerate(box.ports)
        if port.side == side
    ]
    return "{" + "|".join(ports) + "}" if ports else ""


def _text(text: str) -> str:
    return " ".join(text.split()).translate(_RECORD)


def _quoted(text: str) -> str:
    # In a quoted text only the quote needs an escape; backslashes are those of the record.
    escaped = text.replace('"', '\\"').replace("\n", " ")
    return f'"{escaped}"'
