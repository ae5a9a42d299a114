"""Lays out what lives: the same layout as that of pictures, with places of all boxes in one plane.

Frames are the boxes of managers, processes and composites. One that is folded is drawn without
what is in it; wires of that end at the frame.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any, NamedTuple

from rtkit.drawing.frames import framed
from rtkit.drawing.layout import laid_out
from rtkit.drawing.scene import (
    DATA,
    IN,
    LEFT,
    OUT,
    RIGHT,
    SERVICE,
    Box,
    Frame,
    Layout,
    Point,
    PortPin,
    Scene,
    Size,
    Wire,
    WireEnd,
    box_size,
    inside_offset,
    port_offsets,
)
from rtkit.web.records import Record, SystemRecords

_KINDS = {"in": IN, "out": OUT, "service": SERVICE}
_FILLS = {
    "active": "palegreen", "inactive": "lightblue", "error": "tomato", "zombie": "lightgrey",
    "restarting": "lightgrey", "unreachable": "lightgrey",
}  # fmt: skip
_DEAD = ("zombie", "restarting", "unreachable", "stuck")
_TURN = 8


class _Drawing(NamedTuple):
    """A scene, with the id of each of its boxes and wires; wires bear theirs as a tip."""

    scene: Scene
    ids: list[str]
    kinds: list[str]


class _Found(NamedTuple):
    """A layout on its way; boxes and paths are filled level by level."""

    drawing: _Drawing
    folded: Collection[str]
    boxes: dict[str, Record]
    paths: dict[str, list[Point]]
    spots: dict[str, _Spot]


def arranged(records: SystemRecords, folded: Collection[str] = ()) -> Record:
    """Return where everything is drawn [pixel]; see ``Layout`` in ``web/src/model/types.ts``."""
    drawing = _drawing(records, frozenset(folded))
    numbered = (box._replace(tip=str(n)) for n, box in enumerate(drawing.scene.boxes))
    whole = framed(drawing.scene._replace(boxes=tuple(numbered)))
    layout = laid_out(whole)
    found = _Found(drawing, folded, {}, {}, {})
    _place(whole, layout, (0, 0), None, found)
    return {
        "width": layout.size.width,
        "height": layout.size.height,
        "boxes": found.boxes,
        "paths": found.paths,
    }


def scene_of(records: SystemRecords) -> Scene:
    """Return what lives as a scene, for the exporter."""
    return _drawing(records, frozenset()).scene


def _drawing(records: SystemRecords, folded: frozenset[str]) -> _Drawing:
    parents = _parents(records)
    hidden = {id for id in parents if _folded_above(id, parents, folded) != id}
    shown = [id for id in (*records.components, *_groups(records, parents)) if id not in hidden]
    places = {id: place for place, id in enumerate(shown)}
    ports: dict[tuple[str, str], int] = {}
    boxes, kinds = [], []
    for id in shown:
        kind, box = _box(id, records)
        if id in folded and kind != "composite":
            box = box._replace(is_group=False)
        boxes.append(box)
        kinds.append(kind)
        ports |= {(id, pin.name): number for number, pin in enumerate(box.ports)}

    def end_of(end: Record, side: str) -> WireEnd | None:
        """Return where a connector ends: at its port, or at the folded frame around that."""
        owner = _folded_above(end["component"], parents, folded)
        if owner not in places:
            return None
        name = end["port"]
        if owner != end["component"]:  # a composite may show that port
            name = f"{records.components[end['component']]['name']}.{name}"
            if (owner, name) not in ports:
                name = side
        if (owner, name) not in ports:
            box = boxes[places[owner]]
            ports[owner, name] = len(box.ports)
            pin = PortPin("", side, OUT if side == RIGHT else IN)
            boxes[places[owner]] = box._replace(ports=(*box.ports, pin))
        return WireEnd(places[owner], ports[owner, name])

    wires: list[Wire] = []
    for connector in records.connectors.values():
        source, target = end_of(connector["source"], RIGHT), end_of(connector["target"], LEFT)
        if source is not None and target is not None and source.box != target.box:
            kind = boxes[source.box].ports[source.port].kind
            wires.append(
                Wire(source, target, SERVICE if kind == SERVICE else DATA, connector["id"])
            )
    held: dict[str, list[int]] = {}
    for id in shown:
        if parents.get(id) in places:
            held.setdefault(parents[id], []).append(places[id])
    frames = [Frame(places[id], tuple(members)) for id, members in held.items() if id not in folded]
    return _Drawing(Scene(tuple(boxes), tuple(wires), tuple(frames)), shown, kinds)


def _parents(records: SystemRecords) -> dict[str, str]:
    """Return the frame of each component and process: composite, process where several, manager."""
    holding: dict[str, set[str]] = {}
    for component in records.components.values():
        holding.setdefault(component["manager"], set()).add(component["process"])
    parents = {}
    for id, component in records.components.items():
        manager, process = component["manager"], component["process"]
        frame = process if len(holding[manager]) > 1 else manager
        parents[id] = component["composite"] or frame
        if frame == process != manager:
            parents[process] = manager
    return parents


def _groups(records: SystemRecords, parents: Mapping[str, str]) -> Iterator[str]:
    used = set(parents.values())
    for id in (*records.processes, *records.managers):
        if id in used:
            used.discard(id)
            yield id


def _folded_above(id: str, parents: Mapping[str, str], folded: frozenset[str]) -> str:
    """Return the outermost folded frame that something is in, or itself."""
    outermost, seen = id, {id}
    above = parents.get(id)
    while above is not None and above not in seen:
        seen.add(above)
        if above in folded:
            outermost = above
        above = parents.get(above)
    return outermost


def _box(id: str, records: SystemRecords) -> tuple[str, Box]:
    component = records.components.get(id)
    if component is not None:
        return _component_box(component)
    if id in records.managers:
        manager = records.managers[id]
        return "manager", Box(manager["name"], f"manager, pid {manager['pid']}", is_group=True)
    process = records.processes[id]
    return "process", Box(process["name"], f"slave, pid {process['pid']}", is_group=True)


def _component_box(component: Mapping[str, Any]) -> tuple[str, Box]:
    pins = tuple(
        PortPin(port["name"], LEFT if port["direction"] == "in" else RIGHT,
                _KINDS[port["direction"]], f"{port['name']} {port['type']}".strip())
        for port in component["ports"]
    )  # fmt: skip
    subtitle = " · ".join(filter(None, (component["type"], component["word"])))
    look = component["look"]
    box = Box(
        component["name"],
        subtitle,
        pins,
        "\n".join(filter(None, (component["id"], component["remark"]))),
        is_dashed=look in _DEAD,
        fill=_FILLS.get(look, ""),
    )
    return "composite" if component["members"] else "component", box


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
