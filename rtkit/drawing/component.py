"""Draws one component: data ports, event ports, services as balls and sockets."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rtkit.drawing.scene import (
    LEFT,
    PORT_SIZE,
    RIGHT,
    ROW,
    TITLE_SIZE,
    PortPin,
    Size,
    shortened,
    text_width,
)
from rtkit.drawing.svg import escaped, head_lines, opening, port_lines

_MARGIN = 16
_STEM = 30
_RADIUS = 7
_PADDING = 16
_HEAD = 34
_GAP = 40
_MOST_OUTSIDE = 330
STYLE = """
.rt-type{font-size:10px;fill:#4a5568}
.rt-stem{stroke:#2f855a;stroke-width:1.5;fill:none}
.rt-ball{stroke:#2f855a;stroke-width:1.5;fill:#ffffff}
"""


class InterfaceSymbol(NamedTuple):
    """An interface of a service port."""

    name: str
    type: str
    is_provided: bool


class Pin(NamedTuple):
    """A port as it is drawn: its mark and name, outside what flows through it.

    Attributes:
        outside: Text outside of the box, the data type.
        interfaces: Of a service port; each takes a row.
    """

    port: PortPin
    outside: str = ""
    interfaces: tuple[InterfaceSymbol, ...] = ()

    @property
    def rows(self) -> int:
        """Number of rows that it takes."""
        return max(1, len(self.interfaces))


def component_svg(name: str, pins: Sequence[Pin]) -> str:
    """Return the picture of a component type."""
    sides = {side: [pin for pin in pins if pin.port.side == side] for side in (LEFT, RIGHT)}
    rows = max(sum(pin.rows for pin in side) for side in sides.values())
    outside = {side: _outside_width(each) for side, each in sides.items()}
    inside = [max((_name_width(pin) for pin in each), default=0) for each in sides.values()]
    width = max(140, text_width(name, TITLE_SIZE, is_bold=True) + 2 * _PADDING, sum(inside) + _GAP)
    left = _MARGIN + outside[LEFT]
    height = _HEAD + max(rows, 1) * ROW + 10
    size = Size(round(left + width + outside[RIGHT] + _MARGIN), height + 2 * _MARGIN)
    lines = [*opening(size, "", STYLE), *_frame(name, round(left), round(width), height)]
    for side, each in sides.items():
        x = round(left) if side == LEFT else round(left) + round(width)
        y = _MARGIN + _HEAD + ROW // 2
        for pin in each:
            lines += _pin(pin, x, y)
            y += pin.rows * ROW
    return "\n".join([*lines, "</svg>"]) + "\n"


def _frame(name: str, x: int, width: int, height: int) -> Iterator[str]:
    yield f'<rect class="rt-box" x="{x}" y="{_MARGIN}" width="{width}" height="{height}" rx="4"/>'
    yield from head_lines(name, (x, _MARGIN), width, 25)


def _name_width(pin: Pin) -> float:
    return text_width(pin.port.name, PORT_SIZE) + 12


def _outside_width(pins: Sequence[Pin]) -> float:
    texts = [pin.outside for pin in pins]
    widths = [text_width(text, 10) + 14 for text in texts if text]
    widths += [
        text_width(_label(each), 10) + _STEM + 2 * _RADIUS + 8
        for pin in pins
        for each in pin.interfaces
    ]
    return max(widths, default=0)


def _label(interface: InterfaceSymbol) -> str:
    same = interface.name == interface.type or not interface.type
    text = interface.name if same else f"{interface.name}: {interface.type}"
    return shortened(text, 10, _MOST_OUTSIDE)


def _pin(pin: Pin, x: int, y: int) -> Iterator[str]:
    port = pin.port
    sign = -1 if port.side == LEFT else 1
    yield "<g>"
    if port.tip:
        yield f"<title>{escaped(port.tip)}</title>"
    for row, interface in enumerate(pin.interfaces):
        yield from _interface(interface, x, y, y + row * ROW, sign)
    yield from port_lines(port, x, y)
    if pin.outside:
        yield _outside(pin.outside, x + sign * 11, y, sign)
    yield "</g>"


def _outside(text: str, x: int, y: int, sign: int) -> str:
    side = " rt-end" if sign < 0 else ""
    return f'<text class="rt-type{side}" x="{x}" y="{y + 4}">{escaped(text)}</text>'


def _interface(each: InterfaceSymbol, x: int, y: int, at: int, sign: int) -> Iterator[str]:
    """Yield a stem with a ball (provided) or an open socket (required) at its end."""
    end = x + sign * _STEM
    bend = "" if at == y else f"h{sign * 12}V{at}"
    yield f'<path class="rt-stem" d="M{x} {y}{bend}H{end}"/>'
    middle = end + sign * _RADIUS
    if each.is_provided:
        yield f'<circle class="rt-ball" cx="{middle}" cy="{at}" r="{_RADIUS - 1}"/>'
    else:
        # The open side of the socket looks away from the box.
        sweep = 0 if sign > 0 else 1
        arc = f"M{middle} {at - _RADIUS}A{_RADIUS} {_RADIUS} 0 0 {sweep} {middle} {at + _RADIUS}"
        yield f'<path class="rt-stem" d="{arc}"/>'
    yield _outside(_label(each), middle + sign * (_RADIUS + 4), at, sign)
