"""Frames: enlarges the boxes of composites to hold the boxes of their members.

A wire that leaves a frame does so at a port of the frame, which leads on to the port inside.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtkit.drawing.layout import laid_out
from rtkit.drawing.nesting import parents_in
from rtkit.drawing.scene import Box, Inside, PortPin, Scene, Wire, WireEnd
from rtkit.drawing.sides import with_sides


def framed(scene: Scene) -> Scene:
    """Return a scene in which frames contain the boxes inside them."""
    return _Nesting(scene).scene(None, {})


class _Nesting:
    """Divides a flat scene into one for each frame, and one for what is in none."""

    def __init__(self, scene: Scene) -> None:
        self._boxes = [list(box.ports) for box in scene.boxes]
        self._flat = scene
        self._parents = parents_in(scene)
        self._wires: dict[int | None, list[Wire]] = {}
        self._links: dict[int, dict[WireEnd, int]] = {}
        for box, parent in self._parents.items():
            for place, port in enumerate(scene.boxes[box].ports):
                self._link_shown(parent, WireEnd(box, place), port)
        for wire in scene.wires:
            self._route(wire)

    def scene(self, frame: int | None, sides: Mapping[WireEnd, str]) -> Scene:
        """Return the boxes and wires directly inside a frame, or in none.

        A service port whose wire leaves the frame is at the side where the wire does: the sides of
        the frame's own ports are chosen before those of what is inside.

        Args:
            frame: Number of its box; None for what is in no frame.
            sides: Of the ports inside that ports of the frame lead to.
        """
        members = [i for i in range(len(self._boxes)) if self._parents.get(i) == frame]
        places = {box: place for place, box in enumerate(members)}
        wires = tuple(_moved(wire, places) for wire in self._wires.get(frame, ()))
        scene = with_sides(Scene(tuple(self._box(each, sides) for each in members), wires))
        filled = (self._filled(*each) for each in zip(members, scene.boxes, strict=True))
        return scene._replace(boxes=tuple(filled))

    def _box(self, index: int, sides: Mapping[WireEnd, str]) -> Box:
        ports = (
            port._replace(side=sides.get(WireEnd(index, place), port.side))
            for place, port in enumerate(self._boxes[index])
        )
        return self._flat.boxes[index]._replace(ports=tuple(ports))

    def _filled(self, index: int, box: Box) -> Box:
        members = sorted(i for i, parent in self._parents.items() if parent == index)
        if not members:
            return box
        places = {box: place for place, box in enumerate(members)}
        links = self._links.get(index, {}).items()
        inner = self.scene(index, {end: box.ports[port].side for end, port in links})
        ends = tuple((port, WireEnd(places[end.box], end.port)) for end, port in links)
        return box._replace(inside=Inside(inner, laid_out(inner), ends))

    def _link_shown(self, frame: int, end: WireEnd, port: PortPin) -> None:
        """Link a port of a member to the one by which its composite shows it."""
        name = self._name(end, port)  # no port of a group has that
        for place, shown in enumerate(self._boxes[frame]):
            if shown.name == name:
                self._links.setdefault(frame, {})[end] = place

    def _name(self, end: WireEnd, port: PortPin) -> str:
        return f"{self._flat.boxes[end.box].title}.{port.name}"

    def _route(self, wire: Wire) -> None:
        """Lead both ends of a wire out to where they are in one frame, or in none."""
        source, target = wire.source, wire.target
        around = list(self._around(target.box))
        while self._parents.get(source.box) not in around:
            source = self._led_out(source)
        common = self._parents.get(source.box)
        while self._parents.get(target.box) != common:
            target = self._led_out(target)
        within = self._wires.setdefault(common, [])
        within.append(wire._replace(source=source, target=target))

    def _around(self, box: int) -> Iterator[int | None]:
        """Yield the frames that a box is in, the innermost first, and None."""
        parent = self._parents.get(box)
        while parent is not None:
            yield parent
            parent = self._parents.get(parent)
        yield None

    def _led_out(self, end: WireEnd) -> WireEnd:
        frame = self._parents[end.box]
        links = self._links.setdefault(frame, {})
        if end not in links:
            port = self._boxes[end.box][end.port]
            links[end] = len(self._boxes[frame])
            is_group = self._flat.boxes[frame].is_group
            shown = port._replace(name="" if is_group else self._name(end, port))
            self._boxes[frame].append(shown)
        return WireEnd(frame, links[end])


def _moved(wire: Wire, places: dict[int, int]) -> Wire:
    source, target = wire.source, wire.target
    return wire._replace(
        source=source._replace(box=places[source.box]),
        target=target._replace(box=places[target.box]),
    )
