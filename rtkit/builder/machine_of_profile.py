"""Builds the state machine of a profile from the events that its event port carries."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from rtkit.builder.source_text import one_line
from rtkit.builder.subject import GeneratedEvent, GeneratedStateMachine
from rtkit.profile import rtc_model
from rtkit.rtc.names import near_port_name

INITIAL = "InitialState"
"""The state that editors draw for the beginning; an event without name leads out of it."""

_Table = Mapping[str, Mapping[str, str]]
_Note = Callable[[str], None]


def machine_of(
    port: rtc_model.DataPortDeclaration,
    drawn: _Table | None,
    type_of: Callable[[str], str],
    note: _Note,
) -> GeneratedStateMachine | None:
    """Return the machine of an event port; None where no event names a state.

    Args:
        port: The event port.
        drawn: The states where a drawing of the machine is at hand.
        type_of: Gives the expression of a data type.
        note: Called with each fact that cannot be taken over as it is.
    """
    states = {state: dict(moves) for state, moves in (drawn or _states(port.events, note)).items()}
    if not states:
        return None
    known = {event for moves in states.values() for event in moves}
    types: dict[str, str] = {}
    for each in port.events:
        name = one_line(each.name)
        if name in known:
            types.setdefault(name, type_of(each.type or ""))
    missing = [event for moves in states.values() for event in moves if event not in types]
    events = [*types.items(), *((event, "bytes") for event in dict.fromkeys(missing))]
    return GeneratedStateMachine(
        near_port_name(port.name) or "event",
        states,
        tuple(GeneratedEvent(name, type) for name, type in events),
        tuple(filter(None, map(_condition, port.events))),
    )


def _states(events: Iterable[rtc_model.FsmTransition], note: _Note) -> dict[str, dict[str, str]]:
    states: dict[str, dict[str, str]] = {}
    first = ""
    for each in events:
        source, target, name = _state(each.source), _state(each.target), one_line(each.name)
        if source == INITIAL and not name:
            first = first or target
            continue
        if source:
            states.setdefault(source, {})
        if target:
            states.setdefault(target, {})
        if not (source and target and name):
            ends = f"from {source or '(none)'} to {target or '(none)'}"
            note(f"a transition {ends} has no event: it is left out")
        elif states[source].setdefault(name, target) != target:
            note(f"state {source}: event {name} leads to {states[source][name]}, not to {target}")
    if first:
        states = {first: states.pop(first, {}), **states}
    return states


def _state(name: str) -> str:
    """Return the name of a state; a dot puts it inside the one that stands before the dot."""
    plain = one_line(name)
    return plain if all(part.strip() for part in plain.split(".")) else plain.replace(".", "_")


def _condition(event: rtc_model.FsmTransition) -> str:
    condition = one_line(event.condition)
    return f"{one_line(event.name)} in {_state(event.source)}: {condition}" if condition else ""
