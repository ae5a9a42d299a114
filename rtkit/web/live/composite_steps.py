"""Steps that make composites, change what is in them and what they show, and end them."""

from __future__ import annotations

from collections.abc import Sequence

from rtkit.api.live_records import Record, SystemRecords
from rtkit.errors import NotFound, Refused
from rtkit.rtc.enums import LifeCycleState
from rtkit.web.fields import text_in, words_in
from rtkit.web.live.steps import Action, CommandStep, component_in, found_in, listed, port_in

_SET, _SHOWN = "default", "exported_ports"


def compose(action: Action, records: SystemRecords) -> CommandStep:
    """Make a composite of components of one process, with the ports that it shows."""
    process = found_in(action, "process", records.processes, "process")["id"]
    name, kind = text_in(action, "name"), text_in(action, "type", "")
    options = text_in(action, "options", "")
    members, ports = words_in(action, "members"), words_in(action, "ports")
    for each in members:
        component_in({"component": each}, records)
    for each in ports:
        port_in({"port": each}, "port", records)
    added = [_member(id, [each for each in ports if each.startswith(f"{id}:")]) for id in members]
    line = (
        "rtcomp",
        *(f"--add={each}" for each in added),
        *((f"--type={kind}",) if kind else ()),
        *((f"--options={options}",) if options else ()),
        "--",
        f"{process}:{name}",
    )
    undo = {"do": "dissolve", "process": process, "name": name}
    text = f"Make the composite {name} of {listed('component', members)}"
    return CommandStep(text, line, (undo, *_activations(members, records)))


def dissolve(action: Action, records: SystemRecords) -> CommandStep:
    """End a composite; its members live on, with the connectors of their ports."""
    whole = _composite(action, records)
    id, contexts, members = whole["id"], whole["contexts"], whole["members"]
    again = {
        "do": "compose",
        "component": id,
        "process": whole["process"],
        "name": whole["name"],
        "type": whole["type"],
        "options": f"exec_cxt.periodic.rate={contexts[0]['rate_hz']:g}" if contexts else "",
        "members": members,
        "ports": _shown(whole, records),
    }
    rest = f"; what was in it lives on: {', '.join(members)}" if members else ""
    undo = (again, *_activations([id], records))
    return CommandStep(f"Dissolve the composite {id}{rest}", ("rtexit", "--", id), undo)


def add_member(action: Action, records: SystemRecords) -> CommandStep:
    """Take a component into a composite, or have the composite show ports of a member."""
    whole, member, ports = _change(action, records)
    is_member = member in whole["members"]
    if is_member and not ports:
        raise Refused(f"{member} is in {whole['id']} already")
    line = ("rtcomp", f"--add={_member(member, ports)}", "--", whole["id"])
    undo = {
        **action,
        "do": "remove_member",
        "ports": words_in(action, "ports") if is_member else [],
    }
    what = f"Show {', '.join(ports)} at" if is_member else f"Take {member} into"
    before = [] if is_member else _activations([member], records)
    return CommandStep(f"{what} the composite {whole['id']}", line, (undo, *before))


def remove_member(action: Action, records: SystemRecords) -> CommandStep:
    """Let a member go, or have a composite show some of its ports no more."""
    whole, member, ports = _change(action, records)
    if member not in whole["members"]:
        raise NotFound(f"{member} is not in {whole['id']}")
    shown = [each.rpartition(":")[2] for each in _shown(whole, records) if _owner(each) == member]
    line = ("rtcomp", f"--remove={_member(member, ports)}", "--", whole["id"])
    names = words_in(action, "ports")
    undo = {**action, "do": "add_member", "ports": names or shown}
    what = f"Hide {', '.join(ports)} at" if ports else f"Let {member} go from"
    return CommandStep(f"{what} the composite {whole['id']}", line, (undo,))


def with_composite(action: Action, records: SystemRecords) -> SystemRecords:
    """Return records as they will be after a composite is made again, for the steps that follow."""
    id = action.get("component")
    if action["do"] != "compose" or not isinstance(id, str) or id in records.components:
        return records
    made: Record = {"id": id, "contexts": [{"id": "0"}]}
    return records._replace(components={**records.components, id: made})


def _activations(ids: Sequence[str], records: SystemRecords) -> list[Action]:
    """Return what gives components back their states: those that go in or out become inactive."""
    return [
        {"do": "activate", "component": id, "context": context["id"], "is_restored": True}
        for id in ids
        for context in records.components[id]["contexts"]
        if context["owner"] == id and context["state"] == str(LifeCycleState.ACTIVE)
    ]


def _change(action: Action, records: SystemRecords) -> tuple[Record, str, list[str]]:
    """Return the composite, the path of the member and those of its ports that are meant."""
    member = found_in(action, "member", records.components, "component")["id"]
    paths = [f"{member}:{name}" for name in words_in(action, "ports")]
    for each in paths:
        port_in({"port": each}, "port", records)
    return _composite(action, records), member, paths


def _composite(action: Action, records: SystemRecords) -> Record:
    if "component" in action:
        whole = component_in(action, records)
    else:
        process, name = text_in(action, "process"), text_in(action, "name")
        found = (
            each
            for each in records.components.values()
            if (each["process"], each["name"]) == (process, name)
        )
        whole = next(found, {})
        if not whole:
            raise NotFound(f"No such composite: {process}/{name}")
    if not whole["is_composite"]:
        raise Refused(f"{whole['id']} is no composite")
    return whole


def _shown(whole: Record, records: SystemRecords) -> list[str]:
    """Return the ports of members that a composite shows, by their own paths."""
    values = whole["sets"].get(_SET, {}).get(_SHOWN, "")
    names = frozenset(each.strip() for each in values.split(","))
    members = (records.components[id] for id in whole["members"] if id in records.components)
    return [
        f"{member['id']}:{port['name']}"
        for member in members
        for port in member["ports"]
        if f"{member['name']}.{port['name']}" in names
    ]


def _owner(port: str) -> str:
    return port.rpartition(":")[0]


def _member(id: str, ports: Sequence[str]) -> str:
    """Return a member as ``rtcomp`` takes it, with ports where some are given by their paths."""
    names = ",".join(each.rpartition(":")[2] for each in ports)
    return f"{id}:{names}" if names else id
