"""Lays out what lives: the same layout as that of pictures, with places of all boxes in one plane.

Frames are the boxes of managers, processes and composites. One that is folded is drawn without
what is in it; wires of that end at the frame.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

from rtkit.api.live_records import Record, SystemRecords
from rtkit.api.live_scene import LiveDrawing, drawing_of
from rtkit.drawing.frames import framed
from rtkit.drawing.layout import laid_out
from rtkit.drawing.parallel import apart
from rtkit.drawing.scene import (
    LEFT,
    Box,
    Layout,
    Point,
    Scene,
    Size,
    WireEnd,
    box_size,
    inside_offset,
    port_offsets,
)

_TURN = 8
_SIGN = "●"


class _Found(NamedTuple):
    """A layout on its way; boxes and paths are filled level by level."""

    drawing: LiveDrawing
    folded: Collection[str]
    boxes: dict[str, Record]
    paths: dict[str, list[Point]]
    spots: dict[str, _Spot]


def arranged(records: SystemRecords, folded: Collection[str] = ()) -> Record:
    """Return where everything is drawn [pixel]; see ``Layout`` in ``web/src/model/types.ts``."""
    return placed(drawing_of(records, folded), folded)


def placed(drawing: LiveDrawing, folded: Collection[str] = ()) -> Record:
    """Return where the boxes and wires of a drawing are [pixel], by their ids."""
    numbered = (_with_room(box)._replace(tip=str(n)) for n, box in enumerate(drawing.scene.boxes))
    whole = framed(drawing.scene._replace(boxes=tuple(numbered)))
    layout = laid_out(whole)
    found = _Found(drawing, folded, {}, {}, {})
    _place(whole, layout, (0, 0), None, found)
    return {
        "width": layout.size.width,
        "height": layout.size.height,
        "boxes": found.boxes,
        "paths": apart(drawing.scene.wires, found.paths),
    }


def _with_room(box: Box) -> Box:
    """Return a box with room for the sign of its state, which stands in no picture but the page."""
    if box.is_group:
        return box
    subtitle = f"{_SIGN} {box.subtitle}" if box.subtitle else ""
    return box._replace(title=f"{_SIGN} {box.title}", subtitle=subtitle)


def part_of(records: SystemRecords, shown: Collection[str]) -> SystemRecords:
    """Return records with some components only, and with the connectors between these."""
    return records._replace(
        components={id: each for id, each in records.components.items() if id in shown},
        connectors={
            id: each
            for id, each in records.connectors.items()
            if each["source"]["component"] in shown and each["target"]["component"] in shown
        },
    )


def _place(scene: Scene, layout: Layout, corner: Point, parent: str | None, found: _Found) -> None:
    """Add the boxes and wires of one level of frames, and of those below."""
    for box, place in zip(scene.boxes, layout.places, strict=True):
        spot = _spot(box, _moved(place, corner))
        number = int(box.tip)
        id = found.drawing.ids[number]
        found.spots[box.tip] = spot
        found.boxes[id] = {
            "x": spot.place[0],
            "y": spot.place[1],
            "width": spot.size.width,
            "height": spot.size.height,
            "parent": parent,
            "kind": found.drawing.kinds[number],
            "is_folded": id in found.folded,
            "ports": {
                pin.name or pin.side: {"side": pin.side, "y": spot.offsets[port]}
                for port, pin in enumerate(box.ports)
                if pin.name or id in found.folded
            },
        }
        if box.inside is not None:
            _place(box.inside.scene, box.inside.layout, spot.inner, id, found)
    for wire, path in zip(scene.wires, layout.paths, strict=True):
        ends = (
            _inward(scene.boxes[end.box], end.port, found.spots)
            for end in (wire.source, wire.target)
        )
        head, tail = ends
        between = [_moved(point, corner) for point in path]
        found.paths[wire.tip] = [*reversed(head), *between, *tail]


class _Spot(NamedTuple):
    """A box in its place.

    Attributes:
        offsets: Of its ports, from its top.
        inner: The corner of what is inside.
        links: Which port inside each of its ports leads to.
    """

    place: Point
    size: Size
    offsets: Mapping[int, int]
    inner: Point
    links: Mapping[int, WireEnd]

    def edge(self, side: str) -> int:
        """Return where the left or right edge is."""
        return self.place[0] + (0 if side == LEFT else self.size.width)


def _spot(box: Box, place: Point) -> _Spot:
    links = dict(box.inside.links) if box.inside is not None else {}
    inner = _moved(inside_offset(box), place) if links or box.inside is not None else place
    return _Spot(place, box_size(box), port_offsets(box), inner, links)


def _inward(box: Box, port: int, spots: Mapping[str, _Spot]) -> list[Point]:
    """Return the corners of a wire from the edge of a frame to the port inside."""
    spot = spots[box.tip]
    end = spot.links.get(port)
    if box.inside is None or end is None:
        return []
    side = box.ports[port].side
    turn = spot.edge(side) + (_TURN if side == LEFT else -_TURN)
    inner = box.inside.scene.boxes[end.box]
    inner_spot = spots[inner.tip]
    y = inner_spot.place[1] + inner_spot.offsets[end.port]
    stop = (inner_spot.edge(inner.ports[end.port].side), y)
    start = spot.place[1] + spot.offsets[port]
    return [(turn, start), (turn, y), stop, *_inward(inner, end.port, spots)]


def _moved(point: Point, by: Point) -> Point:
    return point[0] + by[0], point[1] + by[1]
