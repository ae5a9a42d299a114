"""Writes a scene as text: components inside their frames, below each the wires that begin there."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.drawing.nesting import Nested, nested
from rtkit.drawing.scene import SERVICE, Scene, Wire, one_line

WIDTH = 80


def outline(scene: Scene, title: str = "", width: int = WIDTH) -> Iterator[str]:
    """Yield lines of at most so many characters; services have a dotted arrow."""
    if title:
        yield from (_cut(title, width), "")
    for each in nested(scene):
        for line in _lines(scene, each, ""):
            yield _cut(line, width)


def _lines(scene: Scene, each: Nested, indent: str) -> Iterator[str]:
    box = scene.boxes[each.box]
    names = f"[{box.title}]" if box.is_group else box.title
    yield f"{indent}{names}  {box.subtitle}".rstrip()
    deeper = f"{indent}  "
    for wire in scene.wires:
        if wire.source.box == each.box:
            yield f"{deeper}{_wire(scene, wire)}"
    for inner in each.inside:
        yield from _lines(scene, inner, deeper)


def _wire(scene: Scene, wire: Wire) -> str:
    port = scene.boxes[wire.source.box].ports[wire.source.port].name
    target = scene.boxes[wire.target.box]
    arrow = "..>" if wire.kind == SERVICE else "-->"
    end = f"{target.title}:{target.ports[wire.target.port].name}"
    return f"{port} {arrow} {end}  {wire.label}".rstrip()


def _cut(line: str, width: int) -> str:
    text = one_line(line)
    return text if len(text) <= width else f"{text[: width - 1]}…"
