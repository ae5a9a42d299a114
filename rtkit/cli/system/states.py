"""Presents the states that a system's profile defines, for people and as records."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from rtkit.cli.shared.json_records import picked, time_text
from rtkit.cli.system.planning import DeploymentInputs
from rtkit.errors import InvalidDocument, Malformed, NotFound

if TYPE_CHECKING:
    from rtkit.cli.system.document import SystemDocument
    from rtkit.deployment.facts import Followed
    from rtkit.deployment.states.machine import SystemStates, Table
    from rtkit.deployment.states.states import States, Way


def states_of(begun: DeploymentInputs) -> States:
    """Return the states of a system.

    Raises:
        InvalidDocument: Its profile tells none, or they make no sense.
    """
    from rtkit.deployment.states.states import States

    return States(begun.document.profile.id, read_machine(begun.document), begun.goal)


def read_machine(document: SystemDocument) -> SystemStates:
    """Return the states of a system profile, checked.

    Raises:
        InvalidDocument: It tells none, or they make no sense.
    """
    from rtkit.deployment.described import properties_of
    from rtkit.deployment.extension import STATE_CHART, STATES
    from rtkit.deployment.states.machine import machine_of

    profile = document.profile
    properties = properties_of(profile.properties)
    sets = {c.instance_name: [s.id for s in c.configuration_sets] for c in profile.components}
    chart = properties.get(STATE_CHART)
    try:
        table = _chart(chart, document.source) if chart is not None else None
        machine = machine_of(properties, sets, table)
    except Malformed as error:
        raise InvalidDocument(f"{document.source}: {error}") from error
    if machine is None:
        raise InvalidDocument(f"{document.source}: it tells no states ({STATES} of the system)")
    return machine


def _chart(text: str, source: str) -> Table:
    """Return states and transitions of SCXML: the text, or a file beside the profile."""
    from rtkit.profile.read import STDIN, read_bytes
    from rtkit.profile.scxml import read_scxml

    if text.lstrip().startswith("<"):
        return read_scxml(text.encode(), source).states
    folder = os.path.dirname(source) if source != STDIN else ""
    path = os.path.join(folder, text.strip())
    try:
        return read_scxml(read_bytes(path), path).states
    except NotFound as error:
        raise InvalidDocument(f"{source}: the state chart: {error}") from error


def as_lines(states: States, now: str, ways: list[Way], followed: Followed | None) -> list[str]:
    """Return for people: each state with the way there, the events of the present one, who follows.

    Args:
        states: Of the system.
        now: The present one; empty for none.
        ways: To each of them.
        followed: The manager's report if it follows the system.
    """
    width = max(len(way.state) for way in ways)
    lines = [
        f"{'*' if way.state == now else ' '} {way.state:<{width}}  {_way_text(way, now)}".rstrip()
        for way in ways
    ]
    if not now:
        lines.append("between states")
    events = _events(states.machine, now)
    width = max((len(each["event"]) for each in events), default=0)
    to = max((len(each["to"]) for each in events), default=0)
    for each in events:
        when = each["when"] or "on command"
        lines.append(
            f"  -{each['event']}->{' ' * (width - len(each['event']))} {each['to']:<{to}}  {when}"
        )
    return lines + (_followed_lines(followed) if followed is not None else [])


def as_record(
    states: States, now: str, ways: list[Way], followed: Followed | None
) -> dict[str, Any]:
    """Return the same as a record."""
    return {
        "system": states.name,
        "state": now,
        "states": [
            {
                "name": way.state,
                "steps": None if way.plan is None else len(way.plan.moves),
                "cost": None if way.plan is None else round(way.plan.cost, 6),
                "impossible": way.why,
            }
            for way in ways
        ],
        "events": _events(states.machine, now),
        "followed": None if followed is None else _followed(followed),
    }


def _followed(followed: Followed) -> dict[str, Any]:
    return {
        **picked(followed, "state from=before event transitions=count"),
        "time": time_text(int(followed.time * 1e9)) if followed.time else "",
        **picked(followed, "is_led waits_for=waits error=why is_over"),
    }


def _followed_lines(followed: Followed) -> list[str]:
    word = "not followed any more" if followed.is_over else "followed by its manager"
    lines = [f"{word}: {'being led: ' * followed.is_led}{followed}"]
    if followed.waits:
        lines.append(f"  waits for {followed.waits}")
    if followed.why:
        lines.append(f"  failed: {followed.why}")
    return lines


def _way_text(way: Way, now: str) -> str:
    if way.state == now:
        return "is so"
    if way.plan is None:
        return way.why
    from rtkit.report.finding import counted

    return f"{counted(len(way.plan.moves), 'step')}, cost {way.plan.cost:g}"


def _events(machine: SystemStates, now: str) -> list[dict[str, str]]:
    from rtkit.deployment.states.machine import FAILED

    return [
        {
            "event": event,
            "to": to,
            "when": "a transition to it fails"
            if event == FAILED
            else str(machine.conditions.get(event, "")),
        }
        for event, to in machine.table.get(now, {}).items()
    ]
