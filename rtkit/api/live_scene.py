"""Draws what lives: states, zombies and rates; managers, processes and composites as frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rtkit.api import looking
from rtkit.api.rates import RateRow, measured
from rtkit.api.session import Session
from rtkit.drawing.scene import Box, Frame, Scene, Wire, WireEnd
from rtkit.errors import Unreachable
from rtkit.tree.connect import connect
from rtkit.tree.place import others

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts, ProcessFacts, Snapshot

_FILLS = {"Active": "palegreen", "Inactive": "lightblue", "Error": "tomato", "zombie": "lightgrey"}
_Rates = Mapping[str, RateRow]


def live_scene(session: Session, title: str, *, has_rates: bool = False) -> Scene:
    """Return the scene of the live components of the manager, and of the others of this host.

    Args:
        session: It finds the managers.
        title: Names the scene.
        has_rates: Measure rates, which takes a second.

    Raises:
        Unreachable: A manager does not answer.
    """
    snapshots = [looking.snapshot(session)]
    rates = [measured(session.tree) if has_rates else {}]
    for name in others(session.tree) if session.finds_managers else ():
        try:
            with connect(name, session.timeout_s) as tree:
                snapshots.append(tree.snapshot())
                rates.append(measured(tree) if has_rates else {})
        except Unreachable:
            if ":" not in name:  # a permanent server that is silent is reported by the command
                raise
    is_framed = len(snapshots) > 1
    pairs = zip(snapshots, rates, strict=True)
    return _joined([_of_manager(one, title, rate, is_framed=is_framed) for one, rate in pairs])


def _of_manager(snapshot: Snapshot, title: str, rates: _Rates, *, is_framed: bool) -> Scene:
    from rtkit.deployment.capture import SystemHeading, capture
    from rtkit.fast_dataclass import replace
    from rtkit.profile_tools.system_scene import system_scene

    # A saved system has no zombies; a drawing shows them.
    shown = tuple(replace(each, zombie="") for each in snapshot.components)
    heading = SystemHeading("1970-01-01T00:00:00", title, "0", "rtkit", "")
    scene = system_scene(capture(replace(snapshot, components=shown), heading, takes_all=True))
    facts = {each.instance: each for each in snapshot.components}
    names = [box.title for box in scene.boxes]
    boxes = [_box(box, facts[box.title], rates.get(box.title)) for box in scene.boxes]
    wires = tuple(wire._replace(label=_rate_of(wire, boxes, rates)) for wire in scene.wires)
    held: dict[str, list[int]] = {}
    for index, name in enumerate(names):
        held.setdefault(facts[name].process, []).append(index)
    processes = [each for each in snapshot.processes if each.name in held]
    frames = list(scene.frames)
    if len(processes) > 1:
        # The frame of a manager says already where components in its own process are.
        for process in (each for each in processes if each.pid != snapshot.pid or not is_framed):
            frames.append(Frame(len(boxes), tuple(held[process.name])))
            boxes.append(_process_box(process))
    if is_framed:
        frames.append(Frame(len(boxes), tuple(range(len(boxes)))))
        boxes.append(Box(snapshot.manager, f"manager, pid {snapshot.pid}", is_group=True))
    return Scene(tuple(boxes), wires, tuple(frames))


def _box(box: Box, facts: ComponentFacts, rate: RateRow | None) -> Box:
    state = "zombie" if facts.zombie else facts.state
    parts = [box.subtitle, state, _hertz(rate.reached_hz if rate else None)]
    why = f"zombie ({facts.zombie})" if facts.zombie else facts.trouble or facts.cause
    return box._replace(
        subtitle=" · ".join(filter(None, (*parts, facts.trouble))),
        tip="\n".join(filter(None, (box.tip, facts.process, why))),
        fill=_FILLS.get(state, ""),
        is_dashed=bool(facts.zombie or facts.trouble),
    )


def _process_box(process: ProcessFacts) -> Box:
    what = (
        "slave" if process.is_slave else "process" if process.is_guest else "manager's own process"
    )
    parts = () if process.state == "up" else (process.state, process.reason)
    state = ": ".join(filter(None, parts))
    subtitle = " · ".join(filter(None, (what, f"pid {process.pid}" * bool(process.pid), state)))
    return Box(process.name, subtitle, is_dashed=bool(state), is_group=True)


def _rate_of(wire: Wire, boxes: Sequence[Box], rates: _Rates) -> str:
    """Return how often values come out of the port at which a wire begins."""
    box = boxes[wire.source.box]
    row = rates.get(box.title)
    return _hertz((row.written_hz or {}).get(box.ports[wire.source.port].name)) if row else ""


def _hertz(rate: float | None) -> str:
    return "" if rate is None else f"{float(f'{rate:.3g}'):g} Hz"


def _joined(scenes: Sequence[Scene]) -> Scene:
    """Return several scenes as one."""
    boxes: list[Box] = []
    wires: list[Wire] = []
    frames: list[Frame] = []
    for scene in scenes:
        base = len(boxes)
        boxes += scene.boxes
        frames += [
            Frame(frame.box + base, tuple(member + base for member in frame.members))
            for frame in scene.frames
        ]
        for wire in scene.wires:
            source, target = (WireEnd(e.box + base, e.port) for e in (wire.source, wire.target))
            wires.append(wire._replace(source=source, target=target))
    return Scene(tuple(boxes), tuple(wires), tuple(frames))
