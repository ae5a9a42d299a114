"""Steps about execution contexts: their rates, and which components they drive."""

from __future__ import annotations

from rtkit.api.live_records import SystemRecords
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.property.writing import write
from rtkit.web.live.steps import Action, CommandStep, component_in, context_in, found_in


def rate(action: Action, records: SystemRecords) -> CommandStep:
    """Set the rate of a context."""
    component = component_in(action, records)
    number = context_in(action, component)
    hz = action.get("rate_hz")
    if isinstance(hz, bool) or not isinstance(hz, int | float):
        raise Malformed(f"rate_hz: a number is wanted, not {hz!r}")
    context = component["contexts"][number]
    undo = {**action, "rate_hz": context["rate_hz"]}
    target = f"{component['id']}.contexts.{number}"
    line = ("rtset", f"{target}.rate", f"{hz:g}")
    text, old = f"Set the rate of {target} to {hz:g} Hz", f"{context['rate_hz']:g}"
    return CommandStep(text, line, (undo,), old=old, new=f"{hz:g}")


def attach(action: Action, records: SystemRecords) -> CommandStep:
    """Have a context of a component drive another one too."""
    return _share(action, records)


def detach(action: Action, records: SystemRecords) -> CommandStep:
    """Take a component out of a context of another one."""
    return _share(action, records)


def _share(action: Action, records: SystemRecords) -> CommandStep:
    component = component_in(action, records)
    guest = found_in(action, "participant", records.components, "component")
    number, is_added = context_in(action, component), action["do"] == "attach"
    present = component["contexts"][number]["participants"]
    target = f"{component['id']}.contexts.{number}"
    if is_added and guest["id"] in present:
        raise Refused(f"{guest['id']} takes part in {target} already")
    if not is_added and guest["id"] not in present:
        raise NotFound(f"{guest['id']} takes no part in {target}")
    after = [*present, guest["id"]] if is_added else [id for id in present if id != guest["id"]]
    names = tuple(records.components[id]["name"] for id in after if id in records.components)
    line = ("rtset", f"{target}.participants", write(names))
    words = ("Attach", "to", "detach") if is_added else ("Detach", "from", "attach")
    text = f"{words[0]} {guest['id']} {words[1]} the execution context {target}"
    return CommandStep(text, line, ({**action, "do": words[2]},))
