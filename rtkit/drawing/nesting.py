"""Tells which boxes of a scene are inside which."""

from __future__ import annotations

from typing import NamedTuple

from rtkit.drawing.scene import Scene


class Nested(NamedTuple):
    """A box with those inside it, by index."""

    box: int
    inside: tuple[Nested, ...]


def nested(scene: Scene) -> tuple[Nested, ...]:
    """Return the boxes that are in no frame, each with those inside it."""
    parents = parents_in(scene)

    def within(frame: int | None) -> tuple[Nested, ...]:
        found = (i for i in range(len(scene.boxes)) if parents.get(i) == frame)
        return tuple(Nested(index, within(index)) for index in found)

    return within(None)


def parents_in(scene: Scene) -> dict[int, int]:
    """Return the frame of each box; a box that would be inside itself is in none."""
    parents: dict[int, int] = {}
    for frame in scene.frames:
        for member in frame.members:
            above: int | None = frame.box
            while above is not None and above != member:
                above = parents.get(above)
            if above is None:
                parents.setdefault(member, frame.box)
    return parents
