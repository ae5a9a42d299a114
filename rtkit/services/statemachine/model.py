"""Model of a state machine: states inside each other, transitions, actions, variables.

A state is named by its path, ``patrol.leg1``. One state without others inside is active at a time,
with all those around it.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from rtkit.services.statemachine.expressions import VARIABLES, Expression, Plain

EVERY_S = 0.2
"""Period of a do action that states none [s]; below the time-out of a velocity."""


_FILLED = re.compile(r"\$\{([\w-]+)\}", re.ASCII)


class BadMachine(ValueError):
    """A machine that is refused, whole.

    Attributes:
        line: Of the document, from 1; 0 where there is none.
    """

    def __init__(self, why: str, line: int = 0) -> None:
        super().__init__(f"line {line}: {why}" if line else why)
        self.line = line


class MachineAction(NamedTuple):
    """One thing to do: SET a property, give a variable a value, or raise an event.

    Attributes:
        kind: ``set``, ``assign`` or ``raise``.
        target: Property, variable or event.
        value: Text of a SET as it is sent, where nothing is computed.
        expression: Computes the value instead.
        get: Property that the value is got from instead.
        every: Period of a do action [s].
    """

    kind: str
    target: str
    value: str = ""
    expression: Expression | None = None
    get: str = ""
    every: float = EVERY_S

    def variables(self) -> list[str]:
        """Return the variables that it gives a value, or whose values it puts into texts."""
        assigned = [self.target] if self.kind == "assign" else []
        return assigned + _FILLED.findall(f"{self.target} {self.value} {self.get}")

    def filled(self, variables: Mapping[str, Plain]) -> MachineAction:
        """Return it with the value of a variable in place of ``${NAME}``."""
        texts = (_FILLED.sub(lambda found: str(variables[found[1]]), each)
                 for each in (self.target, self.value, self.get))  # fmt: skip
        target, value, get = texts
        return self._replace(target=target, value=value, get=get)


class GuardedTransition(NamedTuple):
    """A way out of a state: all that it states must hold.

    Attributes:
        to: MachineState to enter; empty: none is left or entered.
        on: Event that it waits for, ``door`` also for ``door.open``, ``*`` for any; empty: none.
        when: Condition that must be true.
        after: Time that its state has been active [s].
    """

    to: str
    on: str = ""
    when: Expression | None = None
    after: float | None = None
    actions: tuple[MachineAction, ...] = ()

    @property
    def is_once(self) -> bool:
        """Return whether it is taken once while its state is active: a time does not pass again."""
        return self.after is not None and not self.on and not self.to

    @property
    def cause(self) -> str:
        """Return in words what it waits for."""
        after = "" if self.after is None else f"after {self.after:g}"
        parts = (self.on and f"on {self.on}", self.when and f"when {self.when.text}", after)
        return " ".join(each for each in parts if each) or "at once"


class MachineState(NamedTuple):
    """A state.

    Attributes:
        initial: MachineState inside it that entering it leads to; empty of one with none inside.
        is_final: Whether what is around it has ended when it is entered.
        do: Repeated while it is active.
    """

    path: str
    initial: str = ""
    is_final: bool = False
    entry: tuple[MachineAction, ...] = ()
    exit: tuple[MachineAction, ...] = ()
    do: tuple[MachineAction, ...] = ()
    transitions: tuple[GuardedTransition, ...] = ()
    doc: str = ""

    def actions(self) -> Iterator[MachineAction]:
        """Yield all that is done when it is entered, active or left."""
        yield from (*self.entry, *self.exit, *self.do)
        yield from (action for each in self.transitions for action in each.actions)

    def expressions(self) -> Iterator[Expression]:
        """Yield all that is computed while it is active or left."""
        yield from (each.when for each in self.transitions if each.when)
        yield from (each.expression for each in self.actions() if each.expression)

    def variables(self) -> list[str]:
        """Return the variables that it uses."""
        given = [name for each in self.actions() for name in each.variables()]
        return given + [name for each in self.expressions() for name in each.variables]


class Machine(NamedTuple):
    """A machine.

    Attributes:
        states: By path; what is around a state stands before it.
        variables: Their first values.
    """

    name: str
    initial: str
    states: Mapping[str, MachineState]
    variables: Mapping[str, Plain] = {}
    doc: str = ""

    def innermost(self, path: str) -> str:
        """Return the state that entering a state leads to."""
        while self.states[path].initial:
            path = self.states[path].initial
        return path

    def below(self, path: str) -> list[str]:
        """Return the paths of the states directly inside one, of the outermost for ``""``."""
        return [each for each in self.states if each.rpartition(".")[0] == path]

    def replaced(self, path: str, states: Mapping[str, MachineState]) -> Machine:
        """Return the machine with these states in place of a state and all inside it."""
        kept = {each: state for each, state in self.states.items() if not is_in(each, path)}
        return self._replace(states={**kept, **states})

    def check(self, lines: Mapping[tuple[str, str], int] | None = None) -> Machine:
        """Return the machine itself.

        Args:
            lines: Where a document says what of a state: ``to PATH``, ``initial`` ….

        Raises:
            BadMachine: Something in it leads nowhere.
        """

        def line(path: str, what: str) -> int:
            return (lines or {}).get((path, what)) or (lines or {}).get((path, ""), 0)

        if not self.states:
            raise BadMachine("there is no state", line("", ""))
        inside = by_outer(self.states)
        for path in ("", *self.states):
            state = self.states[path] if path else MachineState("", self.initial)
            if state.initial not in inside.get(path, [""]):
                why = f"initial state of {path or 'the machine'} is none of those inside it: "
                raise BadMachine(f"{why}{state.initial or 'none'}", line(path, "initial"))
            for each in state.transitions:
                if each.to and each.to not in self.states:
                    why = f"no state to go to: {each.to}{hint(each.to, self.states)}"
                    raise BadMachine(f"{path}: {why}", line(path, f"to {each.to}"))
            for used in state.variables():
                if used not in self.variables:
                    why = f"no variable {used}{hint(used, self.variables)}"
                    raise BadMachine(f"{path}: {why}", line(path, f"{VARIABLES}{used}"))
        return self

    def without(self, path: str) -> Machine:
        """Return the machine without a state and all inside it."""
        left = self.replaced(path, {})
        outer = path.rpartition(".")[0]
        if outer and not left.below(outer):
            around = left.states[outer]._replace(initial="")
            left = left._replace(states={**left.states, outer: around})
        return left

    def difference(self, other: Machine) -> str:
        """Return what another machine has more (+), less (-) and otherwise (~), in one line."""
        old, new = self.states, other.states
        signs = [("+", new.keys() - old.keys()), ("-", old.keys() - new.keys())]
        signs.append(("~", {path for path in old.keys() & new.keys() if old[path] != new[path]}))
        changes = [sign + path for sign, paths in signs for path in sorted(paths)]
        if self[:2] != other[:2] or self.variables != other.variables:
            changes.append("~machine")
        return " ".join(changes) or "nothing"


def is_in(path: str, outer: str) -> bool:
    """Return whether a state is another one or inside it."""
    return not outer or path == outer or path.startswith(f"{outer}.")


def by_outer(paths: Iterable[str]) -> dict[str, list[str]]:
    """Return the paths directly inside each state, ``""`` for the outermost ones."""
    found: dict[str, list[str]] = {}
    for each in paths:
        found.setdefault(each.rpartition(".")[0], []).append(each)
    return found


def around(path: str) -> list[str]:
    """Return a state and those around it, from the inside out."""
    parts = path.split(".") if path else []
    return [".".join(parts[:count]) for count in range(len(parts), 0, -1)]


def hint(name: str, known: Iterable[str]) -> str:
    """Return a question for the name that may be meant."""
    near = difflib.get_close_matches(name, list(known), 1)
    return f"; did you mean {near[0]}?" if near else ""
