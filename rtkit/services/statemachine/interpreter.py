"""Interpreter of state machines: events in, things to send out, time as an argument.

Each event is worked on to its end: transitions without an event (conditions, time-outs) are taken
first, then events that actions raised, then the next event. Of the active states the innermost is
asked first, in each the transitions in their order; the first that is enabled is taken. It leaves
states from the inside out, up to the nearest one around both its source and its target, does its
actions, and enters from the outside in. A machine that is paused stands still, with its time;
events wait.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Any, NamedTuple

from rtkit.services.statemachine.expressions import VARIABLES, Plain, plain_of, written
from rtkit.services.statemachine.model import (
    GuardedTransition,
    Machine,
    MachineAction,
    MachineState,
    around,
)

MOST_AT_ONCE = 100
"""Transitions that one event may lead to; a machine that goes round without end is paused."""

MOST_WAITING = 100_000
"""Events that may wait while a machine is paused; further ones are dropped, and the log says so."""


class MachineEvent(NamedTuple):
    """Something that has happened.

    Attributes:
        name: MachineEvent, or property of a service.
        value: New value of a property, None: it is not known any more.
        is_value: Whether it is a property's.
    """

    name: str
    value: Any = None
    is_value: bool = False


class OutgoingSet(NamedTuple):
    """A SET that is to be sent, or a variable that is to be given what a GET leads to.

    Attributes:
        get: Property that the value is to be got from; empty: `value` is it.
        is_repeated: Whether a do action sends it once more.
    """

    target: str
    value: str
    get: str = ""
    is_repeated: bool = False


class MachineLogEntry(NamedTuple):
    """Something that has happened, as the log has it.

    Attributes:
        time: Seconds, of the clock of who calls.
        kind: ``run``, ``value``, ``event``, ``time``, ``transition``, ``set``, ``assign``,
            ``failed``, ``edited`` or ``lost``.
        text: In words; of a transition its states and its cause.
        detail: Further data: the value of a property, the machine after an edit.
    """

    number: int
    time: float
    kind: str
    text: str
    detail: Any = None


class Interpreter:
    """One machine at work.

    Args:
        machine: The machine.
        length: Entries of the log that are kept.
        logs_all: Log events and values that lead to nothing, too.

    Attributes:
        run: ``stopped``, ``running``, ``paused`` or ``done``.
        state: Path of the innermost active state, empty when it is stopped.
        values: Properties that active states look at, as far as known.
        log: The last entries.
        why: Why it is paused, in words.
    """

    def __init__(self, machine: Machine, length: int = 1000, *, logs_all: bool = False) -> None:
        self.machine = machine
        self.run = "stopped"
        self.state = ""
        self.variables: dict[str, Plain] = dict(machine.variables)
        self.values: dict[str, Any] = {}
        self.log: deque[MachineLogEntry] = deque(maxlen=length)
        self.why = ""
        self._last = ""
        self._fired: set[tuple[str, GuardedTransition]] = set()
        self._unknown: set[MachineAction] = set()
        self._logs_all = logs_all
        self._count = 0
        self._since: dict[str, float] = {}
        self._due: dict[tuple[str, int], float] = {}
        self._raised: deque[str] = deque()
        self._waiting: deque[MachineEvent] = deque()
        self._sends: list[OutgoingSet] = []
        self._now = self._shift = self._wall = 0.0

    # Events; each method returns the SETs to send.

    def command(self, word: str, now: float) -> list[OutgoingSet]:
        """Carry out ``start``, ``stop``, ``pause`` or ``step``, where it means something now.

        Raises:
            ValueError: It does not.
        """
        at = self.run
        allowed = {"start": at != "running", "stop": bool(self.state), "pause": at == "running"}
        if not allowed.get(word, word == "step" and at == "paused"):
            raise ValueError(f"cannot {word}: it is {at}")
        if word == "start" and at == "paused":
            self._shift = now - self._now
        self._at(now)
        self._note("run", word)
        self.run = {"start": "running", "stop": "stopped"}.get(word, "paused")
        if at != "paused" or word == "stop":
            self._raised.clear()
            self._waiting.clear()
        if word == "start" and at != "paused":
            self.variables, self.values, self.state = dict(self.machine.variables), {}, ""
            self._enter(self.machine.initial, "")
        elif word == "stop":
            self._leave("")
            self._raised.clear()
        self.why, self._last = "run was set to pause", "no transition was enabled"
        sends = self._advance(is_step=word == "step")
        if word == "step":
            self.why = f"stepping, {self._last}"
        return sends

    def take(self, event: MachineEvent, now: float) -> list[OutgoingSet]:
        """Work on an event; while the machine is paused it waits."""
        self._at(now)
        if self.run not in ("running", "paused"):
            return []
        if len(self._waiting) >= MOST_WAITING:
            self._note("lost", event.name)
            return []
        self._waiting.append(event)
        return self._advance()

    def tick(self, now: float) -> list[OutgoingSet]:
        """Work on what the time has brought."""
        self._at(now)
        if self.run == "running" and self._enabled(""):
            self._note("time", "")
        return self._advance()

    def fail(
        self, target: str, why: str, now: float, *, is_known: bool = False
    ) -> list[OutgoingSet]:
        """Work on the news that a SET has failed: the event ``failed.TARGET``.

        The log has it already where it `is_known`: a do action fails each time as it did before.
        """
        self._at(now)
        if not is_known:
            self._note("failed", f"{target}: {why}")
        return self.take(MachineEvent(f"failed.{target}"), now)

    def assign(self, name: str, value: Plain, now: float) -> list[OutgoingSet]:
        """Give a variable a value from outside.

        Raises:
            KeyError: There is no such variable.
        """
        if name not in self.variables:
            raise KeyError(name)
        self._at(now)
        self.variables[name] = value
        self._note("assign", f"{name} {written(value)}", value)
        return self._advance()

    def edit(
        self, machine: Machine, now: float, goto: str = "", text: str = ""
    ) -> list[OutgoingSet]:
        """Put another machine in force between two steps; the active state stays active.

        Args:
            machine: All of it, checked.
            now: Time.
            goto: MachineState to enter where the active one is no longer there.
            text: The machine as text, for the log.

        Raises:
            ValueError: The active state would be gone, and nothing says where to go.
        """
        is_gone = bool(self.state) and self.state not in machine.states
        if is_gone and goto not in machine.states:
            why = f"no state {goto} to go to" if goto else "say where to go: goto=STATE"
            raise ValueError(f"the active state {self.state} would be gone; {why}")
        self._at(now)
        self._note("edited", self.machine.difference(machine), text or machine)
        before = self.state
        was_final = bool(before) and self.machine.states[before].is_final
        if is_gone:
            outer = _shared(before, goto)
            self._leave(outer)
        variables = dict(machine.variables)
        self.variables = variables | {k: v for k, v in self.variables.items() if k in variables}
        self.machine = machine
        if is_gone:
            self._note("transition", f"{before} -> {goto}: edited")
            self._enter(goto, outer)
        elif self.state:
            end = machine.innermost(self.state)
            for path in around(self.state):
                self._plan(path)
            if end != self.state:
                self._enter(end, self.state)
            elif machine.states[end].is_final > was_final:
                self._end(end)
        return self._advance()

    # Questions.

    def wanted(self) -> frozenset[str]:
        """Return the properties that the active states look at."""
        states = (self.machine.states[path] for path in around(self.state))
        return frozenset(name for each in states for e in each.expressions() for name in e.names)

    def next_time(self) -> float | None:
        """Return when `tick` is to be called next; None: nothing waits for a time."""
        if self.run != "running":
            return None
        times = [*self._due.values()]
        for path in around(self.state):
            ends = [e.after for e in self.machine.states[path].transitions if e.after is not None]
            times += [at for at in (self._since[path] + end for end in ends) if at > self._now]
        return min(times) + self._shift if times else None

    # How it works.

    def _at(self, now: float) -> None:
        """Set the clock; that of the machine stands still while it is paused."""
        self._wall = now
        if self.run != "paused":
            self._now = max(self._now, now - self._shift)

    def _note(self, kind: str, text: str, detail: Any = None) -> None:
        self._count += 1
        self.log.append(MachineLogEntry(self._count, self._wall, kind, text, detail))

    def _look(self, name: str) -> Any:
        if name.startswith(VARIABLES):
            return self.variables.get(name[len(VARIABLES) :])
        return self.values.get(name)

    def _advance(self, *, is_step: bool = False) -> list[OutgoingSet]:
        """Take transitions while there are any, and events while they wait; or one transition."""
        taken = 0
        while self.run == ("paused" if is_step else "running") and taken < MOST_AT_ONCE:
            found = self._enabled("")
            if found is None and self._raised:
                found = self._enabled(self._raised.popleft())
            elif found is None and self._waiting:
                taken = 0
                found = self._received(self._waiting.popleft())
            elif found is None and (is_step or not self._repeat()):
                break
            if found is not None:
                self._carry_out(*found)
                taken += 1
                if is_step:
                    break
        if taken == MOST_AT_ONCE:
            self.run = "paused"
            self._note("failed", f"paused: {taken} transitions at once")
            self.why = f"error, {taken} transitions at once, the last {self._last}"
        wanted = self.wanted()  # what no active state looks at is not kept up to date
        self.values = {name: each for name, each in self.values.items() if name in wanted}
        sends, self._sends = self._sends, []
        return sends

    def _received(self, event: MachineEvent) -> tuple[MachineState, GuardedTransition] | None:
        if event.is_value and event.name in self.wanted():
            self.values[event.name] = event.value
        found = self._enabled("" if event.is_value else event.name)
        if found or self._logs_all:
            value = event.value
            shown = f" {written(value)}" if isinstance(value, Plain) else ""
            self._note("value" if event.is_value else "event", f"{event.name}{shown}", value)
        return found

    def _enabled(self, event: str) -> tuple[MachineState, GuardedTransition] | None:
        """Return the first transition that is enabled, with its state."""
        for path in around(self.state):
            state = self.machine.states[path]
            for each in state.transitions:
                if (path, each) in self._fired:
                    continue
                is_due = self._now >= self._since[path] + (each.after or 0.0)
                if (
                    is_due
                    and _fits(each.on, event)
                    and (not each.when or each.when.is_true(self._look))
                ):
                    return state, each
        return None

    def _carry_out(self, state: MachineState, way: GuardedTransition) -> None:
        self._last = f"{self.state} -> {way.to or self.state}: {way.cause}"
        self._note("transition", self._last)
        if way.is_once:
            self._fired.add((state.path, way))
        outer = _shared(state.path, way.to)
        if way.to:
            self._leave(outer)
        self._do(way.actions)
        if way.to:
            self._enter(way.to, outer)

    def _leave(self, outer: str) -> None:
        while self.state != outer:
            self._do(self.machine.states[self.state].exit)
            del self._since[self.state]
            self._fired = {each for each in self._fired if each[0] != self.state}
            self._due = {key: at for key, at in self._due.items() if key[0] != self.state}
            self.state = self.state.rpartition(".")[0]

    def _enter(self, path: str, outer: str) -> None:
        """Enter a state and what it leads to, from inside another one."""
        end = self.machine.innermost(path)
        for each in reversed(around(end)[: len(around(end)) - len(around(outer))]):
            self.state = each
            self._since[each] = self._now
            self._plan(each)
            self._do(self.machine.states[each].entry)
        if self.machine.states[end].is_final:
            self._end(end)

    def _end(self, end: str) -> None:
        """End what is around a final state."""
        if "." in end:
            self._raised.append(f"done.{end.rpartition('.')[0]}")
        else:
            self.run = "done"
            self._note("run", "done")

    def _plan(self, path: str) -> None:
        """Have the do actions of an active state done from now on, those known as before."""
        wanted = {(path, index): self._now for index in range(len(self.machine.states[path].do))}
        others = {key: at for key, at in self._due.items() if key[0] != path}
        self._due = others | {key: self._due.get(key, at) for key, at in wanted.items()}

    def _repeat(self) -> bool:
        """Carry out the do actions that are due; return whether there were any."""
        due = [(key, at) for key, at in self._due.items() if at <= self._now]
        for (path, index), at in due:
            action = self.machine.states[path].do[index]
            self._due[path, index] = self._now + action.every
            self._do((action,), is_repeated=at > self._since[path])
        return bool(due)

    def _do(self, actions: Iterable[MachineAction], *, is_repeated: bool = False) -> None:
        for action in actions:
            each = action.filled(self.variables)
            value: Plain | None = each.value
            if each.expression is not None:
                value = each.expression.value(self._look)
            is_known = is_repeated and action in self._unknown
            self._unknown.discard(action)
            if value is None:
                if not is_known:
                    self._note("failed", f"{each.target}: not known: {each.expression.text}")  # type: ignore[union-attr]
                self._unknown.add(action)
                self._raised.append(f"failed.{each.target}")
            elif each.kind == "raise":
                self._raised.append(each.target)
            elif each.kind == "assign" and not each.get:
                self.variables[each.target] = value if each.expression else plain_of(each.value)
                self._note("assign", f"{each.target} {written(self.variables[each.target])}")
            else:
                target = VARIABLES * (each.kind == "assign") + each.target
                text = written(value) if each.expression else each.value
                self._sends.append(OutgoingSet(target, text, each.get, is_repeated))
                if not is_repeated:
                    self._note("set", f"{target} {f'GET {each.get}' if each.get else text}")


def _fits(on: str, event: str) -> bool:
    """Return whether an event is one that a transition waits for."""
    return on == event or bool(on and event and (on == "*" or event.startswith(f"{on}.")))


def _shared(path: str, other: str) -> str:
    """Return the nearest state that is around both, and neither of them."""
    outer = set(around(path)[1:]) & set(around(other)[1:])
    return max(outer, key=len, default="")
