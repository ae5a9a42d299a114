"""Leads a system to a state; one that cannot be reached leads on by its event ``failed``."""

from __future__ import annotations

import time
from collections.abc import Callable

from rtkit.cli._app import App
from rtkit.cli.system import step_times
from rtkit.cli.system.states import States
from rtkit.errors import RtkitError, from_kind
from rtkit.tree.lease import Leases


class Leading:
    """Carries transitions of one system out.

    Attributes:
        follower: The state that the system is in, or is led to.
    """

    def __init__(
        self,
        app: App,
        states: States,
        say: Callable[[str], None],
        leases: Leases | None = None,
        *,
        rolls_back: bool,
    ) -> None:
        """Prepare to lead a system.

        Args:
            app: The command.
            states: Of the system.
            say: Is told each step.
            leases: Are taken for each transition; None where the command has them already.
            rolls_back: When a step fails, go back to what was before.
        """
        from rtkit.deployment.states.following import Follower

        self.follower = Follower(states.machine, states.holds)
        self._app = app
        self._states = states
        self._say = say
        self._leases = leases
        self._rolls_back = rolls_back

    def lead(self, before: str, state: str, event: str) -> tuple[str, str, str]:
        """Lead the system to a state; return the last transition: from where, event, to where.

        Raises:
            RtkitError: A state could not be reached, and no event leads on from there.
        """
        from rtkit.deployment.states.machine import FAILED

        self.follower.state = state
        while True:
            try:
                self._reach(state)
            except RtkitError as error:
                told = f"{before or 'the beginning'} -{event}-> {state}: {error}"
                if FAILED not in self._states.machine.table[state]:
                    raise from_kind(error.kind, told) from error
                self._app.fail(told)
                before, event = state, FAILED
                state = self.follower.go(FAILED, time.monotonic())
            else:
                return before, event, state

    def _reach(self, state: str) -> None:
        from rtkit.deployment.applying import Applier
        from rtkit.tree.grace import uninterrupted

        tree, goal = self._app.tree, self._states.goal(state)
        try:
            if self._leases is not None:
                self._leases.take(*tree.trees.values())
            snapshot = uninterrupted(tree.snapshot)
            with step_times.noting(self._app, goal.system, snapshot) as taken:
                applier = Applier(tree, goal, self._say, self._say, taken, careful=uninterrupted)
                applier.run(goal.plan(snapshot), snapshot, rolls_back=self._rolls_back)
        finally:
            if self._leases is not None:
                self._leases.close()
