"""Leads a system from state to state; an unreachable state leads on by the event ``failed``.

See decision 29.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rtkit.deployment.facts import AT_FIRST, BY_OTHERS, IS_SO, Snapshot
from rtkit.deployment.metrics import ComponentMetrics
from rtkit.deployment.states.following import Follower, SystemTransition
from rtkit.deployment.states.machine import FAILED
from rtkit.deployment.states.states import States
from rtkit.errors import RtkitError, from_kind

Reach = Callable[[SystemTransition], object]
"""Makes a transition, or raises why it cannot be made."""


class Leader:
    """Leads one system, on command or wherever its events lead.

    Attributes:
        follower: The state that the system is in, or is led to.
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
        self.follower = Follower(states.machine, states.holds)
        self._states = states
        self._reach = reach
        self._failed = failed
        self._clock_s = clock_s

    def begin(self, facts: Snapshot) -> SystemTransition:
        """Begin where the system is, or lead it to where it begins; return how it came there.

        Raises:
            RtkitError: The first state could not be reached, and no event leads on from there.
        """
        now = self._states.now(facts)
        if not now:
            return self.lead(SystemTransition("", AT_FIRST, self._states.machine.first))
        self.follower.state = now
        return SystemTransition("", IS_SO, now)

    def step(
        self, facts: Snapshot, metrics: Mapping[str, ComponentMetrics]
    ) -> SystemTransition | None:
        """Follow what is due; return the last transition; None where nothing was.

        Raises:
            RtkitError: A state could not be reached, and no event leads on from there.
        """
        passage = self.follower.look(facts, metrics, self._clock_s())
        if passage is None:
            return None
        if passage.event:
            return self.lead(passage)
        return passage._replace(event=BY_OTHERS)

    def lead(self, passage: SystemTransition) -> SystemTransition:
        """Lead the system to a state; return the last transition.

        Raises:
            RtkitError: A state could not be reached, and no event leads on from there.
        """
        while True:
            before, event, state = passage
            self.follower.state = state
            try:
                self._reach(passage)
            except RtkitError as error:
                told = f"{before or 'the beginning'} -{event}-> {state}: {error}"
                if FAILED not in self._states.machine.table[state]:
                    raise from_kind(error.kind, told) from error
                self._failed(told)
                passage = SystemTransition(state, FAILED, self.follower.go(FAILED, self._clock_s()))
            else:
                return passage
