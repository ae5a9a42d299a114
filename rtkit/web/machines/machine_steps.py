"""Turns what a page asks of state machines into command lines: edits, runs, events, files."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence

from rtkit.errors import Malformed, Refused
from rtkit.web.fields import number_in, text_in
from rtkit.web.folders import granted
from rtkit.web.live.steps import Action, CommandStep

ENDINGS = (".ttl", ".rdf", ".scxml")
"""Endings of files that hold machines: Turtle, RDF/XML, SCXML."""
_FORMS = {".ttl": "turtle", ".rdf": "xml", ".scxml": "scxml"}
_DONE_MEANWHILE = "what the machine did meanwhile is done"


def _edit(action: Action, _folders: Sequence[str]) -> CommandStep:
    """Put a text in force, if nobody has edited the machine since it had so many edits."""
    machine, edits = text_in(action, "machine"), number_in(action, "edits")
    text, goto, before = (text_in(action, key, "") for key in ("text", "goto", "before"))
    if not text.strip():
        raise Malformed("text: the text of a machine is wanted")
    given = [f"edits={edits}", *([f"goto={goto}"] if goto else [])]
    line = ("rtset", *(part for each in given for part in ("-p", each)), "--",
            f"{machine}.machine", "-")  # fmt: skip
    again = {**action, "text": before, "before": text, "edits": edits + 1, "goto": ""}
    return CommandStep(
        f"Edit the machine {machine}, whole, between two steps",
        line,
        (again,) if before else None,
        "" if before else "its text of before is not known",
        text,
    )


def _run(action: Action, _folders: Sequence[str]) -> CommandStep:
    machine, word = text_in(action, "machine"), text_in(action, "word")
    line = ("rtset", "--", f"{machine}.run", word)
    return CommandStep(f"Have {machine} {word}", line, None, _DONE_MEANWHILE)


def _event(action: Action, _folders: Sequence[str]) -> CommandStep:
    machine, name = text_in(action, "machine"), text_in(action, "name")
    line = ("rtset", "--", f"{machine}.event", name)
    return CommandStep(f"Send the event {name} to {machine}", line, None, _DONE_MEANWHILE)


def _variable(action: Action, _folders: Sequence[str]) -> CommandStep:
    machine, name, value = (text_in(action, key) for key in ("machine", "name", "value"))
    line = ("rtset", "--", f"{machine}.variables.{name}", value)
    return CommandStep(f"Set the variable {name} of {machine}", line, None, _DONE_MEANWHILE)


def _keep(action: Action, _folders: Sequence[str]) -> CommandStep:
    machine, target = text_in(action, "machine"), text_in(action, "target")
    line = ("rtset", "--echo", "--", f"{machine}.save", target)
    return CommandStep(f"Save the machine {machine} as {target}", line, None, "it is written")


def _store(action: Action, _folders: Sequence[str]) -> CommandStep:
    """Store a text that was drawn, a state of a machine for another one."""
    target, text = text_in(action, "target"), text_in(action, "text")
    return CommandStep(f"Store a state as {target}", ("rtset", "--", target, "-"), None,
                       "it is written", text)  # fmt: skip


def _save(action: Action, folders: Sequence[str]) -> CommandStep:
    machine = text_in(action, "machine")
    file = granted(text_in(action, "file"), folders, is_new=True, endings=ENDINGS)
    if os.path.exists(file) and action.get("replace") is not True:
        raise Refused(f"{file} is there already")
    form = _FORMS[os.path.splitext(file)[1]]
    at = text_in(action, "at", "")
    what = f"{machine}.machine.{at}" if at else f"{machine}.machine"
    line = ("rtget", "-p", f"form={form}", "-o", file, "--", what)
    return CommandStep(f"Save the machine {machine} as {file}", line, None, "the file is written")


def _create(action: Action, _folders: Sequence[str]) -> CommandStep:
    """Make a component that serves a machine; it serves when it is active."""
    manager, name, service = (text_in(action, key) for key in ("manager", "name", "service"))
    create = f"StateMachine?instance_name={_escaped(name)}&conf.default.service={_escaped(service)}"
    line = ("rtmgr", f"--create={create}", "--", manager)
    reason = "what was made is ended by its own action"
    return CommandStep(f"Create the state machine {name} in {manager}", line, None, reason)


def _activate(action: Action, _folders: Sequence[str]) -> CommandStep:
    manager, name = text_in(action, "manager"), text_in(action, "name")
    path = f"{manager}/{name}.rtc"
    undo = ({"do": "deactivate", "component": path},)
    return CommandStep(f"Activate {path}", ("rtact", "--", path), undo)


STEPS: Mapping[str, Callable[[Action, Sequence[str]], CommandStep]] = {
    "edit_machine": _edit,
    "run_machine": _run,
    "send_event": _event,
    "set_variable": _variable,
    "keep_machine": _keep,
    "store_state": _store,
    "save_machine": _save,
    "create_machine": _create,
    "activate_machine": _activate,
}
"""Steps by the verbs that ask for them."""


def _escaped(text: str) -> str:
    """Return a text without the four signs that have a meaning in create strings."""
    return "".join(f"%{ord(each):02X}" if each in "%&=?" else each for each in text)
