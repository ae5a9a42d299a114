"""Draws what lives: states, zombies and rates; managers, processes and composites as frames."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

from rtkit.api import looking
from rtkit.api.live_records import KnownManager, Record, SystemRecords, records_of
from rtkit.api.rates import RateRow, measured
from rtkit.api.session import Session
from rtkit.drawing.scene import (
    DATA,
    IN,
    LEFT,
    OUT,
    RIGHT,
    SERVICE,
    Box,
    Frame,
    PortPin,
    Scene,
    Wire,
    WireEnd,
)
from rtkit.drawing.sides import with_sides
from rtkit.errors import Unreachable
from rtkit.link.places import host_name, usual_manager
from rtkit.rtc.names import LOCAL
from rtkit.tree.connect import connect
from rtkit.tree.place import others

_KINDS = {"in": IN, "out": OUT, "service": SERVICE}
_FILLS = {
    "active": "palegreen", "inactive": "lightblue", "error": "tomato", "zombie": "lightgrey",
    "restarting": "lightgrey", "unreachable": "lightgrey",
}  # fmt: skip
_DEAD = ("zombie", "restarting", "unreachable", "stuck")
_NOTHING: Mapping[str, str] = {}


class LiveDrawing(NamedTuple):
    """A scene, with the id and the kind of each of its boxes; wires have their id as a tip."""

    scene: Scene
    ids: list[str]
    kinds: list[str]


def live_scene(session: Session, *, has_rates: bool = False) -> Scene:
    """Return the scene of the live components of the manager, and of the others of this host.

    Args:
        session: It finds the managers.
        has_rates: Measure rates, which takes a second.

    Raises:
        Unreachable: A manager does not answer.
    """
    own = looking.snapshot(session)
    managers = [KnownManager(own.manager, LOCAL, own.manager == usual_manager(), own)]
    rates = [measured(session.tree) if has_rates else {}]
    for name in others(session.tree) if session.finds_managers else ():
        try:
            with connect(name, session.timeout_s) as tree:
                facts = tree.snapshot()
                managers.append(KnownManager(facts.manager, LOCAL, is_usual=False, facts=facts))
                rates.append(measured(tree) if has_rates else {})
        except Unreachable:
            if ":" not in name:  # a permanent server that is silent is reported by the command
                raise
    records = records_of(managers, host_name())
    known = zip(managers, rates, strict=True)
    rows = {
        each.path(c, host_name()): rows[c.instance]
        for each, rows in known
        for c in each.facts.components
        if c.instance in rows
    }
    notes = {id: _note(each, rows.get(id)) for id, each in records.components.items()}
    labels = {id: _rate(each["source"], rows) for id, each in records.connectors.items()}
    return drawing_of(records, notes=notes, labels=labels).scene


def _note(component: Record, row: RateRow | None) -> str:
    trouble = component["remark"] if component["look"] == "stuck" else ""
    return " · ".join(filter(None, (_hertz(row.reached_hz if row else None), trouble)))


def _rate(source: Record, rows: Mapping[str, RateRow]) -> str:
    """Return how often values come out of the port at which a wire begins."""
    row = rows.get(source["component"])
    return _hertz((row.written_hz or {}).get(source["port"])) if row else ""


def _hertz(rate: float | None) -> str:
    return "" if rate is None else f"{float(f'{rate:.3g}'):g} Hz"


def drawing_of(
    records: SystemRecords,
    folded: Collection[str] = (),
    *,
    notes: Mapping[str, str] = _NOTHING,
    labels: Mapping[str, str] = _NOTHING,
) -> LiveDrawing:
    """Return what lives as a drawing; a frame that is folded is drawn without what is in it.

    Args:
        records: What lives.
        folded: Ids of frames.
        notes: Texts for the boxes of components, by their ids.
        labels: Texts beside wires, by the ids of connectors.
    """
    parents = _parents(records)
    hidden = {id for id in parents if _folded_above(id, parents, folded) != id}
    shown = [id for id in (*records.components, *_groups(records, parents)) if id not in hidden]
    places = {id: place for place, id in enumerate(shown)}
    ports: dict[tuple[str, str], int] = {}
    boxes, kinds = [], []
    for id in shown:
        kind, box = _box(id, records, notes.get(id, ""))
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
            is_service = boxes[source.box].ports[source.port].kind == SERVICE
            id = connector["id"]
            kind = SERVICE if is_service else DATA
            wires.append(Wire(source, target, kind, id, labels.get(id, "")))
    held: dict[str, list[int]] = {}
    for id in shown:
        if parents.get(id) in places:
            held.setdefault(parents[id], []).append(places[id])
    frames = [Frame(places[id], tuple(members)) for id, members in held.items() if id not in folded]
    scene = with_sides(Scene(tuple(boxes), tuple(wires), tuple(frames)))
    return LiveDrawing(scene, shown, kinds)


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


def _folded_above(id: str, parents: Mapping[str, str], folded: Collection[str]) -> str:
    """Return the outermost folded frame that something is in, or itself."""
    outermost, seen = id, {id}
    above = parents.get(id)
    while above is not None and above not in seen:
        seen.add(above)
        if above in folded:
            outermost = above
        above = parents.get(above)
    return outermost


def _box(id: str, records: SystemRecords, note: str) -> tuple[str, Box]:
    component = records.components.get(id)
    if component is not None:
        return _component_box(component, note)
    if id in records.managers:
        manager = records.managers[id]
        return "manager", Box(manager["name"], f"manager, pid {manager['pid']}", is_group=True)
    process = records.processes[id]
    state = "" if process["state"] == "up" else process["state"]
    parts = ("slave" if process["is_slave"] else "process", f"pid {process['pid']}",
             ": ".join(filter(None, (state, process["why"]))))  # fmt: skip
    subtitle = " · ".join(filter(None, parts))
    return "process", Box(process["name"], subtitle, is_dashed=bool(state), is_group=True)


def _component_box(component: Record, note: str) -> tuple[str, Box]:
    pins = tuple(
        PortPin(port["name"], LEFT if port["direction"] == "in" else RIGHT,
                _KINDS[port["direction"]], f"{port['name']} {port['type']}".strip())
        for port in component["ports"]
    )  # fmt: skip
    subtitle = " · ".join(filter(None, (component["type"], component["word"], note)))
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
