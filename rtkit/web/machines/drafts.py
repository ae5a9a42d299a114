"""Drafts of state machines: records of machines as the page edits them, and what is wrong in them.

A draft may be half done at any time. So all that is wrong is told at once, each with its place; the
service would name the first of it only.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from rtkit.api.live_records import Record
from rtkit.services.paths import RESERVED
from rtkit.services.statemachine.expressions import Expression, Plain, plain_of
from rtkit.services.statemachine.model import (
    EVERY_S,
    BadMachine,
    GuardedTransition,
    Machine,
    MachineAction,
    MachineState,
    by_outer,
    hint,
)
from rtkit.services.statemachine.rdf import (
    DEEPEST,
    STATE_NAME,
    bare,
    read_machine,
    seconds_of,
    write_machine,
)
from rtkit.web.fields import list_in, object_in, text_in, wrong

_LISTS = ("entry", "exit", "do")
_HOWS = ("value", "expression", "get")
_KINDS = ("set", "assign", "raise")


class DraftProblem(NamedTuple):
    """Something that is wrong, or odd, in a draft.

    Attributes:
        state: Path of the state; empty of the machine.
        part: What of it: ``name``, ``initial``, ``variables``, ``transitions.0``, ``entry.1`` ….
        text: A sentence.
        is_odd: The machine may be put in force all the same.
    """

    state: str
    part: str
    text: str
    is_odd: bool = False


class Draft(NamedTuple):
    """A draft that was read.

    Attributes:
        machine: As far as it could be read; whole where there are no problems but odd things.
        problems: In the order of the states.
    """

    machine: Machine
    problems: tuple[DraftProblem, ...]

    @property
    def is_whole(self) -> bool:
        """Return whether the machine may be put in force."""
        return all(each.is_odd for each in self.problems)


def record_of(machine: Machine) -> Record:
    """Return a machine as the page edits it."""
    return {
        "name": machine.name,
        "doc": machine.doc,
        "initial": machine.initial,
        "variables": [{"name": k, "value": bare(v)} for k, v in machine.variables.items()],
        "states": [_state_record(each) for each in machine.states.values()],
    }


def _state_record(state: MachineState) -> Record:
    lists = {word: list(map(_action_record, getattr(state, word))) for word in _LISTS}
    return {
        "path": state.path,
        "initial": state.initial,
        "is_final": state.is_final,
        "doc": state.doc,
        **lists,
        "transitions": [
            {
                "to": each.to,
                "on": each.on,
                "when": each.when.text if each.when else "",
                "after": "" if each.after is None else f"{each.after:g}",
                "actions": list(map(_action_record, each.actions)),
            }
            for each in state.transitions
        ],
    }


def _action_record(action: MachineAction) -> Record:
    how = "get" if action.get else "expression" if action.expression else "value"
    value = action.get or (action.expression.text if action.expression else action.value)
    every = "" if action.every == EVERY_S else f"{action.every:g}"
    return {
        "kind": action.kind, "target": action.target, "how": how, "value": value, "every": every,
    }  # fmt: skip


def draft_of(record: object) -> Draft:
    """Return the machine that a record means, and what is wrong in it.

    Raises:
        Malformed: It is no such record.
    """
    return _Reading(object_in({"machine": record}, "machine")).draft()


class _Reading:
    def __init__(self, record: Record) -> None:
        self._record = record
        self._problems: list[DraftProblem] = []
        self._at = ""
        states = [object_in({"state": each}, "state") for each in list_in(record, "states")]
        self._states = {text_in(each, "path", ""): each for each in states}
        self._counts = Counter(text_in(each, "path", "") for each in states)
        self._inside = by_outer(self._states)
        self._variables = self._read_variables()

    def draft(self) -> Draft:
        name, initial = text_in(self._record, "name", ""), text_in(self._record, "initial", "")
        if not name.strip():
            self._note("name", "The machine has no name.")
        if not self._states:
            self._note("states", "The machine has no state.")
        else:
            self._check_initial(initial)
        states = {path: self._state(path, each) for path, each in self._states.items()}
        machine = Machine(name, initial, states, self._variables, text_in(self._record, "doc", ""))
        if not self._problems:
            self._check_whole(machine)
        if not self._problems:
            self._problems += odd_things(machine)
        return Draft(machine, tuple(self._problems))

    def _note(self, part: str, text: str) -> None:
        self._problems.append(DraftProblem(self._at, part, text))

    def _check_whole(self, machine: Machine) -> None:
        """Read the machine as the service will: what a record can say, a text may not."""
        try:
            read_machine(write_machine(machine))
        except BadMachine as error:
            self._note("", f"The service would refuse it: {error}")

    def _read_variables(self) -> dict[str, Plain]:
        found: dict[str, Plain] = {}
        for each in list_in(self._record, "variables"):
            variable = object_in({"variable": each}, "variable")
            name = text_in(variable, "name", "")
            if not STATE_NAME.fullmatch(name):
                self._note("variables", f"“{name}” is no name: letters, digits, - and _.")
            elif name in found:
                self._note("variables", f"There are two variables {name}.")
            found[name] = plain_of(text_in(variable, "value", ""))
        return found

    def _state(self, path: str, record: Record) -> MachineState:
        self._at = path
        self._check_path(path)
        initial, is_final = text_in(record, "initial", ""), record.get("is_final") is True
        entry, exit_, do = (tuple(self._actions(record, word)) for word in _LISTS)
        ways = tuple(
            self._transition(object_in({"transition": each}, "transition"), f"transitions.{index}")
            for index, each in enumerate(list_in(record, "transitions"))
        )
        if is_final and (entry or exit_ or do or ways or self._inside.get(path)):
            self._note("is_final", "A final state has no actions, no transitions, no states.")
        elif self._inside.get(path):
            self._check_initial(initial)
        elif initial:
            self._note("initial", f"There is no state {initial} inside it.")
        return MachineState(
            path, initial, is_final, entry, exit_, do, ways, text_in(record, "doc", "")
        )

    def _check_path(self, path: str) -> None:
        outer, _, name = path.rpartition(".")
        if not STATE_NAME.fullmatch(name) or name in RESERVED:
            self._note("name", f"“{name}” is no name: a letter, then letters, digits, - and _.")
        if self._counts[path] > 1:
            self._note("name", f"There are {self._counts[path]} states {path}.")
        if outer and outer not in self._states:
            self._note("name", f"There is no state {outer} around it.")
        if path.count(".") > DEEPEST:
            self._note("name", f"It is inside more than {DEEPEST} states.")

    def _check_initial(self, initial: str) -> None:
        inside = self._inside.get(self._at, [])
        whose = self._at or "the machine"
        if not initial:
            self._note("initial", f"No state of {whose} is the initial one.")
        elif initial not in inside:
            self._note("initial", f"The initial state of {whose}, {initial}, is not inside it.")

    def _transition(self, record: Record, part: str) -> GuardedTransition:
        to, on = text_in(record, "to", ""), text_in(record, "on", "")
        if to and to not in self._states:
            self._note(part, f"There is no state {to}{hint(to, self._states)}.")
        when = self._expression(text_in(record, "when", ""), part)
        after = self._seconds(text_in(record, "after", ""), part)
        actions = tuple(self._actions(record, "actions", part))
        if not (to or on or actions):
            self._note(part, "A transition has a state to go to, an event, or actions.")
        return GuardedTransition(to, on, when, after, actions)

    def _actions(self, record: Record, word: str, within: str = "") -> Iterator[MachineAction]:
        for index, each in enumerate(list_in(record, word)):
            part = within or f"{word}.{index}"
            yield self._action(
                object_in({"action": each}, "action"), part, is_repeated=word == "do"
            )

    def _action(self, record: Record, part: str, *, is_repeated: bool) -> MachineAction:
        kind, target = _choice(record, "kind", _KINDS), text_in(record, "target", "")
        how, value = _choice(record, "how", _HOWS), text_in(record, "value", "")
        every = self._seconds(text_in(record, "every", ""), part) if is_repeated else None
        if not target:
            what = {"set": "property", "assign": "variable", "raise": "event"}[kind]
            self._note(part, f"The action names no {what}.")
        if every == 0:
            self._note(part, "The period is to be more than 0 s.")
        made = MachineAction(kind, target, every=EVERY_S if every is None else every)
        if kind != "raise":
            expression = self._expression(value, part) if how == "expression" else None
            if not value and how != "value":
                self._note(part, f"The value of {target} is missing.")
            made = made._replace(value=value if how == "value" else "", expression=expression,
                                 get=value if how == "get" else "")  # fmt: skip
        for each in made.variables():
            self._check_variable(each, part)
        return made

    def _expression(self, text: str, part: str) -> Expression | None:
        if not text.strip():
            return None
        try:
            made = Expression(text)
        except ValueError as error:
            self._note(part, f"{text}: {error}")
            return None
        for each in sorted(made.variables):
            self._check_variable(each, part)
        return made

    def _check_variable(self, name: str, part: str) -> None:
        if name and name not in self._variables:
            self._note(part, f"There is no variable {name}{hint(name, self._variables)}.")

    def _seconds(self, text: str, part: str) -> float | None:
        try:
            return seconds_of(text.strip()) if text.strip() else None
        except ValueError:
            self._note(part, f"“{text}” is no time in seconds.")
            return None


def odd_things(machine: Machine) -> Iterator[DraftProblem]:
    """Yield what a machine may have, and nobody means: transitions and states that never come."""
    for path, state in machine.states.items():
        always: dict[str, int] = {}
        for index, way in enumerate(state.transitions):
            if way.on in always:
                first = always[way.on] + 1
                text = f"It is never taken: transition {first} takes the same event always."
                yield DraftProblem(path, f"transitions.{index}", text, is_odd=True)
            elif way.on and way.when is None and way.after is None:
                always[way.on] = index
    reached = _reached(machine)
    for path in machine.states:
        if path not in reached:
            yield DraftProblem(path, "name", "Nothing leads to this state.", is_odd=True)


def _reached(machine: Machine) -> set[str]:
    """Return the states that can be active: of those inside a reached one, the initial one."""
    reached: set[str] = set()
    waiting = [machine.initial]
    while waiting:
        path = waiting.pop()
        if not path or path in reached:
            continue
        reached.add(path)
        waiting.append(path.rpartition(".")[0])
        waiting.append(machine.states[path].initial)
        waiting += [way.to for way in machine.states[path].transitions]
    return reached


def _choice(record: Mapping[str, Any], key: str, choices: Iterable[str]) -> str:
    value = text_in(record, key, "") or next(iter(choices))
    if value not in choices:
        raise wrong(key, " or ".join(choices), value)
    return value
