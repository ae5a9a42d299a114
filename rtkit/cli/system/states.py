"""The states of a system as its profile tells them, which of them holds, and the ways to others."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.cli.system.planning import Begun
from rtkit.errors import Impossible, InvalidDocument, Malformed, NotFound

if TYPE_CHECKING:
    from rtkit.cli.system.document import Document
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.goal import Goal
    from rtkit.deployment.planning.plan import DeploymentPlan
    from rtkit.deployment.states.machine import Machine, Table


class Way(NamedTuple):
    """From what lives to one state.

    Attributes:
        why: Why there is no plan; empty where there is one.
    """

    state: str
    plan: DeploymentPlan | None
    why: str = ""


class States:
    """The states of one system over its goal.

    Attributes:
        machine: States and events.
    """

    def __init__(self, begun: Begun) -> None:
        """Read the states of a profile.

        Raises:
            InvalidDocument: It tells none, or they make no sense.
        """
        self.name = begun.document.profile.id
        self.machine = read_machine(begun.document)
        self._goals = {state: self._goal(begun.goal, state) for state in self.machine.table}

    def goal(self, state: str) -> Goal:
        """Return what is wanted in a state."""
        return self._goals[state]

    def now(self, snapshot: Snapshot, last: str = "") -> str:
        """Return the state that the system is in; empty for none."""
        from rtkit.deployment.states.following import state_now

        return state_now(self.machine, self.holds, snapshot, last)

    def holds(self, state: str, snapshot: Snapshot) -> bool:
        """Whether all that is wished in a state is so."""
        return self._goals[state].holds(snapshot)

    def way(self, state: str, snapshot: Snapshot) -> Way:
        """Return how a state is reached."""
        try:
            return Way(state, self._goals[state].plan(snapshot))
        except Impossible as error:
            return Way(state, None, str(error))

    def _goal(self, goal: Goal, state: str) -> Goal:
        from rtkit.deployment.states.wishes import variant

        conditions = self.machine.conditions.values()
        watched = {(each.component, each.name) for each in conditions}
        made = variant(goal.system, self.machine.wishes[state], watched)
        return replace(goal, system=made.system, states=made.states, absent=made.absent)


def read_machine(document: Document) -> Machine:
    """Return the states of a system profile, checked.

    Raises:
        InvalidDocument: It tells none, or they make no sense.
    """
    from rtkit.deployment.described import properties_of
    from rtkit.deployment.extension import STATE_CHART, STATES
    from rtkit.deployment.states.machine import machine_of

    profile = document.profile
    told = properties_of(profile.properties)
    sets = {c.instance_name: [s.id for s in c.configuration_sets] for c in profile.components}
    chart = told.get(STATE_CHART)
    try:
        table = _chart(chart, document.source) if chart is not None else None
        machine = machine_of(told, sets, table)
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


def as_lines(states: States, now: str, ways: list[Way]) -> list[str]:
    """Return for people: each state with the way there, then the events of the present one."""
    width = max(len(way.state) for way in ways)
    lines = [
        f"{'*' if way.state == now else ' '} {way.state:<{width}}  {_told(way, now)}".rstrip()
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
    return lines


def as_record(states: States, now: str, ways: list[Way]) -> dict[str, Any]:
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
    }


def _told(way: Way, now: str) -> str:
    if way.state == now:
        return "is so"
    if way.plan is None:
        return way.why
    count = len(way.plan.moves)
    return f"{count} step{'s' * (count != 1)}, cost {way.plan.cost:g}"


def _events(machine: Machine, now: str) -> list[dict[str, str]]:
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
