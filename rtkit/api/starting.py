"""Brings systems up, starts, stops and tears them down; what breaks off tells how far it got."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from rtkit.api import looking
from rtkit.errors import InvalidDocument, RtkitError

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.conditions import Orders
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.layered_plan import LayeredPlan
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.planning.step_costs import Costs
    from rtkit.deployment.start_schedule import StartPlan
    from rtkit.deployment.system import WantedSystem
    from rtkit.tree.plan_locks import PlanLocks

PlanFor = Callable[["WantedSystem", "LiveIndex"], "StartPlan"]


class StartInputs(NamedTuple):
    """The wanted system, the live one, and the plan to start or stop it."""

    system: WantedSystem
    snapshot: Snapshot
    plan: StartPlan


def bring_up(
    session: Session,
    document: SystemProfile,
    *,
    may_create: bool = True,
    stand_in: bool = False,
    transmit: bool = False,
    is_dry: bool = False,
    lock: PlanLocks | None = None,
) -> Sequence[LayeredPlan]:
    """Bring a system up, see `rtkit.Tree.bring_up`; a dry run returns the plans of that."""
    from rtkit.api import states
    from rtkit.api.displaced import where_they_live
    from rtkit.api.packaged import bundled
    from rtkit.api.placing import placed
    from rtkit.api.preflight import check_reserved, missing
    from rtkit.deployment.creation import bring_up_plans

    is_followed = not is_dry and states.is_follow_wanted(session, document)
    unplaced: Mapping[str, str] = {}
    if may_create:
        document, unplaced, _ = placed(session, document, stand_in=stand_in)
    document = where_they_live(session, document, makes=may_create)
    found = looking.look(session, document, dry_run=is_dry, starts=may_create, lock=lock)
    with looking.managers_started(session, found, dry_run=is_dry) as before:
        creates = may_create and not stand_in
        packaged = bundled(session, document, before, installs=not is_dry)
        document = packaged.document
        system = looking.wanted_system(
            session,
            document,
            before,
            stand_in=stand_in,
            transmit=transmit,
            known_types=packaged.types if creates else None,
        )
        check_reserved(session, system, before)
        lacks = {**unplaced, **missing(session, system, before)} if may_create else {}
        with document.naming():
            plans: list[LayeredPlan] = []
            if is_dry or session.watch is not None:
                plans = list(bring_up_plans(system, before, may_create=may_create, lacks=lacks))
                _report_layers(session, plans, system, before)
            if is_dry:
                return plans
            _create(session, system, before, lacks, may_create=may_create)
            if session.watch is not None:
                session.watch.reached()
    if is_followed:
        states.follow_now(session, document, stand_in=stand_in, transmit=transmit)
    return ()


def _create(
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


def _report_layers(
    session: Session, plans: Sequence[LayeredPlan], system: WantedSystem, before: Snapshot
) -> None:
    if session.watch is not None:
        from rtkit.deployment.plan_records import layered_record

        session.watch.plan(layered_record(plans, _costs(session, system, before)))


def _costs(session: Session, system: WantedSystem, snapshot: Snapshot) -> Costs:
    from rtkit.api.planning import settled_costs

    return settled_costs(session, (), system, snapshot, is_measured=True)


def start_plan_of(document: SystemProfile, *, wait: bool) -> PlanFor:
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


def stop_plan_of(session: Session, document: SystemProfile, *, wait: bool) -> PlanFor:
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
    document: SystemProfile,
    plan_for: PlanFor,
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
    from rtkit.api.displaced import where_they_live
    from rtkit.deployment.live_index import LiveIndex

    document = where_they_live(session, document)
    if snapshot is None:
        snapshot = looking.look(session, document, dry_run=is_dry, may_lack=may_lack)
    system = looking.wanted_system(session, document, snapshot)
    plan = plan_for(system, LiveIndex(snapshot, system))
    for text in plan.warnings():
        session.fail(f"warning: {text}")
    if session.watch is not None:
        from rtkit.deployment.plan_records import start_record

        session.watch.plan(start_record(plan, _costs(session, system, snapshot)))
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
        starter = Starter(
            session.tree, plan, session.report, session.fail, bound_s, count, taken, session.watch
        )
        starter.run()


def teardown(
    session: Session,
    document: SystemProfile,
    *,
    ends_components: bool,
    uninstalls: bool = False,
    is_dry: bool = False,
    lock: PlanLocks | None = None,
) -> tuple[LayeredPlan, list[str]]:
    """Remove the connections of a system, perhaps its components too; return the plan of that.

    With the components packages that plans installed for it alone are uninstalled on request,
    unless something uses them; the second result tells these steps. A `lock` keeps plans of others
    off once nobody follows the system any more.

    Raises:
        Refused: It was broken off; the message tells how far it went. Or somebody else carries a
            plan out at one of its managers.
        KeyboardInterrupt: Interrupted; its text tells how far it went.
    """
    from rtkit.api import owning, states
    from rtkit.api.displaced import forget, homes_of, where_they_live
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.running import teardown_plan

    homes = homes_of(session, document)
    document = where_they_live(session, document)
    snapshot = looking.look(session, document, dry_run=is_dry, may_lack=True)
    system = looking.wanted_system(session, document, snapshot)
    if is_dry:
        plan = teardown_plan(system, LiveIndex(snapshot, system), ends_components=ends_components)
        _report_layers(session, [plan], system, snapshot)
    else:
        with owning.given_up(session, document, ends=ends_components):
            if states.end_if_followed(session, document, snapshot) or lock is not None:
                looking.take(session, lock)
                snapshot = looking.remains(session)
            plan = _torn_down(session, system, snapshot, ends_components=ends_components)
        if ends_components:
            forget(session, document, homes)
    if not (uninstalls and ends_components):
        return plan, []
    return plan, _uninstall(session, document, system, is_dry=is_dry)


def _torn_down(
    session: Session, system: WantedSystem, snapshot: Snapshot, *, ends_components: bool
) -> LayeredPlan:
    """Carry the plan of a teardown out; return it."""
    from rtkit.api import step_times
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.running import left_now, teardown_plan

    plan = teardown_plan(system, LiveIndex(snapshot, system), ends_components=ends_components)
    _report_layers(session, [plan], system, snapshot)
    with (
        _reporting_progress(session, system, left_now),
        step_times.noting(session, system, snapshot) as taken,
    ):
        looking.runner(session, taken=taken).run(plan)
    return plan


def _uninstall(
    session: Session, document: SystemProfile, system: WantedSystem, *, is_dry: bool
) -> list[str]:
    from rtkit.api.packaged import leftover
    from rtkit.deployment.applying import Applier
    from rtkit.deployment.goal import DeploymentGoal
    from rtkit.deployment.planning.rendering import as_plain
    from rtkit.tree.grace import uninterrupted

    snapshot = looking.remains(session)
    names = frozenset(component.instance for component in system.components)
    packages = leftover(session, document, snapshot)
    goal = DeploymentGoal(system, absent=names, packages=packages)
    plan = goal.plan(snapshot)
    watch = session.watch
    if not is_dry and plan.moves:
        report = session.verbose
        applier = Applier(session.tree, goal, report, report, careful=uninterrupted, watch=watch)
        applier.run(plan, snapshot)
    elif watch is not None and plan.moves:
        record = as_plain(plan, goal.costs)
        # The components, which live in a dry run, are ended by the plan that was told before.
        steps = [each for each in record["steps"] if each["kind"] == "uninstall"]
        watch.plan({**record, "steps": steps}, "packages that nothing needs any more")
    return [move.text for move in plan.moves if move.kind == "uninstall"]


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
