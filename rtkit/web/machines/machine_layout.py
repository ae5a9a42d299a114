"""Lays out state machines by the code that lays out pictures: states are boxes inside each other.

A transition is a wire from its row in the box of its state. One that leads to its own state, to one
around it or inside it, or to none, has its row only.
"""

from __future__ import annotations

from rtkit.api.live_records import Record
from rtkit.api.live_scene import LiveDrawing
from rtkit.drawing.scene import (
    IN,
    LEFT,
    OUT,
    PORT_SIZE,
    RIGHT,
    SUBTITLE_SIZE,
    Box,
    Frame,
    PortPin,
    Scene,
    Wire,
    WireEnd,
    header_height,
    shortened,
)
from rtkit.services.statemachine.model import (
    GuardedTransition,
    Machine,
    MachineAction,
    MachineState,
    is_in,
)
from rtkit.web.live.arrange import placed

_WIDEST = 230.0
"""Pixels that the text of a transition, or the summary of a state, may have."""


def machine_layout(machine: Machine) -> Record:
    """Return where states and transitions are drawn [pixel].

    ``boxes`` is by the paths of states, each with its summary, the height of its head and the texts
    of its transitions, a row of 20 pixels each; ``paths`` is by ``STATE#NUMBER``.
    """
    paths = [*machine.states]
    places = {path: place for place, path in enumerate(paths)}
    outer = {path.rpartition(".")[0] for path in paths}
    first = {machine.initial, *(each.initial for each in machine.states.values())}
    boxes = [
        _box(state, is_group=path in outer, is_first=path in first)
        for path, state in machine.states.items()
    ]
    wires = tuple(
        Wire(WireEnd(places[path], index + 1), WireEnd(places[way.to], 0), tip=f"{path}#{index}")
        for path, state in machine.states.items()
        for index, way in enumerate(state.transitions)
        if way.to in places and not is_in(path, way.to) and not is_in(way.to, path)
    )
    frames = [
        Frame(places[path], tuple(places[each] for each in machine.below(path)))
        for path in paths
        if path in outer
    ]
    kinds = ["composite" if path in outer else "state" for path in paths]
    layout = placed(LiveDrawing(Scene(tuple(boxes), wires, tuple(frames)), paths, kinds))
    for path, box in zip(paths, boxes, strict=True):
        layout["boxes"][path] |= {
            "summary": box.subtitle,
            "head": header_height(box),
            "rows": [pin.name for pin in box.ports[1:]],
        }
        del layout["boxes"][path]["ports"], layout["boxes"][path]["is_folded"]
    return layout


def _box(state: MachineState, *, is_group: bool, is_first: bool) -> Box:
    rows = (PortPin(row_text(state.path, way), RIGHT, OUT) for way in state.transitions)
    summary = shortened(_summary(state), SUBTITLE_SIZE, _WIDEST)
    name = state.path.rpartition(".")[2]
    title = f"   {name}      "  # signs of initial, final and active states stand beside it
    ports = (PortPin("", LEFT, IN), *rows)
    return Box(title, summary, ports, is_group=is_group, is_first=is_first)


def row_text(path: str, way: GuardedTransition) -> str:
    """Return a transition as state charts label it: ``event [condition] / actions``."""
    parts = [
        way.on,
        f"[{way.when.text}]" if way.when else "",
        "" if way.after is None else f"after {way.after:g} s",
    ]
    if way.actions:
        parts.append(f"/ {_targets(way.actions)}")
    text = " ".join(filter(None, parts)) or "at once"
    if not way.to:
        text += " ↺"
    elif is_in(path, way.to) or is_in(way.to, path):
        text += f" → {way.to}"
    return shortened(text, PORT_SIZE, _WIDEST)


def _summary(state: MachineState) -> str:
    lists = (("entry", state.entry), ("do", state.do), ("exit", state.exit))
    return " · ".join(f"{word}: {_targets(actions)}" for word, actions in lists if actions)


def _targets(actions: tuple[MachineAction, ...]) -> str:
    return ", ".join(each.target for each in actions)
