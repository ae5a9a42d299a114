"""Draws the diagrams of the pages from the tables of the code: ``python tools/make_diagrams.py``.

A test checks that the files in ``docs/pictures`` are what this draws. Pictures have a background of
their own, so that they look the same on light and dark pages.
"""

from __future__ import annotations

import runpy
import tomllib
from collections.abc import Iterator, Mapping
from math import hypot
from pathlib import Path

from rtkit.component import InPort
from rtkit.component.contexts.lifecycle import ACTIVE, CALLBACK, CREATED, ERROR, INACTIVE, TABLE
from rtkit.deployment.supervision import (
    HEALTHY_S,
    LONGEST_S,
    MOST,
    WINDOW_S,
    Ledger,
    RestartPolicy,
    RestartRule,
    at_end,
)
from rtkit.drawing.component import Pin, component_svg
from rtkit.drawing.frames import framed
from rtkit.drawing.layout import laid_out
from rtkit.drawing.scene import (
    IN,
    LEFT,
    OUT,
    RIGHT,
    Box,
    Frame,
    PortPin,
    Scene,
    Size,
    Wire,
    WireEnd,
)
from rtkit.drawing.svg import escaped, opening, scene_svg
from rtkit.rtc.enums import LifeCycleState

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs" / "pictures"
_STYLE = """
.rt-note{font-size:11px;fill:#4a5568;text-anchor:middle}
.rt-left{text-anchor:start}
.rt-right{text-anchor:end}
.rt-bar{fill:#2b6cb0}
.rt-stop{fill:#c53030}
.rt-arrow{fill:#4a5568}
.rt-edge{fill:none;stroke:#4a5568;stroke-width:1.5}
"""
_WIDTH, _HEIGHT, _APART = 110, 40, 12
_PLACES: Mapping[LifeCycleState, tuple[int, int]] = {
    CREATED: (90, 60),
    INACTIVE: (330, 60),
    ACTIVE: (610, 60),
    ERROR: (470, 210),
}


def pictures() -> dict[str, str]:
    """Return the text of each picture by its file name."""
    return {
        "component.svg": _component(),
        "life-cycle.svg": _life_cycle(),
        "restart-policy.svg": _restart_policy(),
        "processes.svg": _processes(),
        "rooms.svg": _rooms(),
    }


def _svg(size: Size, lines: Iterator[str]) -> str:
    return "\n".join([*opening(size, "", _STYLE), *lines, "</svg>"]) + "\n"


def _text(kind: str, x: float, y: float, text: str) -> str:
    return f'<text class="{kind}" x="{x:g}" y="{y:g}">{escaped(text)}</text>'


def _box(x: float, y: float, width: float, height: float, title: str) -> Iterator[str]:
    frame = f'x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}"'
    yield f'<rect class="rt-box" {frame} rx="6"/>'
    yield _text("rt-title", x + width / 2, y + height / 2 + 5, title)


def _life_cycle() -> str:
    """Draw the states of a component, and the events and callbacks that lead between them."""
    return _svg(Size(720, 260), _life_cycle_lines())


def _life_cycle_lines() -> Iterator[str]:
    ways: dict[tuple[LifeCycleState, LifeCycleState], list[str]] = {}
    for state, events in TABLE.items():
        for event, target in events.items():
            callback = CALLBACK.get(event)
            text = f"{event}: {callback}" if callback else str(event)
            ways.setdefault((state, target), []).append(text)
    for (state, target), texts in ways.items():
        yield from _arrow(_PLACES[state], _PLACES[target], texts)
    for state, (x, y) in _PLACES.items():
        yield from _box(x - _WIDTH / 2, y - _HEIGHT / 2, _WIDTH, _HEIGHT, state.value)
    yield _text("rt-note", _PLACES[ACTIVE][0], _PLACES[ACTIVE][1] - 28, "on_execute at the rate")


def _arrow(start: tuple[int, int], end: tuple[int, int], texts: list[str]) -> Iterator[str]:
    """Draw an arrow between two boxes, moved to its left so that the way back has room."""
    (x, y), (u, v) = start, end
    length = hypot(u - x, v - y)
    along = ((u - x) / length, (v - y) / length)
    left = (along[1] * _APART, -along[0] * _APART)
    first, last = _exit(left, along), _exit(left, (-along[0], -along[1]))
    x, y = x + left[0] + first * along[0], y + left[1] + first * along[1]
    u, v = u + left[0] - last * along[0], v + left[1] - last * along[1]
    back = (u - 9 * along[0], v - 9 * along[1])
    wings = [(back[0] + side * along[1], back[1] - side * along[0]) for side in (4, -4)]
    tip = "".join(f"L{p:.1f} {q:.1f}" for p, q in wings)
    yield f'<path class="rt-edge" d="M{x:.1f} {y:.1f}L{back[0]:.1f} {back[1]:.1f}"/>'
    yield f'<path class="rt-arrow" d="M{u:.1f} {v:.1f}{tip}z"/>'
    middle_x, middle_y, text = (x + u) / 2, (y + v) / 2, ", ".join(texts)
    if not along[1]:
        yield _text("rt-note", middle_x, middle_y + (-6 if along[0] > 0 else 15), text)
    elif left[0] > 0:
        yield _text("rt-note rt-left", middle_x + 8, middle_y + 4, text)
    else:
        yield _text("rt-note rt-right", middle_x - 8, middle_y + 4, text)


def _exit(offset: tuple[float, float], along: tuple[float, float]) -> float:
    """Return where a line leaves a box that it begins in, beside its middle."""
    sizes = (_WIDTH / 2 + 2, _HEIGHT / 2 + 2)
    return min(
        (size - offset[axis] * (1 if along[axis] > 0 else -1)) / abs(along[axis])
        for axis, size in enumerate(sizes)
        if along[axis]
    )


def _component() -> str:
    """Draw a component type that ships, from its class."""
    file = ROOT / "examples" / "basic" / "Motor.py"
    component = runpy.run_path(str(file))["Motor"]("Motor0")
    pins = []
    for port in component.ports.values():
        is_in = isinstance(port, InPort)
        name = port.data_type.__name__
        pins.append(Pin(PortPin(port.name, LEFT if is_in else RIGHT, IN if is_in else OUT), name))
    return component_svg("Motor", pins)


def _restart_policy() -> str:
    """Draw the waits before restarts of a component that dies at once each time."""
    policy, ledger, now, waits = RestartPolicy(RestartRule.ALWAYS), Ledger(), 0.0, list[float]()
    while True:
        ledger, wait_s = at_end(ledger, policy, now, 0.0)
        if wait_s is None:
            break
        waits.append(wait_s)
        now += wait_s
    return _svg(Size(720, 50 + 26 * (len(waits) + 1)), _restart_lines(waits))


def _restart_lines(waits: list[float]) -> Iterator[str]:
    scale = 420 / sum(waits)
    left, top = 150.0, 20
    for number, wait_s in enumerate(waits, 1):
        yield _text("rt-name rt-end", 140, top + 13, f"restart {number}")
        width = wait_s * scale
        place = f'x="{left:.1f}" y="{top}" width="{width:.1f}"'
        yield f'<rect class="rt-bar" {place} height="18" rx="2"/>'
        yield _text("rt-note rt-left", left + width + 6, top + 13, f"waits {wait_s:g} s")
        left += width
        top += 26
    yield f'<rect class="rt-stop" x="{left:.1f}" y="{top}" width="18" height="18" rx="2"/>'
    yield _text("rt-name rt-end", 140, top + 13, "given up")
    law = (
        f"{MOST} restarts within {WINDOW_S:g} s; a wait is at most {LONGEST_S:g} s; "
        f"{HEALTHY_S:g} s without trouble reset the count"
    )
    yield _text("rt-note", 360, top + 42, law)


def _processes() -> str:
    """Draw a system of three components in two processes of one host."""
    into, out = PortPin("in", LEFT, IN), PortPin("out", RIGHT, OUT)
    boxes = (
        Box("In0", "ConsoleIn", (out,)),
        Box("Scale0", "Scale", (into, out)),
        Box("Out0", "ConsoleOut", (into,)),
        Box("manager", "process of the manager"),
        Box("other", "slave, a process of its own"),
    )
    wires = (Wire(WireEnd(0, 0), WireEnd(1, 0)), Wire(WireEnd(1, 1), WireEnd(2, 0)))
    scene = framed(Scene(boxes, wires, (Frame(3, (0,)), Frame(4, (1, 2)))))
    return scene_svg(scene, laid_out(scene))


def _rooms() -> str:
    """Draw the floors of the house, from the contract that the linter checks."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    (floors,) = [each["layers"] for each in contracts if each["name"] == "Arrows point down"]
    rows = [[name.strip().removeprefix("rtkit.") for name in row.split("|")] for row in floors]
    return _svg(Size(720, 40 * len(rows) + 20), _room_lines(rows))


def _room_lines(rows: list[list[str]]) -> Iterator[str]:
    for index, row in enumerate(rows):
        width = (700 - 8 * (len(row) - 1)) / len(row)
        for place, name in enumerate(row):
            yield from _box(10 + place * (width + 8), 10 + 40 * index, width, 32, name)


def write(folder: Path) -> None:
    """Write all pictures."""
    for name, text in pictures().items():
        (folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write(FOLDER)
