"""Turns what a page asks for into command lines, with what takes each back.

The command line that a step shows is what is run: the page does what the shell does, with the same
checks, errors and rights, also over several managers and hosts.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple
from uuid import uuid4

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.web.folders import granted
from rtkit.web.records import Record, Records, SystemRecords

Action = Mapping[str, Any]


class CommandStep(NamedTuple):
    """One action, ready to be done.

    Attributes:
        text: What it does, as a sentence.
        line: The command line.
        undo: The actions that take it back; None where nothing does.
        undo_reason: Why nothing does.
    """

    text: str
    line: tuple[str, ...]
    undo: tuple[Action, ...] | None = None
    undo_reason: str = ""


def steps_of(
    actions: object, records: SystemRecords, folders: Sequence[str] = ()
) -> list[CommandStep]:
    """Return the steps that actions stand for, in order; files are in the folders granted.

    Raises:
        Malformed: They are no actions; names what is wrong.
        NotFound: What they are about is not there.
        Refused: It has another value than the action expects.
    """
    if not isinstance(actions, list) or not actions:
        raise Malformed("actions: a list with one action or more is wanted")
    return [_step(each, records, folders) for each in actions]


def _step(action: object, records: SystemRecords, folders: Sequence[str]) -> CommandStep:
    if not isinstance(action, dict):
        raise Malformed(f"an action is an object, not {action!r}")
    verb = _text(action, "do")
    if verb == _SAVE:
        return _saved(action, folders)
    if verb not in _STEPS:
        known = ", ".join((*_STEPS, _SAVE))
        raise Malformed(f"do: there is no action {verb!r}; there are {known}")
    return _STEPS[verb](action, records)


def _connect(action: Action, records: SystemRecords) -> CommandStep:
    source, target = _port(action, "source", records), _port(action, "target", records)
    id = _text(action, "id", "") or str(uuid4())
    name = _text(action, "name", "")
    properties = _texts(action, "properties")
    line = ["rtcon", "-d", f"--id={id}"]
    line += [f"--name={name}"] if name else []
    line += [f"--property={key}={value}" for key, value in properties.items()]
    undo = ({"do": "disconnect", "connector": id},)
    return CommandStep(f"Connect {source} to {target}", (*line, "--", source, target), undo)


def _disconnect(action: Action, records: SystemRecords) -> CommandStep:
    connector = _found(action, "connector", records.connectors, "connector")
    source, target = (
        f"{end['component']}:{end['port']}" for end in (connector["source"], connector["target"])
    )
    again = {
        "do": "connect",
        "source": source,
        "target": target,
        "id": connector["id"],
        "name": connector["name"],
        "properties": connector["properties"],
    }
    line = ("rtdis", f"--id={connector['id']}", "--", source)
    return CommandStep(f"Disconnect {source} from {target}", line, (again,))


_STATES = {
    "activate": ("rtact", "Activate", "deactivate"),
    "deactivate": ("rtdeact", "Deactivate", "activate"),
    "reset": ("rtreset", "Reset", ""),
}


def _change_state(action: Action, records: SystemRecords) -> CommandStep:
    verb = action["do"]
    command, word, inverse = _STATES[verb]
    component = _component(action, records)
    id, number = component["id"], _context(action, component)
    line = (command, *((f"--exec_context={number}",) if number else ()), "--", id)
    if not inverse:
        return CommandStep(f"{word} {id}", line, None, "a reset has no inverse")
    context = component["contexts"][number]["id"]
    return CommandStep(
        f"{word} {id}", line, ({"do": inverse, "component": id, "context": context},)
    )


def _configure(action: Action, records: SystemRecords) -> CommandStep:
    component = _component(action, records)
    id, set_id = component["id"], _set(action, component)
    values, present = _texts(action, "values"), component["sets"][set_id]
    if not values:
        raise Malformed("values: nothing to change")
    unknown = next((name for name in values if name not in present), None)
    if unknown is not None:
        raise NotFound(f"{id} has no parameter {unknown!r} in the set {set_id!r}")
    for name, value in _texts(action, "expect").items():
        if present.get(name) != value:
            now = present.get(name)
            raise Refused(f"{name} of {id} has been changed since: it is {now!r}, not {value!r}")
    undo = {
        "do": "configure",
        "component": id,
        "set": set_id,
        "values": {name: present[name] for name in values},
        "expect": values,
    }
    pairs = [f"{name}={value}" for name, value in values.items()]
    listed = ", ".join(pairs)
    return CommandStep(
        f"Set {listed} in the set {set_id} of {id}",
        ("rtconf", f"--set={set_id}", "--", id, "set", *pairs),
        (undo,),
    )


def _activate_set(action: Action, records: SystemRecords) -> CommandStep:
    component = _component(action, records)
    id, set_id = component["id"], _set(action, component)
    undo = {"do": "activate_set", "component": id, "set": component["active_set"]}
    line = ("rtconf", f"--set={set_id}", "--", id, "act")
    return CommandStep(f"Make {set_id} the active configuration set of {id}", line, (undo,))


def _rate(action: Action, records: SystemRecords) -> CommandStep:
    component = _component(action, records)
    number = _context(action, component)
    rate = action.get("rate_hz")
    if isinstance(rate, bool) or not isinstance(rate, int | float):
        raise Malformed(f"rate_hz: a number is wanted, not {rate!r}")
    context = component["contexts"][number]
    undo = {**action, "rate_hz": context["rate_hz"]}
    target = f"{component['id']}.contexts.{number}.rate"
    return CommandStep(
        f"Set the rate of {target[:-5]} to {rate:g} Hz", ("rtset", target, f"{rate:g}"), (undo,)
    )


def _load(action: Action, records: SystemRecords) -> CommandStep:
    manager = _found(action, "manager", records.managers, "manager")["id"]
    path, init = _text(action, "path"), _text(action, "init", "")
    module = f"{path}:{init}" if init else path
    line = ("rtmgr", f"--load={module}", "--", manager)
    return CommandStep(
        f"Load {module} into {manager}", line, None, "other components may use it by then"
    )


def _create(action: Action, records: SystemRecords) -> CommandStep:
    manager = _found(action, "manager", records.managers, "manager")["id"]
    create = _text(action, "create")
    line = ("rtmgr", f"--create={create}", "--", manager)
    reason = "what was made is ended by its own action"
    return CommandStep(f"Create {create} in {manager}", line, None, reason)


def _delete(action: Action, records: SystemRecords) -> CommandStep:
    component = _component(action, records)
    id = component["id"]
    if component["look"] == "zombie":
        return CommandStep(
            f"Forget the zombie {id}", ("rtdel", "-z", "--", id), None, "it was dead"
        )
    pairs = ((wire["source"], wire["target"]) for wire in records.connectors.values())
    wires = [
        f"{source['component']}:{source['port']} to {target['component']}:{target['port']}"
        for source, target in pairs
        if id in (source["component"], target["component"])
    ]
    goes = f", and with it the connector from {' and that from '.join(wires)}" if wires else ""
    reason = f"{component['name']} has ended"
    return CommandStep(f"End {id}{goes}", ("rtexit", "--", id), None, reason)


_SAVE = "save"


def _saved(action: Action, folders: Sequence[str]) -> CommandStep:
    is_replaced = action.get("replace", False)
    file = granted(_text(action, "file"), folders, is_new=True)
    if os.path.exists(file) and is_replaced is not True:
        raise Refused(f"{file} is there already")
    line = ("rtcryo", "--all", "-o", file)
    return CommandStep(f"Save the system as {file}", line, None, "the file is written")


_STEPS: Mapping[str, Callable[[Action, SystemRecords], CommandStep]] = {
    "connect": _connect,
    "disconnect": _disconnect,
    **dict.fromkeys(_STATES, _change_state),
    "configure": _configure,
    "activate_set": _activate_set,
    "rate": _rate,
    "load": _load,
    "create": _create,
    "delete": _delete,
}


def _text(action: Action, key: str, default: str | None = None) -> str:
    value = action.get(key, default)
    if not isinstance(value, str) or "\0" in value:
        raise Malformed(f"{key}: a text is wanted, not {value!r}")
    return value


def _texts(action: Action, key: str) -> dict[str, str]:
    value = action.get(key, {})
    if not isinstance(value, dict):
        raise Malformed(f"{key}: an object is wanted, not {value!r}")
    return {name: _text(value, name) for name in value}


def _found(action: Action, key: str, records: Records, what: str) -> Record:
    id = _text(action, key)
    if id not in records:
        raise NotFound(f"No such {what}: {id}")
    return records[id]


def _component(action: Action, records: SystemRecords) -> Record:
    return _found(action, "component", records.components, "component")


def _port(action: Action, key: str, records: SystemRecords) -> str:
    path = _text(action, key)
    component, _, name = path.rpartition(":")
    known: Sequence[Record] = records.components.get(component, {}).get("ports", ())
    if all(port["name"] != name for port in known):
        raise NotFound(f"No such port: {path}")
    return path


def _set(action: Action, component: Record) -> str:
    set_id = _text(action, "set")
    if set_id not in component["sets"]:
        raise NotFound(f"{component['id']} has no configuration set {set_id!r}")
    return set_id


def _context(action: Action, component: Record) -> int:
    """Return the number of the execution context that is meant, the first one by default."""
    id = _text(action, "context", "")
    ids = [each["id"] for each in component["contexts"]]
    if not ids or (id and id not in ids):
        raise NotFound(f"{component['id']} has no execution context {id or 0}")
    return ids.index(id) if id else 0
