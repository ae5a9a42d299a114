"""Lays a scene out deterministically: boxes in columns, wires between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rtkit.drawing.scene import Box, Layout, Point, Scene, Size, Wire, WireEnd
from rtkit.drawing.wrapping import WIDEST, wrapped

_BETWEEN = 40
_ASPECT = 1.7


def laid_out(scene: Scene, widest: int = WIDEST) -> Layout:
    """Return the layout of a scene; parts without wires between them are put side by side.

    A part that is wider than `widest` goes on in further rows, where that makes it easier to read.
    """
    islands = list(_islands(scene))
    parts = [wrapped(*_part(scene, island), widest) for island in islands]
    corners = _packed([part.size for part in parts])
    places: list[Point] = [(0, 0)] * len(scene.boxes)
    paths: list[tuple[Point, ...]] = [()] * len(scene.wires)
    joints: list[Point] = []
    for island, part, (x, y) in zip(islands, parts, corners, strict=True):
        for box, (left, top) in zip(island.boxes, part.places, strict=True):
            places[box] = (x + left, y + top)
        for wire, path in zip(island.wires, part.paths, strict=True):
            paths[wire] = tuple((x + left, y + top) for left, top in path)
        joints += [(x + left, y + top) for left, top in part.joints]
    placed = list(zip(parts, corners, strict=True))
    width = max((x + part.size.width for part, (x, _) in placed), default=0)
    height = max((y + part.size.height for part, (_, y) in placed), default=0)
    return Layout(Size(width, height), tuple(places), tuple(paths), tuple(joints))


class _Island(NamedTuple):
    """Boxes that hang together, and the wires between them."""

    boxes: list[int]
    wires: list[int]


def _islands(scene: Scene) -> Iterator[_Island]:
    """Yield connected boxes with their wires, in the order of the boxes."""
    leader = list(range(len(scene.boxes)))

    def lead(box: int) -> int:
        while leader[box] != box:
            leader[box] = leader[leader[box]]
            box = leader[box]
        return box

    for wire in scene.wires:
        one, other = sorted((lead(wire.source.box), lead(wire.target.box)))
        leader[other] = one
    islands: dict[int, _Island] = {}
    for box in range(len(scene.boxes)):
        islands.setdefault(lead(box), _Island([], [])).boxes.append(box)
    for index, wire in enumerate(scene.wires):
        islands[lead(wire.source.box)].wires.append(index)
    yield from islands.values()


def _part(scene: Scene, island: _Island) -> tuple[list[Box], list[Wire]]:
    index = {box: place for place, box in enumerate(island.boxes)}

    def moved(end: WireEnd) -> WireEnd:
        return end._replace(box=index[end.box])

    wires = [scene.wires[wire] for wire in island.wires]
    moved_wires = [
        wire._replace(source=moved(wire.source), target=moved(wire.target)) for wire in wires
    ]
    return [scene.boxes[box] for box in island.boxes], moved_wires


def _packed(sizes: Sequence[Size]) -> list[Point]:
    """Return a place for each part: shelves from above, large parts first."""
    area = sum((size.width + _BETWEEN) * (size.height + _BETWEEN) for size in sizes)
    width = max((size.width for size in sizes), default=0)
    width = max(width, round((area * _ASPECT) ** 0.5))
    order = sorted(range(len(sizes)), key=lambda i: (-sizes[i].height, i))
    corners: list[Point] = [(0, 0)] * len(sizes)
    x = y = shelf = 0
    for index in order:
        size = sizes[index]
        if x and x + size.width > width:
            x, y, shelf = 0, y + shelf + _BETWEEN, 0
        corners[index] = (x, y)
        x += size.width + _BETWEEN
        shelf = max(shelf, size.height)
    return corners
