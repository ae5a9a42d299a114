"""State machines as tables: state, event, next state; without actions and without time.

A state inside another one is written with a dot, ``Operational.Idle``; it knows the events of the
outer state too, its own first. Entering an outer state leads to the first one inside it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rtkit.errors import Malformed, NotFound

Table = Mapping[str, Mapping[str, str]]
"""Target of each event in each state; the first state is the initial one."""


class StateTransition(NamedTuple):
    """A transition: the innermost states before and after, and the states left and entered."""

    source: str
    event: str
    target: str
    exited: tuple[str, ...]
    entered: tuple[str, ...]


class StateTable:
    """The states of one machine; immutable.

    Attributes:
        table: Table that it was made from, with the outer states that this only implies.
        initial: The innermost state that it begins in.
    """

    def __init__(self, table: Table) -> None:
        self.table = _completed(table)
        if not self.table:
            raise Malformed("a state machine needs a state")
        for state, moves in self.table.items():
            for event, target in moves.items():
                if not event.isprintable() or not event.strip():
                    raise Malformed(f"state {state} has an event without a name")
                if target not in self.table:
                    raise Malformed(f"state {state}: event {event} leads to no state: {target}")
        self._first: dict[str, str] = {}
        for state in self.table:
            self._first.setdefault(_outer(state), state)
        self.initial = self.innermost(self._first[""])

    @property
    def events(self) -> tuple[str, ...]:
        """Every event that some state knows, in the order of the table."""
        return tuple(dict.fromkeys(e for moves in self.table.values() for e in moves))

    def innermost(self, state: str) -> str:
        """Return the state that entering `state` leads to.

        Raises:
            NotFound: There is no such state.
        """
        if state not in self.table:
            raise NotFound(f"no state {state}; there are {', '.join(self.table)}")
        while state in self._first:
            state = self._first[state]
        return state

    def target(self, state: str, event: str) -> str | None:
        """Return the next state by the table; None where the event does not move `state`."""
        for each in lineage(state):
            if event in self.table[each]:
                return self.table[each][event]
        return None

    def move(self, source: str, event: str, target: str) -> StateTransition:
        """Return the transition to `target`: leaves inner states first, enters outer states first.

        A state that leads to itself is left and entered again.

        Raises:
            NotFound: There is no such target.
        """
        end = self.innermost(target)
        before, after = _from_outside(source), _from_outside(end)
        shared = 0
        for one, other in zip(before, after, strict=False):
            if one != other or one == target:
                break
            shared += 1
        return StateTransition(
            source, event, end, tuple(reversed(before[shared:])), tuple(after[shared:])
        )

    def beginning(self) -> StateTransition:
        """Return the transition into the initial state."""
        return StateTransition("", "", self.initial, (), tuple(_from_outside(self.initial)))


def lineage(state: str) -> Iterator[str]:
    """Yield a state and those around it, from the inside out."""
    while state:
        yield state
        state = _outer(state)


def _from_outside(state: str) -> list[str]:
    return list(reversed(list(lineage(state))))


def _outer(state: str) -> str:
    return state.rpartition(".")[0]


def _completed(table: Table) -> dict[str, dict[str, str]]:
    complete: dict[str, dict[str, str]] = {}
    for state, moves in table.items():
        parts = state.split(".")
        if not all(part.strip() and part.isprintable() for part in parts):
            raise Malformed(f"not a name of a state: {state!r}")
        for each in _from_outside(state):
            complete.setdefault(each, {})
        complete[state].update(moves)
    return complete
