"""Draws two systems in one picture: what is in either, with a mark at whatever differs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeVar, cast

from rtkit.api.live_records import Record
from rtkit.drawing.layout import laid_out
from rtkit.drawing.scene import box_size, port_offsets
from rtkit.fast_dataclass import replace
from rtkit.profile.rts_model import (
    ComponentInstance,
    DataPortConnector,
    RtsProfile,
    ServicePortConnector,
    TargetPort,
)
from rtkit.profile.words import strip_instance
from rtkit.profile_tools.system_scene import system_scene

CHANGED = "~"
_C = TypeVar("_C", DataPortConnector, ServicePortConnector)


def pictured(before: RtsProfile, after: RtsProfile, marks: Mapping[str, str]) -> Record:
    """Return the drawing of two systems: size, boxes and wires with their places [pixel].

    Args:
        before: A system.
        after: Another one.
        marks: ``+``, ``-``, ``~`` of components by instance name, and of wires by `wire_name`.
    """
    profile = _merged(before, after)
    scene = system_scene(profile)._replace(frames=())
    layout = laid_out(scene)
    boxes = []
    for box, (x, y) in zip(scene.boxes, layout.places, strict=True):
        size, offsets = box_size(box), port_offsets(box)
        boxes.append(
            {
                "id": box.title, "type": box.subtitle, "mark": marks.get(box.title, ""),
                "x": x, "y": y, "width": size.width, "height": size.height,
                "ports": [
                    {"name": pin.name, "side": pin.side, "y": offsets[n]}
                    for n, pin in enumerate(box.ports)
                ],
            }
        )  # fmt: skip
    wires = []
    for wire, path in zip(scene.wires, layout.paths, strict=True):
        ends = (
            f"{scene.boxes[end.box].title}.{scene.boxes[end.box].ports[end.port].name}"
            for end in (wire.source, wire.target)
        )
        id = wire_name(*ends)
        wires.append({"id": id, "mark": marks.get(id, ""), "path": path})
    return {
        "width": layout.size.width,
        "height": layout.size.height,
        "boxes": boxes,
        "wires": wires,
    }


def wire_name(one: str, other: str) -> str:
    """Return the name of a wire in a picture, by its ends ``INSTANCE.PORT``, in any order."""
    return " -- ".join(sorted((one, other)))


def marks_of(facts: Iterable[Record], wholes: Callable[[Record], bool]) -> dict[str, str]:
    """Return the mark of each subject of facts.

    Args:
        facts: Each with its ``subject`` and ``mark``.
        wholes: Tells whether a fact is about all of its subject, and not a part of it.
    """
    marks: dict[str, str] = {}
    for fact in facts:
        if wholes(fact):
            marks[fact["subject"]] = fact["mark"]
        else:
            marks.setdefault(fact["subject"], CHANGED)
    return marks


def subject_in(name: str, profiles: Iterable[RtsProfile]) -> str:
    """Return what a thing of ``rtprofile diff`` is part of: a component, a wire, or nothing."""
    for between in (" -> ", " -- "):
        if between in name:
            return wire_name(*name.split(between, 1))
    names = {each.instance_name for profile in profiles for each in profile.components}
    owners = [each for each in names if name == each or name.startswith((f"{each}.", f"{each} "))]
    return max(owners, key=len, default="")


def subject_at(path: str, profiles: Iterable[RtsProfile]) -> str:
    """Return what a path of ``rtcheck`` leads to: a component, or a wire between two ports."""
    names = {
        f"/{each.path_uri}": each.instance_name
        for profile in profiles
        for each in profile.components
    }
    ends = []
    for part in path.split(" "):
        component, _, port = part.rpartition(":") if part not in names else (part, "", "")
        name = names.get(component, component)
        ends.append((name, port))
    if len(ends) == 2:
        return wire_name(*(f"{name}.{port}" for name, port in ends))
    return ends[0][0]


def _merged(before: RtsProfile, after: RtsProfile) -> RtsProfile:
    """Return a system with everything that is in either."""
    former = {each.instance_name: each for each in before.components}
    components = [_with_ports(each, former.get(each.instance_name)) for each in after.components]
    there = {each.instance_name for each in components}
    components += [each for each in before.components if each.instance_name not in there]
    ids = {each.instance_name: each.id for each in components}
    return replace(
        after,
        components=tuple(components),
        data_port_connectors=tuple(
            _both(before.data_port_connectors, after.data_port_connectors, ids)
        ),
        service_port_connectors=tuple(
            _both(before.service_port_connectors, after.service_port_connectors, ids)
        ),
    )


def _with_ports(now: ComponentInstance, former: ComponentInstance | None) -> ComponentInstance:
    if former is None:
        return now
    names = {each.name for each in (*now.data_ports, *now.service_ports)}
    return replace(
        now,
        data_ports=(*now.data_ports, *(p for p in former.data_ports if p.name not in names)),
        service_ports=(
            *now.service_ports,
            *(p for p in former.service_ports if p.name not in names),
        ),
    )


def _both(before: Iterable[_C], after: Iterable[_C], ids: Mapping[str, str]) -> Iterator[_C]:
    """Yield each connector once; its ends are those of components of the merged system."""
    known = set()
    for each in (*after, *before):
        name = wire_name(_end(each.source), _end(each.target))
        if name not in known:
            known.add(name)
            source, target = (
                replace(end, component_id=ids.get(end.instance_name, end.component_id))
                for end in (each.source, each.target)
            )
            yield cast(_C, replace(each, source=source, target=target))


def _end(end: TargetPort) -> str:
    return f"{end.instance_name}.{strip_instance(end.port_name, end.instance_name)}"
