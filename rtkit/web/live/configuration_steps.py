"""Steps that change configuration sets of components: their values, and which sets there are."""

from __future__ import annotations

from rtkit.api.live_records import Record, SystemRecords
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.web.fields import text_in, texts_in
from rtkit.web.live.steps import Action, CommandStep, component_in


def configure(action: Action, records: SystemRecords) -> CommandStep:
    """Change values of one set."""
    component = component_in(action, records)
    id, set_id = component["id"], _set(action, component)
    values, present = texts_in(action, "values"), component["sets"][set_id]
    if not values:
        raise Malformed("values: nothing to change")
    unknown = next((name for name in values if name not in present), None)
    if unknown is not None:
        raise NotFound(f"{id} has no parameter {unknown!r} in the set {set_id!r}")
    _check_expected(action, id, present)
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
        old=", ".join(f"{name}={present[name]}" for name in values),
        new=listed,
    )


def activate_set(action: Action, records: SystemRecords) -> CommandStep:
    """Make a set the active one."""
    component = component_in(action, records)
    id, set_id = component["id"], _set(action, component)
    undo = {"do": "activate_set", "component": id, "set": component["active_set"]}
    line = ("rtconf", f"--set={set_id}", "--", id, "act")
    text = f"Make {set_id} the active configuration set of {id}"
    return CommandStep(text, line, (undo,), old=component["active_set"], new=set_id)


def add_set(action: Action, records: SystemRecords) -> CommandStep:
    """Add a set: a copy of another one but for the values that are given, or these alone."""
    component = component_in(action, records)
    id, set_id, values = component["id"], text_in(action, "set"), texts_in(action, "values")
    source = text_in(action, "source", "")
    if source and source not in component["sets"]:
        raise NotFound(f"{id} has no configuration set {source!r}")
    if not source and not values:
        raise Malformed("values: a set has one parameter or more")
    if set_id in component["sets"]:
        raise Refused(f"{id} has a configuration set {set_id!r} already")
    pairs = [f"{name}={value}" for name, value in values.items()]
    words = ("copy", source, set_id) if source else ("add", set_id)
    undo = {
        "do": "remove_set",
        "component": id,
        "set": set_id,
        "expect": {**component["sets"].get(source, {}), **values},
    }
    like = f" like {source}" if source else ""
    return CommandStep(
        f"Add the configuration set {set_id}{like} to {id}",
        ("rtconf", "--", id, *words, *pairs),
        (undo,),
    )


def remove_set(action: Action, records: SystemRecords) -> CommandStep:
    """Remove a set; the component refuses one that its author has given it."""
    component = component_in(action, records)
    id, set_id = component["id"], _set(action, component)
    present = component["sets"][set_id]
    _check_expected(action, id, present)
    undo = {"do": "add_set", "component": id, "set": set_id, "values": dict(present)}
    line = ("rtconf", "--", id, "remove", set_id)
    return CommandStep(f"Remove the configuration set {set_id} of {id}", line, (undo,))


def with_sets(action: Action, records: SystemRecords) -> SystemRecords:
    """Return records as they will be after a step, for the steps that follow it."""
    component = records.components.get(str(action.get("component")))
    if component is None or action.get("do") not in ("add_set", "remove_set", "activate_set"):
        return records
    sets, name = dict(component["sets"]), action["set"]
    changed: Record = {**component, "sets": sets}
    if action["do"] == "add_set":
        sets[name] = {**sets.get(action.get("source", ""), {}), **action.get("values", {})}
    elif action["do"] == "remove_set":
        del sets[name]
    else:
        changed["active_set"] = name
    return records._replace(components={**records.components, component["id"]: changed})


def _check_expected(action: Action, id: str, present: dict[str, str]) -> None:
    for name, value in texts_in(action, "expect").items():
        if present.get(name) != value:
            now = present.get(name)
            raise Refused(f"{name} of {id} has been changed since: it is {now!r}, not {value!r}")


def _set(action: Action, component: Record) -> str:
    set_id = text_in(action, "set")
    if set_id not in component["sets"]:
        raise NotFound(f"{component['id']} has no configuration set {set_id!r}")
    return set_id
