"""``rtfsm``: look at and change the state machine of a component."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments, no_such
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag
from rtkit.errors import Malformed, Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts
    from rtkit.rtc.names import Path

_MODULE = "RTC::"
_MISSING = {
    "seteventprofiles": "No event profiles specified.",
    "setstructure": "No structure specified.",
}
WORDS = ("getstate", "geteventprofiles", "getstructure", *_MISSING)


@command(
    "rtfsm",
    examples=(
        ("rtfsm /localhost/Microwave0.rtc getstate", "Print the present state."),
        ("rtfsm Microwave0.rtc seteventprofiles open:TimedLong,close:TimedLong", "Other events."),
        ("rtfsm Microwave0.rtc setstructure microwave.scxml", "Other states and transitions."),
    ),
    json=("state-machine",),
    arguments=("component", "words"),
    words=WORDS,
)
def main(
    app: App,
    is_json: bool = json_flag("Of getX: all of the machine, as JSON."),
    words: tuple[str, ...] = arguments("COMPONENT WORD [ARGUMENT]"),
) -> None:
    r"""Look at and change the state machine of a component.

    \b
    getstate                 the present state; empty until the component is first activated
    geteventprofiles         the events with their data types: NAME:TYPE, NAME:TYPE
    seteventprofiles LIST    give it other events: NAME:TYPE,NAME:TYPE
    getstructure             the states and transitions, as SCXML
    setstructure FILE        give it those of an SCXML file (- is stdin)

    A structure is taken over between two periods; a state that it has too is kept. The actions of
    the component in its states are its own code: such content of a file is left out (-v tells).
    """
    if not words:
        raise Malformed("No component specified.")
    typed, *rest = words
    word, arguments = _read(rest)
    path = app.path(typed)
    facts = _facts(app, path)
    if is_json and word not in _MISSING:
        terminal.write([json_records.line("state-machine", {"path": str(path), **_record(facts)})])
    elif word == "getstate":
        terminal.write([terminal.printable(facts.fsm_state)])
    elif word == "geteventprofiles":
        terminal.write([terminal.printable(_events_text(facts.fsm_events))])
    elif word == "getstructure":
        from rtkit.profile.scxml import write_scxml

        terminal.write(write_scxml(facts.instance, facts.fsm_states).splitlines())
    elif word == "seteventprofiles":
        _set_events(app, facts.instance, arguments[0])
    else:
        _set_structure(app, facts.instance, arguments[0])


def _read(words: Sequence[str]) -> tuple[str, Sequence[str]]:
    if not words:
        raise WrongArguments("No command specified.")
    word, *arguments = words
    if word not in WORDS:
        raise UsageProblem(no_such("command", word, WORDS))
    if word in _MISSING and not arguments:
        raise Malformed(_MISSING[word])
    most = int(word in _MISSING)
    if len(arguments) > most:
        raise WrongArguments(f"{word} takes no more arguments: {' '.join(arguments[most:])}")
    return word, arguments


def _facts(app: App, path: Path) -> ComponentFacts:
    facts = app.facts(path)
    if not facts.fsm_states:
        raise Refused(f"No state machine: {path.typed}")
    return facts


def _record(facts: ComponentFacts) -> dict[str, object]:
    return {
        "component": facts.instance,
        "state": facts.fsm_state or None,
        "states": {name: dict(ways) for name, ways in facts.fsm_states.items()},
        "events": dict(facts.fsm_events),
    }


def _events_text(events: Mapping[str, str]) -> str:
    return ", ".join(f"{name}:{kind.removeprefix(_MODULE)}" for name, kind in events.items())


def _set_events(app: App, instance: str, text: str) -> None:
    from rtkit.deployment.actions import SetEventProfiles

    events = {}
    for part in text.split(","):
        name, colon, kind = part.partition(":")
        if not (colon and name.strip() and kind.strip()):
            raise Malformed(f"Bad event profile: {part.strip()} (it is NAME:TYPE)")
        if name.strip() in events:
            raise Malformed(f"event {name.strip()} is named twice: {text}")
        events[name.strip()] = kind.strip()
    app.tree.perform(SetEventProfiles(instance, events))


def _set_structure(app: App, instance: str, source: str) -> None:
    from rtkit.cli.shared.profile_files import read_input
    from rtkit.deployment.actions import SetStructure
    from rtkit.profile.scxml import read_scxml

    name, data = read_input(source)
    chart = read_scxml(data, name)
    for note in chart.notes:
        app.verbose(f"{source}:{note.line}: {note.text}")
    app.tree.perform(SetStructure(instance, chart.states))
