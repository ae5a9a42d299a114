"""Model of a drawing: boxes with ports at their sides, wires between ports, sizes, a layout.

Lengths are pixels, x grows to the right and y downwards. The width of a text is estimated without
a font: rather too wide than too narrow.
"""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

_NARROW = frozenset("fijltrI.,:;'|!()[]{}/\\ \"-`")
_WIDE = frozenset("mwMWQOG@%&")
_BOLD = 1.09


def text_width(text: str, size: float, *, is_bold: bool = False) -> float:
    """Return the approximate width [pixel] of a text in a sans-serif font of this size [pixel].

    >>> text_width("il", 10) < text_width("om", 10) < text_width("日本", 10)
    True
    """
    width = sum(map(_character, text)) * size
    return width * _BOLD if is_bold else width


def _character(c: str) -> float:
    """Return the width of a character in parts of the font's size."""
    if c in _NARROW:
        return 0.41
    if c in _WIDE:
        return 0.93
    if c.isascii():
        return 0.7 if c.isupper() else 0.63
    import unicodedata

    if unicodedata.combining(c):
        return 0.0
    return 1.03 if unicodedata.east_asian_width(c) in "WFA" else 0.72


def one_line(text: str) -> str:
    """Return a text without line breaks and characters that could steer a terminal."""
    return "".join(c if c.isprintable() else " " for c in text)


def shortened(text: str, size: float, most: float) -> str:
    """Return a text that is at most so wide [pixel], its middle left out if need be."""
    if text_width(text, size) <= most:
        return text
    kept = len(text) - 1
    while kept > 2 and text_width(_without_middle(text, kept), size) > most:
        kept -= 1
    return _without_middle(text, kept)


def _without_middle(text: str, kept: int) -> str:
    head = kept - kept // 2
    return f"{text[:head]}…{text[len(text) - kept // 2 :]}"


LEFT, RIGHT = "left", "right"
IN, OUT, DATA, EVENT, SERVICE = "in", "out", "data", "event", "service"

TITLE_SIZE, SUBTITLE_SIZE, PORT_SIZE = 13, 10, 11
ROW = 20
_PADDING = 12
_BETWEEN_NAMES = 28
_LEAST_WIDTH = 90
Point = tuple[int, int]


class Size(NamedTuple):
    """Width and height of a box, a text or a drawing."""

    width: int
    height: int


class PortPin(NamedTuple):
    """A port at the left or right side of a box.

    Attributes:
        name: Empty where a wire only passes through the edge of a group.
        kind: ``in``, ``out``, ``data`` (of unknown direction), ``event`` or ``service``.
        tip: Further text, shown as a tooltip.
    """

    name: str
    side: str
    kind: str
    tip: str = ""


class Box(NamedTuple):
    """A component.

    Attributes:
        subtitle: Below the title, small.
        is_dashed: Whether it may be missing.
        inside: Its content, for a frame; see `rtkit.drawing.frames`.
        fill: Name of a colour (CSS and X11) that stands for a state; empty for the usual one.
        is_group: Whether it stands for a place, a process or a manager, and not for a component:
            wires pass its edge beside the ports inside, below the ports of its own.
        is_first: Whether all that it leads to is to its right, also where a circle leads back.
    """

    title: str
    subtitle: str
    ports: tuple[PortPin, ...] = ()
    tip: str = ""
    is_dashed: bool = False
    inside: Inside | None = None
    fill: str = ""
    is_group: bool = False
    is_first: bool = False


class WireEnd(NamedTuple):
    """An end of a wire: indices of a box and of a port of it."""

    box: int
    port: int


class Wire(NamedTuple):
    """A connector; data flows from `source` to `target`. A label is shown beside it."""

    source: WireEnd
    target: WireEnd
    kind: str = DATA
    tip: str = ""
    label: str = ""


class Frame(NamedTuple):
    """A box that holds others: a composite or a group. All are indices of boxes."""

    box: int
    members: tuple[int, ...]


class Scene(NamedTuple):
    """A whole system."""

    boxes: tuple[Box, ...]
    wires: tuple[Wire, ...]
    frames: tuple[Frame, ...] = ()


class Layout(NamedTuple):
    """A scene with its places [pixel].

    Attributes:
        places: The upper left corner of each box.
        paths: The corners of each wire, from its source to its target.
        joints: Where wires of one port part or come together.
    """

    size: Size
    places: tuple[Point, ...]
    paths: tuple[tuple[Point, ...], ...]
    joints: tuple[Point, ...] = ()


class Inside(NamedTuple):
    """Content of a frame: the scene inside, and the ports inside that its own ports lead to."""

    scene: Scene
    layout: Layout
    links: tuple[tuple[int, WireEnd], ...] = ()


def header_height(box: Box) -> int:
    """Return the height of title and subtitle."""
    return 42 if box.subtitle else 28


def box_size(box: Box) -> Size:
    """Return the size that a box needs for its texts."""
    sides = [[port for port in box.ports if port.side == side] for side in (LEFT, RIGHT)]
    rows = max(map(len, sides))
    widest = [max((text_width(p.name, PORT_SIZE) for p in ports), default=0) for ports in sides]
    names = sum(widest) + (_BETWEEN_NAMES if all(widest) else 0)
    if box.inside is not None:
        inner = box.inside.layout.size.width + 2 * _BETWEEN_NAMES
        names = max(names, inner) if box.is_group else sum(widest) + inner
    width = max(
        _LEAST_WIDTH,
        text_width(box.title, TITLE_SIZE, is_bold=True) + 2 * _PADDING,
        text_width(box.subtitle, SUBTITLE_SIZE) + 2 * _PADDING,
        names + 2 * _PADDING,
    )
    height = header_height(box) + rows * ROW + (8 if rows else 0)
    if box.inside is not None:
        height = max(height, inside_offset(box)[1] + box.inside.layout.size.height + _PADDING)
    if box.is_group:
        height = max(height, *(offset + _PADDING for offset in port_offsets(box).values()), 0)
    return Size(round(width), height)


def inside_offset(box: Box) -> tuple[int, int]:
    """Return the offset of a box's content from its upper left corner."""
    top = header_height(box) + _PADDING
    if box.is_group:  # ports of its own stand above the content
        rows = Counter(box.ports[port].side for port in _own_ports(box))
        return _PADDING + _BETWEEN_NAMES, top + max(rows.values(), default=0) * ROW
    names = [text_width(p.name, PORT_SIZE) for p in box.ports if p.side == LEFT]
    return round(max(names, default=0)) + _PADDING + _BETWEEN_NAMES, top


def port_offset(box: Box, port: int) -> int:
    """Return the distance of a port's middle from the top of its box."""
    return port_offsets(box)[port]


def port_offsets(box: Box) -> dict[int, int]:
    """Return `port_offset` of all ports of a box."""
    rows = {LEFT: 0, RIGHT: 0}
    offsets = {}
    for port in _own_ports(box) if box.is_group else range(len(box.ports)):
        side = box.ports[port].side
        offsets[port] = header_height(box) + rows[side] * ROW + ROW // 2
        rows[side] += 1
    return offsets | _offsets_through(box) if box.is_group else offsets


def _own_ports(box: Box) -> list[int]:
    """Return the ports of a group that lead to nothing inside it."""
    leading = {port for port, _ in box.inside.links} if box.inside is not None else set()
    return [port for port in range(len(box.ports)) if port not in leading]


def _offsets_through(box: Box) -> dict[int, int]:
    """Return where wires pass the edge of a group: beside the ports inside, so that they run level.

    Of two that would pass at one place the second one is led below the first.
    """
    if box.inside is None:
        return {}
    _, top = inside_offset(box)
    scene, layout = box.inside.scene, box.inside.layout
    offsets_of = {end.box: port_offsets(scene.boxes[end.box]) for _, end in box.inside.links}
    wanted = {
        port: top + layout.places[end.box][1] + offsets_of[end.box][end.port]
        for port, end in box.inside.links
    }
    offsets: dict[int, int] = {}
    for side in (LEFT, RIGHT):
        lowest = 0
        for port in sorted(
            (p for p in wanted if box.ports[p].side == side), key=wanted.__getitem__
        ):
            lowest = offsets[port] = max(wanted[port], lowest)
            lowest += ROW // 2
    return offsets
