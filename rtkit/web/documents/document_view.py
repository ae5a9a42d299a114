"""Turns a system profile into records as those of what lives, with places, findings and origins.

Nothing of it runs: the ports, sets and contexts are those that the profile states, with what RTC
profiles declare of the types.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from rtkit.api.live_records import Record, Records, SystemRecords, port_record
from rtkit.component.ports.port_matching import refusal
from rtkit.deployment.described import properties_of, type_of
from rtkit.errors import NotFound
from rtkit.profile import rts_model as rts
from rtkit.profile.parameters.reading import SystemReading
from rtkit.profile.ports import DataPortFacts, DataPortKey, data_port_facts
from rtkit.profile.words import property_value, strip_instance
from rtkit.profile_tools.system_edits import BEND_POINTS, Key, PortEnd, key_of
from rtkit.profile_tools.system_summary import short_type
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import PortProfile
from rtkit.static_check.blueprint import Blueprint
from rtkit.static_check.catalogue import Catalogue
from rtkit.static_check.finding import ProfileLocation, StaticFinding

_POINT = re.compile(r"\((-?\d{1,6}),(-?\d{1,6})\)")
_WIDEST = "type unknown"
"""The page tells by findings what a component is like; a box has room for the longest of that."""
_COMPONENTS = "components"
_CONNECTORS = ("data_port_connectors", "service_port_connectors")


class DocumentView(NamedTuple):
    """A profile as it is shown.

    Attributes:
        profile: Resolved: with the values of its variables, and what it includes.
        keys: The components by the ids of their records.
        ports: Of each component, by id and name.
        origins: The file that a component or a connector comes from, where it is an included one.
    """

    profile: rts.RtsProfile
    keys: dict[str, Key]
    ports: dict[str, dict[str, PortProfile]]
    origins: dict[str, str]

    def key(self, id: str) -> Key:
        """Return the identity of a component.

        Raises:
            NotFound: There is none.
        """
        if id not in self.keys:
            raise NotFound(f"No such component: {id}")
        return self.keys[id]

    def end(self, path: str) -> PortEnd:
        """Return the port of a path, ``COMPONENT:PORT``.

        Raises:
            NotFound: There is none.
        """
        id, _, name = path.rpartition(":")
        if name not in self.ports.get(id, {}):
            raise NotFound(f"No such port: {path}")
        return PortEnd(self.keys[id], self.ports[id][name])


def viewed(
    profile: rts.RtsProfile, catalogue: Catalogue, reading: SystemReading | None = None
) -> DocumentView:
    """Return a profile as it is shown; `reading` tells which file a part comes from."""
    counts = Counter(each.instance_name for each in profile.components)
    facts = data_port_facts(profile)
    keys: dict[str, Key] = {}
    ports = {}
    for each in profile.components:
        name = each.instance_name
        id = name if counts[name] == 1 else f"{name} ({each.id})"
        match = catalogue.find(each.id)
        keys[id] = key_of(each)
        ports[id] = dict(_ports(each, facts, match.blueprint if match is not None else None))
    origins = dict(_origins(profile, list(keys), reading)) if reading is not None else {}
    return DocumentView(profile, keys, ports, origins)


def _origins(
    profile: rts.RtsProfile, ids: Sequence[str], reading: SystemReading
) -> Iterator[tuple[str, str]]:
    """Yield the parts that come from another file than the first one, with that file."""
    own = reading.files[0]
    listed = [(_COMPONENTS, ids)]
    listed += [(f, [each.connector_id for each in getattr(profile, f)]) for f in _CONNECTORS]
    for field, names in listed:
        for number, id in enumerate(names):
            file = reading.position(((field, number),), "").file
            if os.path.realpath(file) != own:
                yield id, file


def _ports(
    component: rts.ComponentInstance,
    facts: dict[DataPortKey, DataPortFacts],
    blueprint: Blueprint | None,
) -> Iterator[tuple[str, PortProfile]]:
    """Yield the ports that a component lists, then those that only its type declares."""
    data = blueprint.data_ports if blueprint is not None else {}
    services = blueprint.service_ports if blueprint is not None else {}
    listed = set()
    for each in component.data_ports:
        name = strip_instance(each.name, component.instance_name)
        listed.add(name)
        known = facts[DataPortKey(component.id, component.instance_name, name)]
        declared = data[name][0] if data.get(name) else None
        kind = known.direction or (declared.kind if declared is not None else PortType.IN)
        type = known.data_type or (declared.data_type if declared is not None else "")
        yield name, PortProfile(name, kind, {"dataport.data_type": type})
    for each in component.service_ports:
        name = strip_instance(each.name, component.instance_name)
        listed.add(name)
        yield name, PortProfile(name, PortType.SERVICE, interfaces=services.get(name, ()))
    for name, (declared, *_) in data.items():
        if name not in listed:
            properties = {"dataport.data_type": declared.data_type}
            yield name, PortProfile(name, declared.kind, properties)
    for name, interfaces in services.items():
        if name not in listed:
            yield name, PortProfile(name, PortType.SERVICE, interfaces=interfaces)


def fitting_ports(view: DocumentView, path: str) -> list[Record]:
    """Return all other ports, each with the reason why it does not fit; empty where it does.

    Raises:
        NotFound: There is no such port.
    """
    asked = view.end(path).port
    return [
        {
            "path": f"{id}:{name}",
            "type": short_type(port.data_type),
            "why": misfit(asked, port),
        }
        for id, ports in view.ports.items()
        for name, port in ports.items()
        if f"{id}:{name}" != path
    ]


def misfit(one: PortProfile, other: PortProfile) -> str:
    """Return why two ports do not go together, by the rule of `rtcon`; empty when they do."""
    return refusal((one, other), {"dataport.data_type": one.data_type or other.data_type})


def records_of_view(view: DocumentView, catalogue: Catalogue) -> SystemRecords:
    """Return the components and connectors as records, in the form of those of what lives."""
    ids = {key: id for id, key in view.keys.items()}
    owners: dict[str, str] = {}
    for each in view.profile.components:
        if each.composite_type not in (None, "None"):
            owners |= dict.fromkeys(_members(each, ids), ids[key_of(each)])
    components: Records = {}
    for each in view.profile.components:
        id = ids[key_of(each)]
        components[id] = {
            **_component(each, catalogue),
            "id": id,
            "composite": owners.get(id, ""),
            "members": [name for name in _members(each, ids) if owners.get(name) == id],
            "is_composite": each.composite_type not in (None, "None"),
            "ports": [port_record(port) for port in view.ports[id].values()],
            "origin": view.origins.get(id, ""),
        }
        for context in components[id]["contexts"]:
            context["owner"] = id
    return SystemRecords({}, {}, components, dict(_connectors(view, ids)))


def _members(component: rts.ComponentInstance, ids: dict[Key, str]) -> list[str]:
    keys = (Key(each.component_id, each.instance_name) for each in component.participants)
    return [ids[key] for key in keys if key in ids]


def _component(each: rts.ComponentInstance, catalogue: Catalogue) -> Record:
    match = catalogue.find(each.id)
    declared = match.blueprint.parameters if match is not None else {}
    location = each.location
    return {
        "name": each.instance_name,
        "type": type_of(each.id).type_name,
        "type_id": each.id,
        "description": each.comment or "",
        "manager": "", "process": "", "state": "Created", "look": "created", "word": _WIDEST,
        "remark": "", "since": 0,
        "contexts": [
            {"id": own.id, "kind": own.kind, "rate_hz": own.rate or 0, "is_running": False,
             "state": "", "owner": "", "missed": 0, "trouble": "",
             "participants": [p.instance_name for p in own.participants]}
            for own in each.execution_contexts
        ],
        "active_set": each.active_configuration_set or "",
        "sets": {own.id: {item.name: item.data or "" for item in own.data}
                 for own in each.configuration_sets},
        "widgets": {},
        "constraints": {name: own.declared.rule for name, own in declared.items()},
        "declared": {name: own.default for name, own in declared.items()},
        "properties": properties_of(each.properties),
        "path": each.path_uri,
        "is_required": each.is_required,
        "direction": location.direction if location is not None else "",
        "source": match.blueprint.source if match is not None else "",
    }  # fmt: skip


def _connectors(view: DocumentView, ids: dict[Key, str]) -> Iterator[tuple[str, Record]]:
    for field in _CONNECTORS:
        for each in getattr(view.profile, field):
            ends = [_end(end, ids) for end in (each.source, each.target)]
            if None in ends:
                continue
            record = {
                "id": each.connector_id,
                "name": each.name,
                "source": ends[0],
                "target": ends[1],
                "properties": properties_of(each.properties),
                "trouble": "",
                "origin": view.origins.get(each.connector_id, ""),
            }
            if isinstance(each, rts.DataPortConnector):
                record |= {
                    "data_type": short_type(each.data_type),
                    "interface_type": each.interface_type,
                    "dataflow_type": each.dataflow_type,
                    "subscription_type": each.subscription_type or "",
                }
            yield each.connector_id, record


def _end(end: rts.TargetPort, ids: dict[Key, str]) -> Record | None:
    id = ids.get(Key(end.component_id, end.instance_name))
    if id is None:
        return None
    return {"component": id, "port": strip_instance(end.port_name, end.instance_name)}


def places_of(view: DocumentView) -> Record:
    """Return where components stand by their profile [pixel]; of two at one place the first one.

    With it come their sizes, where they have some, and where their out ports point.
    """
    places: Record = {}
    taken = set()
    for id, each in zip(view.keys, view.profile.components, strict=True):
        at = each.location
        if at is None or (at.x, at.y) in taken or not (at.x or at.y or at.width > 0):
            continue
        taken.add((at.x, at.y))
        is_sized = at.width > 0 and at.height > 0
        size = {"width": at.width, "height": at.height} if is_sized else {}
        places[id] = {"x": at.x, "y": at.y, **size, "direction": at.direction}
    return places


def bends_of(profile: rts.RtsProfile) -> Record:
    """Return the bend points of connectors that have some [pixel]."""
    bends = {}
    for field in _CONNECTORS:
        for each in getattr(profile, field):
            text = property_value(each.properties, BEND_POINTS) or ""
            if points := [[int(x), int(y)] for x, y in _POINT.findall(text)]:
                bends[each.connector_id] = points
    return bends


def finding_records(view: DocumentView, findings: Iterable[StaticFinding]) -> list[Record]:
    """Return findings, each with the ids of what it is about."""
    return [
        {
            "severity": each.severity,
            "rule": each.rule,
            "text": each.text,
            "allowed": each.allowed,
            "on": _subject(view, each.place),
        }
        for each in findings
    ]


def _subject(view: DocumentView, place: ProfileLocation) -> str:
    """Return the id of the component or connector in which a place is; empty for neither."""
    field, number = place.steps[0] if place.steps else ("", 0)
    if field == _COMPONENTS:
        return list(view.keys)[number]
    if field in _CONNECTORS:
        return str(getattr(view.profile, field)[number].connector_id)
    return ""
