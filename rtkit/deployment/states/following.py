"""Follows the state of a system: derives it from the facts, and finds where events lead it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import NamedTuple

from rtkit.deployment.facts import Snapshot
from rtkit.deployment.metrics import ComponentMetrics
from rtkit.deployment.states.machine import SystemStates
from rtkit.errors import Refused

_MOST, _WITHIN_S = 20, 10.0

Holds = Callable[[str, Snapshot], bool]
"""Whether what is wished in a state holds of what lives."""


def state_now(machine: SystemStates, holds: Holds, snapshot: Snapshot, last: str = "") -> str:
    """Return the state that a system is in; empty for none.

    Of several that hold it is the `last` one, else the one with the most desired values.
    """
    held = [name for name in machine.table if holds(name, snapshot)]
    if last in held:
        return last
    return max(held, key=lambda name: len(machine.wishes[name]), default="")


class SystemTransition(NamedTuple):
    """Transition from one state to another; without event somebody else led the system there."""

    before: str
    event: str
    state: str


class Follower:
    """Follows the events of one system.

    Attributes:
        state: The state that it was seen in last, or that it was led to; empty for none yet.
    """

    def __init__(self, machine: SystemStates, holds: Holds) -> None:
        self.state = ""
        self._machine = machine
        self._holds = holds
        self._gone: deque[float] = deque(maxlen=_MOST)

    def look(
        self, snapshot: Snapshot, metrics: Mapping[str, ComponentMetrics], now_s: float
    ) -> SystemTransition | None:
        """Return where the system went by itself, or is to be led; None when it is to stay.

        Args:
            snapshot: What lives.
            metrics: What components do, by their names.
            now_s: A clock that is never set back [s].

        Raises:
            Refused: States lead to one another without an end.
        """
        before, event = self.state, self.due(snapshot, metrics)
        seen = state_now(self._machine, self._holds, snapshot, before)
        is_foreseen = event and self._machine.table[before][event] == seen
        if seen and seen != before and not is_foreseen:
            self.state = seen
            return SystemTransition(before, "", seen)
        return SystemTransition(before, event, self.go(event, now_s)) if event else None

    def due(self, snapshot: Snapshot, metrics: Mapping[str, ComponentMetrics]) -> str:
        """Return the event whose condition holds, the first one of the state; empty for none."""
        for event in self._machine.table.get(self.state, ()):
            condition = self._machine.conditions.get(event)
            if condition is not None and condition.holds(snapshot, metrics):
                return event
        return ""

    def go(self, event: str, now_s: float) -> str:
        """Take an event; return the state that it leads to.

        Raises:
            Refused: States lead to one another without an end.
        """
        self._gone.append(now_s)
        if len(self._gone) == _MOST and now_s - self._gone[0] < _WITHIN_S:
            raise Refused(
                f"{_MOST} transitions within {_WITHIN_S:g} s, the last one from {self.state}"
                f" by {event}: conditions lead from state to state without an end"
            )
        self.state = self._machine.next(self.state, event)
        return self.state
