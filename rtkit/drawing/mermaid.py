"""Writes a scene as a Mermaid flowchart: for pages that draw it themselves."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.drawing.nesting import Nested, nested
from rtkit.drawing.scene import SERVICE, Scene, Wire, one_line

_ESCAPES = str.maketrans({c: f"#{ord(c)};" for c in '"#<>&;`[]{}()|\\'})


def mermaid_lines(scene: Scene, title: str = "") -> Iterator[str]:
    """Yield the lines of a flowchart: frames are subgraphs, services dotted."""
    if title:
        yield from ("---", f'title: "{_text(title)}"', "---")
    yield "flowchart LR"
    for each in nested(scene):
        yield from _box_lines(scene, each, "  ")
    for wire in scene.wires:
        yield f"  {_wire(scene, wire)}"
    for index, box in enumerate(scene.boxes):
        style = [f"fill:{box.fill}"] if box.fill else []
        style += ["stroke-dasharray:5 3"] if box.is_dashed else []
        if style:
            yield f"  style c{index} {','.join(style)}"


def _box_lines(scene: Scene, each: Nested, indent: str) -> Iterator[str]:
    box = scene.boxes[each.box]
    label = "<br/>".join(_text(text) for text in (box.title, box.subtitle) if text)
    if not each.inside:
        yield f'{indent}c{each.box}["{label}"]'
        return
    yield f'{indent}subgraph c{each.box}["{label}"]'
    for inner in each.inside:
        yield from _box_lines(scene, inner, f"{indent}  ")
    yield f"{indent}end"


def _wire(scene: Scene, wire: Wire) -> str:
    names = [scene.boxes[end.box].ports[end.port].name for end in (wire.source, wire.target)]
    text = " → ".join(dict.fromkeys(names)) + (f" {wire.label}" if wire.label else "")
    line = "-.->" if wire.kind == SERVICE else "-->"
    return f'c{wire.source.box} {line}|"{_text(text)}"| c{wire.target.box}'


def _text(text: str) -> str:
    return " ".join(one_line(text).split()).translate(_ESCAPES)
