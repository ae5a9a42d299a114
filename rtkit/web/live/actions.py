"""Turns what a page asks for into command lines, with what takes each back.

The command line that a step shows is what is run: the page does what the shell does, with the same
checks, errors and rights, also over several managers and hosts.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from uuid import uuid4

from rtkit.api.live_records import SystemRecords
from rtkit.errors import Malformed, Refused
from rtkit.web.fields import text_in, texts_in
from rtkit.web.folders import granted
from rtkit.web.live import composite_steps, configuration_steps, context_steps, manager_steps
from rtkit.web.live.steps import Action, CommandStep, component_in, context_in, found_in, port_in
from rtkit.web.machines import machine_steps
from rtkit.web.plans.ordering import ordered
from rtkit.web.properties.property_steps import ValueOf, set_value


def steps_of(
    actions: object, records: SystemRecords, folders: Sequence[str], value_of: ValueOf
) -> list[CommandStep]:
    """Return the steps that actions stand for, in order; it blocks while values are asked for.

    Args:
        actions: What a page asks for.
        records: What lives.
        folders: Those that are granted; files are in them.
        value_of: Asks for the value of a property.

    Raises:
        Malformed: They are no actions; names what is wrong.
        NotFound: What they are about is not there.
        Refused: It has another value than the action expects.
    """
    if not isinstance(actions, list) or not actions:
        raise Malformed("actions: a list with one action or more is wanted")
    steps = []
    for each in actions:
        steps.append(_step(each, records, folders, value_of))
        records = configuration_steps.with_sets(each, records)
        records = composite_steps.with_composite(each, records)
    return steps


def _step(
    action: object, records: SystemRecords, folders: Sequence[str], value_of: ValueOf
) -> CommandStep:
    if not isinstance(action, dict):
        raise Malformed(f"an action is an object, not {action!r}")
    verb = text_in(action, "do")
    if verb == _SET:
        return set_value(action, value_of)
    if verb in _OF_FILES:
        return _OF_FILES[verb](action, folders)
    if verb not in _STEPS:
        known = ", ".join((*_STEPS, *_OF_FILES, _SET))
        raise Malformed(f"do: there is no action {verb!r}; there are {known}")
    return _STEPS[verb](action, records)


def _connect(action: Action, records: SystemRecords) -> CommandStep:
    source, target = port_in(action, "source", records), port_in(action, "target", records)
    id = text_in(action, "id", "") or str(uuid4())
    name = text_in(action, "name", "")
    properties = texts_in(action, "properties")
    line = ["rtcon", "-d", f"--id={id}"]
    line += [f"--name={name}"] if name else []
    line += [f"--property={key}={value}" for key, value in properties.items()]
    undo = ({"do": "disconnect", "connector": id},)
    return CommandStep(f"Connect {source} to {target}", (*line, "--", source, target), undo)


def _disconnect(action: Action, records: SystemRecords) -> CommandStep:
    connector = found_in(action, "connector", records.connectors, "connector")
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
    component = component_in(action, records)
    id, number = component["id"], context_in(action, component)
    line = (command, *((f"--exec_context={number}",) if number else ()), "--", id)
    if not inverse:
        return CommandStep(f"{word} {id}", line, None, "a reset has no inverse")
    context = component["contexts"][number]["id"]
    again = {"do": inverse, "component": id, "context": context}
    # What takes a restored state away again is the inverse of the step that restores the rest.
    return CommandStep(f"{word} {id}", line, () if action.get("is_restored") else (again,))


def _inject(action: Action, records: SystemRecords) -> CommandStep:
    path, value = port_in(action, "port", records), text_in(action, "value")
    component, _, name = path.rpartition(":")
    ports = {each["name"]: each for each in records.components[component]["ports"]}
    if ports[name]["direction"] != "in":
        raise Refused(f"{path} is no in port")
    line = ("rtinject", f"--const={value}", "--", path)
    return CommandStep(f"Write {value} to {path}", line, None, "a value has been read by then")


def _saved(action: Action, folders: Sequence[str]) -> CommandStep:
    is_replaced = action.get("replace", False)
    file = granted(text_in(action, "file"), folders, is_new=True)
    if os.path.exists(file) and is_replaced is not True:
        raise Refused(f"{file} is there already")
    line = ("rtcryo", "--all", "-o", file)
    return CommandStep(f"Save the system as {file}", line, None, "the file is written")


_SET = "set"
_OF_FILES: Mapping[str, Callable[[Action, Sequence[str]], CommandStep]] = {
    "save": _saved,
    "order": ordered,
    **machine_steps.STEPS,
}
_STEPS: Mapping[str, Callable[[Action, SystemRecords], CommandStep]] = {
    "connect": _connect,
    "disconnect": _disconnect,
    **dict.fromkeys(_STATES, _change_state),
    "configure": configuration_steps.configure,
    "activate_set": configuration_steps.activate_set,
    "add_set": configuration_steps.add_set,
    "remove_set": configuration_steps.remove_set,
    "rate": context_steps.rate,
    "attach": context_steps.attach,
    "detach": context_steps.detach,
    "load": manager_steps.load,
    "unload": manager_steps.unload,
    "create": manager_steps.create,
    "delete": manager_steps.delete,
    "forget_zombies": manager_steps.forget_zombies,
    "fork": manager_steps.fork,
    "end_slave": manager_steps.end_slave,
    "start_manager": manager_steps.start_manager,
    "stop_manager": manager_steps.stop_manager,
    "restart_manager": manager_steps.restart_manager,
    "set_property": manager_steps.set_property,
    "compose": composite_steps.compose,
    "dissolve": composite_steps.dissolve,
    "add_member": composite_steps.add_member,
    "remove_member": composite_steps.remove_member,
    "inject": _inject,
}
