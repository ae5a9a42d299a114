"""Leads a system from state to state; an unreachable state leads on by the event ``failed``.

See decision 29.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import NamedTuple

from rtkit.deployment.facts import AT_FIRST, BY_OTHERS, IS_SO, Snapshot
from rtkit.deployment.metrics import ComponentMetrics
from rtkit.deployment.states.machine import FAILED
from rtkit.deployment.states.states import States
from rtkit.errors import Refused, RtkitError, from_kind

_MOST, _WITHIN_S = 20, 10.0


class SystemTransition(NamedTuple):
    """Transition from one state to another."""

    before: str
    event: str
    state: str


Reach = Callable[[SystemTransition], object]
"""Makes a transition, or raises why it cannot be made."""


class Leader:
    """Leads one system, on command or wherever its events lead.

    Attributes:
        state: The state that it was seen in last, or that it was led to; empty for none yet.
    """

    def __init__(
        self,
        states: States,
        reach: Reach,
        failed: Callable[[str], object],
        clock_s: Callable[[], float],
    ) -> None:
        """Prepare to lead a system.

        Args:
            states: Of the system.
            reach: Makes each transition.
            failed: Receives transitions that failed and lead on.
            clock_s: A clock that is never set back [s].
        """
        self.state = ""
        self._states = states
        self._machine = states.machine
        self._reach = reach
        self._failed = failed
        self._clock_s = clock_s
        self._gone: deque[float] = deque(maxlen=_MOST)

    def begin(self, facts: Snapshot) -> SystemTransition:
        """Begin where the system is, or lead it to where it begins; return how it came there.

        Raises:
            RtkitError: The first state could not be reached, and no event leads on from there.
        """
        self.state = self._states.now(facts)
        if not self.state:
            return self.lead(SystemTransition("", AT_FIRST, self._machine.first))
        return SystemTransition("", IS_SO, self.state)

    def step(
        self, facts: Snapshot, metrics: Mapping[str, ComponentMetrics]
    ) -> SystemTransition | None:
        """Follow what is due, by what lives and does; return the last transition, if any.

        Raises:
            Refused: States lead to one another without an end.
            RtkitError: A state could not be reached, and no event leads on from there.
        """
        before, event = self.state, self.due(facts, metrics)
        seen = self._states.now(facts, before)
        is_foreseen = event and self._machine.table[before][event] == seen
        if seen and seen != before and not is_foreseen:
            self.state = seen
            return SystemTransition(before, BY_OTHERS, seen)
        return self.lead(self._by(event)) if event else None

    def due(self, facts: Snapshot, metrics: Mapping[str, ComponentMetrics]) -> str:
        """Return the event whose condition holds, the first one of the state; empty for none."""
        for event in self._machine.table.get(self.state, ()):
            condition = self._machine.conditions.get(event)
            if condition is not None and condition.holds(facts, metrics):
                return event
        return ""

    def lead(self, passage: SystemTransition) -> SystemTransition:
        """Lead the system to a state; return the last transition.

        Raises:
            RtkitError: A state could not be reached, and no event leads on from there.
        """
        while True:
            before, event, self.state = passage
            try:
                self._reach(passage)
            except RtkitError as error:
                message = f"{before or 'the beginning'} -{event}-> {self.state}: {error}"
                if FAILED not in self._machine.table[self.state]:
                    raise from_kind(error.kind, message) from error
                self._failed(message)
                passage = self._by(FAILED)
            else:
                return passage

    def _by(self, event: str) -> SystemTransition:
        """Return where an event leads; refuse states that lead to one another without an end."""
        now_s = self._clock_s()
        self._gone.append(now_s)
        if len(self._gone) == _MOST and now_s - self._gone[0] < _WITHIN_S:
            raise Refused(
                f"{_MOST} transitions within {_WITHIN_S:g} s, the last one from {self.state}"
                f" by {event}: conditions lead from state to state without an end"
            )
        return SystemTransition(self.state, event, self._machine.next(self.state, event))
