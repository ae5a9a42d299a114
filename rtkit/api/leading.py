"""Leads a system to a state on command."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from rtkit.api import step_times
from rtkit.deployment.applying import Applier
from rtkit.deployment.states.leading import Leader, SystemTransition
from rtkit.deployment.states.states import States
from rtkit.tree.grace import uninterrupted

if TYPE_CHECKING:
    from rtkit.api.session import Session


def leader(
    session: Session, states: States, report: Callable[[str], None], *, rolls_back: bool
) -> Leader:
    """Return the leader of a system; the command must hold its managers' locks.

    Args:
        session: The command.
        states: Of the system.
        report: Receives each step.
        rolls_back: When a step fails, go back to the state before.
    """

    def reach(passage: SystemTransition) -> None:
        tree, goal = session.tree, states.goal(passage.state)
        snapshot = uninterrupted(tree.snapshot)
        with step_times.noting(session, goal.system, snapshot) as taken:
            applier = Applier(tree, goal, report, report, taken, careful=uninterrupted)
            applier.run(goal.plan(snapshot), snapshot, rolls_back=rolls_back)

    return Leader(states, reach, session.fail, time.monotonic)
