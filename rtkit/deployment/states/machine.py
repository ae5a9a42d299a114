"""State machine of a system: its states and the events between them, checked before use."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from rtkit.deployment import extension
from rtkit.deployment.states.events import EventCondition, condition
from rtkit.deployment.states.variants import StateDifference, differences_of
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass, field
from rtkit.rtc.nearest import did_you_mean

Table = Mapping[str, Mapping[str, str]]
"""State to event to next state; the first one is where a system begins."""

FAILED = "failed"
"""The event that a transition could not be made: it has no condition, and is no command."""

_NAME = re.compile(r"[A-Za-z_][\w-]*")
_ARROW = re.compile(r"\s*(\S+)\s+-\s*(\S+?)\s*->\s*(\S+)\s*|\s*(\S+)\s+(\S+)\s+(\S+)\s*")
_ANY = "*"


@dataclass(frozen=True, slots=True)
class SystemStates:
    """The states of one system.

    Attributes:
        table: State to event to next state, in order; the first one is where it begins.
        wishes: Desired values of each state.
        conditions: By event; one without condition is a command, or `FAILED`.
    """

    table: Table
    wishes: Mapping[str, tuple[StateDifference, ...]] = field(default_factory=dict)
    conditions: Mapping[str, EventCondition] = field(default_factory=dict)

    @property
    def first(self) -> str:
        """The state in which it begins."""
        return next(iter(self.table))

    def check_state(self, name: str) -> str:
        """Return the name of a state if it is one.

        Raises:
            Malformed: There is none of that name.
        """
        if name not in self.table:
            there = ", ".join(self.table)
            raise Malformed(f"no state {name}{did_you_mean(name, self.table)}; there are {there}")
        return name

    def next(self, state: str, event: str) -> str:
        """Return where an event leads from a state.

        Raises:
            Malformed: It leads nowhere from there.
        """
        leading = self.table[state]
        if event not in leading:
            there = ", ".join(leading) or "none"
            known = did_you_mean(event, leading)
            raise Malformed(f"event {event} leads nowhere from {state}{known}; events: {there}")
        return leading[event]


def machine_of(
    properties: Mapping[str, str], sets: Mapping[str, Sequence[str]], chart: Table | None = None
) -> SystemStates | None:
    """Return the states that the properties of a system profile state; None where they state none.

    Args:
        properties: Of the system: ``rtkit.states``, ``rtkit.transitions``, ``rtkit.state.NAME``,
            ``rtkit.event.NAME``.
        sets: The components of the system by name, and the names of their configuration sets.
        chart: States and transitions, where a state chart states them.

    Raises:
        Malformed: They make no sense; lists everything that does not.
    """
    stated = {key: text for key, text in properties.items() if key.startswith(_PREFIXES)}
    if chart is None and not stated:
        return None
    reading = _Reading(stated, sets)
    machine = reading.machine(chart)
    if reading.problems:
        raise Malformed("; ".join(reading.problems))
    return machine


_PREFIXES = (extension.STATES, extension.TRANSITIONS, extension.STATE, extension.EVENT)


class _Reading:
    def __init__(self, properties: Mapping[str, str], sets: Mapping[str, Sequence[str]]) -> None:
        self._properties = properties
        self._sets = sets
        self.problems: list[str] = []

    def machine(self, chart: Table | None) -> SystemStates:
        table = self._table() if chart is None else self._chart(chart)
        events = {event for leading in table.values() for event in leading}
        conditions = self._conditions(events)
        found = {}
        for name in self._named(extension.STATE):
            if name not in table:
                self._problem(f"{extension.STATE}{name}: no such state", name, table)
                continue
            found[name] = self._try(differences_of, f"{extension.STATE}{name}", self._sets) or ()
        machine = SystemStates(table, {name: found.get(name, ()) for name in table}, conditions)
        self._check_distinct(machine)
        self._check_reached(machine)
        return machine

    def _chart(self, chart: Table) -> Table:
        for key in (extension.STATES, extension.TRANSITIONS):
            if key in self._properties:
                self.problems.append(f"{key}: the state chart tells that already")
        nested = [name for name in chart if "." in name]
        if nested:
            self.problems.append(f"states within states are not taken: {nested[0]}")
        if not chart:
            self.problems.append("the state chart has no states")
        return {name: dict(leading) for name, leading in chart.items()} or {"": {}}

    def _table(self) -> dict[str, dict[str, str]]:
        names = [name.strip() for name in self._properties.get(extension.STATES, "").split(",")]
        names = [name for name in names if name]
        table: dict[str, dict[str, str]] = {}
        for name in names:
            if not _NAME.fullmatch(name):
                self.problems.append(f"{extension.STATES}: not a name: {name!r}")
            if name in table:
                self.problems.append(f"{extension.STATES}: named twice: {name}")
            table[name] = {}
        if not table:
            self.problems.append(f"{extension.STATES} names no state")
            return {"": {}}
        for text in self._properties.get(extension.TRANSITIONS, "").split(";"):
            if text.strip():
                self._transition(text.strip(), table)
        return table

    def _transition(self, text: str, table: dict[str, dict[str, str]]) -> None:
        match = _ARROW.fullmatch(text)
        if match is None:
            self.problems.append(f"{extension.TRANSITIONS}: not STATE -EVENT-> STATE: {text!r}")
            return
        state, event, target = (part for part in match.groups() if part is not None)
        if not _NAME.fullmatch(event):
            self.problems.append(f"{extension.TRANSITIONS}: not a name: {event!r}")
            return
        for name in (state, target):
            if name not in table and (name != _ANY or name == target):
                self._problem(f"{extension.TRANSITIONS}: no such state: {name}", name, table)
                return
        for each in [name for name in table if name != target] if state == _ANY else [state]:
            if state == _ANY and event in table[each]:
                continue  # what is stated of one state takes precedence over what is stated of all
            if event in table[each]:
                self.problems.append(
                    f"{extension.TRANSITIONS}: {event} leads from {each}"
                    f" to {table[each][event]} and to {target}"
                )
                continue
            table[each][event] = target

    def _conditions(self, events: set[str]) -> dict[str, EventCondition]:
        found = {}
        for name in self._named(extension.EVENT):
            key = f"{extension.EVENT}{name}"
            if name not in events:
                self._problem(f"{key}: no transition has that event", name, events)
            elif name == FAILED:
                self.problems.append(f"{key}: is what happens when a transition fails")
            else:
                made = self._try(condition, key, self._sets)
                if made is not None:
                    found[name] = made
        return found

    def _named(self, prefix: str) -> Iterator[str]:
        return (key.removeprefix(prefix) for key in self._properties if key.startswith(prefix))

    def _try(self, read, key: str, sets: Mapping[str, Sequence[str]]):  # type: ignore[no-untyped-def]
        try:
            return read(self._properties[key], sets)
        except Malformed as error:
            self.problems.append(f"{key}: {error}")
            return None

    def _problem(self, text: str, name: str, known: Mapping[str, object] | set[str]) -> None:
        self.problems.append(f"{text}{did_you_mean(name, known)}")

    def _check_distinct(self, machine: SystemStates) -> None:
        """Refuse states that nobody could distinguish by what lives."""
        seen: dict[frozenset[StateDifference], str] = {}
        for name, wished in machine.wishes.items():
            known = seen.setdefault(frozenset(wished), name)
            if known != name and not self.problems:
                self.problems.append(f"states {known} and {name} wish the same")

    def _check_reached(self, machine: SystemStates) -> None:
        if self.problems or not any(machine.table.values()):
            return  # without events all are reached by --goto only
        reached, todo = {machine.first}, [machine.first]
        while todo:
            new = set(machine.table[todo.pop()].values()) - reached
            reached |= new
            todo += new
        lost = [name for name in machine.table if name not in reached]
        if lost:
            self.problems.append(f"no event leads to {', '.join(lost)}")
