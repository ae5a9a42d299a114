"""Starts, stops and tears down systems: plans that are never undone, and tell how far they got."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from rtkit.api import looking
from rtkit.errors import InvalidDocument, RtkitError

if TYPE_CHECKING:
    from rtkit.api.document import SystemDocument
    from rtkit.api.session import Session
    from rtkit.deployment.conditions import Orders
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.layered_plan import LayeredPlan
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.start_schedule import StartPlan
    from rtkit.deployment.system import WantedSystem

PlanFor = Callable[["WantedSystem", "LiveIndex"], "StartPlan"]


class StartInputs(NamedTuple):
    """The wanted system, the live one, and the plan to start or stop it."""

    system: WantedSystem
    snapshot: Snapshot
    plan: StartPlan


def start_plan_of(document: SystemDocument, *, wait: bool) -> PlanFor:
    """Return what makes the plan to start a system.

    Raises:
        InvalidDocument: Its orders make no sense, or it could not be stopped as written.
    """
    from rtkit.deployment.conditions import start_orders, stop_orders
    from rtkit.deployment.running import start_plan

    with document.naming():
        orders = start_orders(document.profile)
        stop_orders(document.profile)  # a system that cannot be stopped as written is not started
    return lambda system, live: start_plan(system, live, orders, wait=wait)


def stop_plan_of(session: Session, document: SystemDocument, *, wait: bool) -> PlanFor:
    """Return what makes the plan to stop a system.

    Raises:
        InvalidDocument: Its orders of stopping make no sense.
    """
    from rtkit.deployment.conditions import NO_ORDERS, start_orders, stop_orders
    from rtkit.deployment.running import stop_plan

    with document.naming():
        orders = stop_orders(document.profile)
    started: Orders = NO_ORDERS
    try:
        if not orders:
            with document.naming():
                started = start_orders(document.profile)
    except InvalidDocument as error:
        session.fail(f"{error}; stopped in reverse of the order of the components")
    return lambda system, live: stop_plan(system, live, orders, started=started, wait=wait)


def prepare(
    session: Session,
    document: SystemDocument,
    plan_for: PlanFor,
    mapped: tuple[str, ...] = (),
    snapshot: Snapshot | None = None,
    *,
    is_dry: bool = False,
    may_lack: bool = False,
) -> StartInputs:
    """Look at what lives, unless a `snapshot` is given, and plan.

    With `may_lack` some of several managers may be missing.

    Raises:
        Unreachable: No manager answers.
    """
    from rtkit.deployment.live_index import LiveIndex

    if snapshot is None:
        snapshot = looking.look(session, document.profile, dry_run=is_dry, may_lack=may_lack)
    system = looking.wanted_system(session, document, snapshot, mapped=mapped)
    plan = plan_for(system, LiveIndex(snapshot, system))
    for text in plan.warnings():
        session.fail(f"warning: {text}")
    return StartInputs(system, snapshot, plan)


def carry_out(session: Session, inputs: StartInputs, timeout_s: float | None = None) -> None:
    """Carry out a plan; `timeout_s` bounds one with conditions as a whole.

    Raises:
        Refused: It was broken off; the message tells how far it went.
        KeyboardInterrupt: Interrupted; its text tells how far it went.
    """
    from rtkit.api import step_times
    from rtkit.deployment.running import active_now
    from rtkit.tree.start import Starter

    system, snapshot, plan = inputs
    bound_s = timeout_s if plan.has_conditions else None
    looking.runner(session).check(plan.checks)
    with (
        _reporting_progress(session, system, active_now),
        step_times.noting(session, system, snapshot) as taken,
        session.counting(session.name.split()[-1]) as count,
    ):
        starter = Starter(session.tree, plan, session.report, session.fail, bound_s, count, taken)
        starter.run()


def teardown(
    session: Session,
    document: SystemDocument,
    mapped: tuple[str, ...] = (),
    *,
    ends_components: bool,
    is_dry: bool = False,
) -> LayeredPlan:
    """Remove the connections of a system, perhaps its components too; return the plan of that.

    Raises:
        Refused: It was broken off; the message tells how far it went.
        KeyboardInterrupt: Interrupted; its text tells how far it went.
    """
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.running import left_now, teardown_plan

    snapshot = looking.look(session, document.profile, dry_run=is_dry, may_lack=True)
    system = looking.wanted_system(session, document, snapshot, mapped=mapped)
    if not is_dry:
        from rtkit.api import states

        if states.end_if_followed(session, document, snapshot):
            snapshot = looking.remains(session)
    plan = teardown_plan(system, LiveIndex(snapshot, system), ends_components=ends_components)
    if not is_dry:
        from rtkit.api import step_times

        with (
            _reporting_progress(session, system, left_now),
            step_times.noting(session, system, snapshot) as taken,
        ):
            looking.runner(session, taken=taken).run(plan)
    return plan


@contextmanager
def _reporting_progress(
    session: Session, system: WantedSystem, describe: Callable[[WantedSystem, LiveIndex], str]
) -> Iterator[None]:
    """Add the progress to an error that ends the command; `describe` reads it off the live system.

    Raises:
        RtkitError: What was raised inside.
        KeyboardInterrupt: Likewise.
    """
    try:
        yield
    except RtkitError as error:
        raise type(error)(f"{error}; {_progress(session, system, describe)}") from error
    except KeyboardInterrupt as error:
        more = _progress(session, system, describe)
        raise KeyboardInterrupt("; ".join(filter(None, (str(error), more)))) from error


def _progress(
    session: Session, system: WantedSystem, describe: Callable[[WantedSystem, LiveIndex], str]
) -> str:
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.tree.grace import uninterrupted

    try:
        return describe(system, LiveIndex(uninterrupted(lambda: session.tree.remains()), system))
    except (RtkitError, KeyboardInterrupt) as trouble:
        return f"how far it got is not known ({str(trouble) or 'interrupted again'})"
