"""Moves one component to another slave, manager or host by the cheapest plan; killed, it can go on.

What the component was like is in a file, `MoveRecord`, from before the first step until all is
done: so the same command goes on where it was killed.
"""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from rtkit.api import move_records
from rtkit.errors import Refused, RtkitError
from rtkit.rtc.names import (
    MANAGER_SUFFIX,
    Path,
    check_instance_name,
    is_local_host,
    manager_on,
    split_manager,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rtkit.api.session import Session
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.goal import DeploymentGoal
    from rtkit.deployment.moving import MoveRecord
    from rtkit.deployment.planning.deployment_plan import DeploymentPlan
    from rtkit.deployment.planning.model_builder import BuiltModel
    from rtkit.tree.plan_locks import PlanLocks


class Move(NamedTuple):
    """A move that is planned: where from and where to, and the way from what lives now."""

    record: MoveRecord
    goal: DeploymentGoal
    before: Snapshot
    plan: DeploymentPlan
    survey: BuiltModel


def prepare(session: Session, path: Path, target: Path, *, lock: PlanLocks | None = None) -> Move:
    """Look at what lives and plan the move of the component at a path; nothing is changed.

    A `lock` keeps others off from before the look.

    Raises:
        NotFound: There is no such component, or target.
        Unreachable: A manager that has to do with it does not run, or does not answer.
        Refused: The component cannot be moved, or its name is taken there.
        Impossible: Its module is not found there.
    """
    from rtkit.deployment.moving import before, move_goal
    from rtkit.fast_dataclass import replace
    from rtkit.tree.place import is_far_address

    for each in (path, target):
        if each.elements and is_far_address(each.elements[0]):
            raise Refused(
                f"{each.typed} is reached over TLS: components are moved there by commands of that"
                f" host, or over a link to it (rthost add NAME tls:{each.elements[0]})"
            )
    place = _place(target)
    record = move_records.unfinished(path, place)
    if record is None:
        record = _begun(session, path, place, lock)
    else:
        _join(session, record.managers, record.homes, lock)
    from rtkit.api.looking import snapshot
    from rtkit.api.planning import settled_costs
    from rtkit.api.preflight import look_ahead

    now = snapshot(session)
    goal = move_goal(record)
    goal = replace(
        goal,
        costs=settled_costs(session, (), goal.system, now, is_measured=True),
        feasibility=look_ahead(session, goal.system, now),
        is_strict=session.is_strict,
    )
    was = before(now, record)
    survey = goal.survey(now, was)
    session.warn(survey.notes, mark="")
    return Move(record, goal, was, goal.plan(now, was), survey)


def carry_out(session: Session, move: Move) -> None:
    """Carry a move out, if anything is left of it; when a step fails, lead back to what was before.

    Raises:
        Refused: A step failed; the message says what became of it.
        Unreachable: A manager does not answer.
        KeyboardInterrupt: Interrupted; its text states what is left.
    """
    from rtkit.api import owning, step_times
    from rtkit.deployment.applying import Applier
    from rtkit.tree.grace import uninterrupted

    record, goal, was, plan, survey = move
    if not plan.moves:
        move_records.finish(record)
        return
    move_records.keep(record)
    owning.claim_one(session, record.facts.instance, record.manager)
    report = session.report
    try:
        _hold(session, record)
        now = uninterrupted(session.tree.snapshot)
        survey = goal.survey(now, was)
        plan = goal.plan(now, was)
        with step_times.noting(session, goal.system, was) as taken:
            applier = Applier(
                session.tree, goal, report, report, taken, survey, uninterrupted, session.watch
            )
            applier.run(plan, was, rolls_back=True)
    except (RtkitError, KeyboardInterrupt):
        with suppress(RtkitError):
            if _is_back(session.tree.remains(), record):
                move_records.forget(record)
        raise
    move_records.finish(record)


def _hold(session: Session, record: MoveRecord) -> None:
    """Have no value lost that is on its way; what fails here the plan does, or reports."""
    from rtkit.deployment.moving import holding_steps

    now = session.tree.snapshot()
    facts = now.component(record.facts.instance)
    if facts is None or facts.process != record.facts.process:
        return  # it has begun before
    there = {each.connector_id for each in now.connectors}
    for steps in holding_steps(record):
        left = [each for each in steps if getattr(each, "connector_id", "") in {"", *there}]
        with suppress(RtkitError):
            for result in session.tree.apply(left, is_ordered=False):
                if not result.ok:
                    session.verbose(result.why)


def _place(target: Path) -> tuple[str, str]:
    """Return the manager, as plans call it, and the slave that a path names.

    Raises:
        NotFound: Its host is not linked.
        Refused: It is no path of a manager or slave.
    """
    from rtkit.link.host_links import is_linked
    from rtkit.link.places import host_name
    from rtkit.tree.resolve import no_such_host

    host, *names = target.elements or ("",)
    is_far = bool(host) and not is_local_host(host, host_name())
    if is_far and not is_linked(host):
        raise no_such_host(target.typed, host)
    is_place = len(names) in (1, 2) and all(each.endswith(MANAGER_SUFFIX) for each in names)
    if not is_place or target.port is not None:
        raise Refused(f"Not a manager, and not a slave: {target.typed}")
    manager, slave, *_ = (*(each.removesuffix(MANAGER_SUFFIX) for each in names), "")
    for name in filter(None, (manager, slave)):
        check_instance_name(name)
    slave = "" if slave == manager else slave
    return manager_on(manager, host) if is_far else manager, slave


def _begun(
    session: Session, path: Path, place: tuple[str, str], lock: PlanLocks | None
) -> MoveRecord:
    from rtkit.api.looking import snapshot
    from rtkit.deployment.moving import ends_elsewhere, place_text, record_of
    from rtkit.deployment.multi_manager import in_plan
    from rtkit.link.places import host_name
    from rtkit.tree.resolve import component

    root, hostname = session.root(path, is_deep=False)
    instance, tree, here = component(root, path, hostname).instance, session.tree, host_name()
    source = tree.manager if is_local_host(tree.host, here) else manager_on(tree.manager, tree.host)
    homes = ends_elsewhere(in_plan(tree.snapshot(), source, here), instance)
    _join(session, (source, *homes.values(), place[0]), homes, lock)
    there = place_text(place[0])
    if source != place[0] and session.tree.at(place[0]).snapshot().component(instance) is not None:
        raise Refused(f"{instance} cannot be moved: its name is taken at {there}")
    whole = snapshot(session)
    record = record_of(whole, instance, source, place, homes)
    own = session.tree.at(source).snapshot()
    joined = {each.connector_id for each in record.connectors}
    lost = [
        each
        for each in own.connectors
        if any(end.instance == instance for end in each.ports) and each.connector_id not in joined
    ]
    if lost:
        raise Refused(f"{instance} cannot be moved: only half of {lost[0].connector_id} is there")
    return record


def _join(
    session: Session, names: Iterable[str], homes: Mapping[str, str], lock: PlanLocks | None
) -> None:
    """Have a session ask several managers as one, the usual one first, and take their locks.

    That one is among them where one is on another host: its lock holds off other commands here.

    Raises:
        Unreachable: One does not run.
    """
    from rtkit.api.gathering import connected
    from rtkit.api.looking import take
    from rtkit.tree.manager_set import ManagerSet

    usual = session.usual_manager
    found = list(dict.fromkeys(names))
    if usual not in found and any(split_manager(name)[1] for name in found):
        found.append(usual)
    found.sort(key=lambda name: name != usual)
    if session.finds_managers:
        trees = {}
        try:
            for name in found:
                trees[name] = connected(name, session.timeout_s)
        except BaseException:
            for tree in trees.values():
                tree.close()
            raise
        session.ask(ManagerSet(found, trees, dict(homes)) if len(found) > 1 else trees[found[0]])
    elif found != [session.tree.manager]:
        raise Refused(f"managers {', '.join(found)} have to do with it: only one is connected")
    take(session, lock)


def _is_back(now: Snapshot, record: MoveRecord) -> bool:
    """Return whether all that a move took apart is as it was, so that nothing is to be kept."""
    from rtkit.deployment.multi_manager import homes_in

    name, there = record.facts.instance, {each.connector_id for each in now.connectors}
    facts = now.component(name)
    return (
        facts is not None
        and not facts.zombie
        and facts.process == record.facts.process
        and homes_in(now)[name] == record.source.manager
        and facts.state == record.facts.state
        and facts.sets == record.facts.sets
        and {each.connector_id for each in record.connectors} <= there
    )
