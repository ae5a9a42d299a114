"""Chooses the side of the box for each service port: that of its partners."""

from __future__ import annotations

from collections.abc import Sequence

from rtkit.drawing.ranks import ranks
from rtkit.drawing.scene import LEFT, RIGHT, SERVICE, Box, Scene, Wire, WireEnd


def with_sides(scene: Scene) -> Scene:
    """Return a scene whose service wires lead to the right, as far as the data allow."""
    count = len(scene.boxes)
    order = _order(count, [wire for wire in scene.wires if wire.kind != SERVICE])
    wires = tuple(_turned(wire, order) for wire in scene.wires)
    order = _order(count, wires)
    votes: dict[WireEnd, int] = {}
    for wire in wires:
        if wire.kind == SERVICE:
            leads_right = order[wire.source.box] < order[wire.target.box]
            for end, sign in ((wire.source, 1), (wire.target, -1)):
                votes[end] = votes.get(end, 0) + (sign if leads_right else -sign)
    boxes = tuple(_with_votes(index, box, votes) for index, box in enumerate(scene.boxes))
    return scene._replace(boxes=boxes, wires=wires)


def _order(count: int, wires: Sequence[Wire]) -> list[int]:
    return ranks(count, [(wire.source.box, wire.target.box) for wire in wires])


def _turned(wire: Wire, order: Sequence[int]) -> Wire:
    if wire.kind == SERVICE and order[wire.source.box] > order[wire.target.box]:
        return wire._replace(source=wire.target, target=wire.source)
    return wire


def _with_votes(index: int, box: Box, votes: dict[WireEnd, int]) -> Box:
    ports = [
        port._replace(side=RIGHT if votes[WireEnd(index, place)] > 0 else LEFT)
        if WireEnd(index, place) in votes
        else port
        for place, port in enumerate(box.ports)
    ]
    return box._replace(ports=tuple(ports))
