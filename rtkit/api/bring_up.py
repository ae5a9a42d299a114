"""Brings the system of a profile up, and starts managers that it needs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.api import looking

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rtkit.api.document import SystemDocument
    from rtkit.api.session import Session
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.layered_plan import LayeredPlan
    from rtkit.deployment.system import WantedSystem
    from rtkit.tree.plan_locks import PlanLocks


def bring_up(
    session: Session,
    document: SystemDocument,
    mapped: tuple[str, ...] = (),
    *,
    may_create: bool = True,
    stand_in: bool = False,
    transmit: bool = False,
    is_dry: bool = False,
    lock: PlanLocks | None = None,
) -> Sequence[LayeredPlan]:
    """Make, connect and configure what a profile describes; a dry run returns the plans of that.

    Raises:
        InvalidDocument: The profile makes no sense.
        Refused: Something required failed; what was made is removed again.
        Unreachable: A manager does not answer.
    """
    from rtkit.api import states
    from rtkit.api.known_types import known_types
    from rtkit.api.preflight import check_reserved, missing
    from rtkit.deployment.creation import bring_up_plans

    is_followed = not is_dry and states.is_follow_wanted(session, document)
    found = looking.look(session, document.profile, dry_run=is_dry, starts=may_create, lock=lock)
    with looking.managers_started(session, found, dry_run=is_dry) as before:
        creates = may_create and not stand_in
        system = looking.wanted_system(
            session,
            document,
            before,
            stand_in=stand_in,
            transmit=transmit,
            mapped=mapped,
            known_types=known_types(document.profile, before) if creates else None,
        )
        check_reserved(session, system, before)
        lacks = missing(session, system, before) if may_create else {}
        with document.naming():
            if is_dry:
                return list(bring_up_plans(system, before, may_create=may_create, lacks=lacks))
            _carry_out(session, system, before, lacks, may_create=may_create)
    if is_followed:
        states.follow_now(session, document, mapped, stand_in=stand_in, transmit=transmit)
    return ()


def _carry_out(
    session: Session,
    system: WantedSystem,
    before: Snapshot,
    lacks: dict[str, str],
    *,
    may_create: bool,
) -> None:
    from rtkit.api import step_times
    from rtkit.tree.resurrect import resurrect

    with (
        step_times.noting(session, system, before) as taken,
        session.counting("resurrect") as count,
    ):
        runner = looking.runner(session, count, taken)
        resurrect(session.tree, system, before, runner, may_create=may_create, lacks=lacks)
