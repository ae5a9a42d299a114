"""Carries plans out, notes what their steps took, and has their systems followed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.api import planning, states, step_times
from rtkit.deployment.applying import Applier
from rtkit.tree.grace import uninterrupted

if TYPE_CHECKING:
    from rtkit.api.session import Session


def carry_out(
    session: Session,
    prepared: planning.Prepared,
    *,
    rolls_back: bool = False,
    is_exact: bool = False,
) -> tuple[str, ...]:
    """Carry a plan out, and have the system followed if its profile wants that.

    Durations of steps are noted. One that is to be carried out exactly is not planned again where
    the world differs. Returns in what required components are not what is wanted.

    Raises:
        Refused: A step failed; the message states what is left, or that it went back.
        Unreachable: The manager does not answer.
        KeyboardInterrupt: Interrupted; its text states what is left.
    """
    document, goal, snapshot, plan, survey = prepared
    is_followed = states.is_follow_wanted(session, document)
    report = session.report
    with step_times.noting(session, goal.system, snapshot) as taken:
        applier = Applier(session.tree, goal, report, report, taken, survey, uninterrupted)
        applier.run(plan, snapshot, rolls_back=rolls_back, is_exact=is_exact)
    if is_followed:
        states.follow_from(session, document, goal)
    return tuple(applier.unmet)
