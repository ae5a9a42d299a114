"""Plans: the goal over the live system, and the cheapest plan to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.api import looking
from rtkit.deployment.packages import NO_PACKAGES, Packages
from rtkit.errors import UsageProblem

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.goal import DeploymentGoal
    from rtkit.deployment.planning.deployment_plan import DeploymentPlan
    from rtkit.deployment.planning.model import Model
    from rtkit.deployment.planning.model_builder import BuiltModel
    from rtkit.deployment.planning.step_costs import Costs
    from rtkit.deployment.system import WantedSystem
    from rtkit.tree.plan_locks import PlanLocks

ANY = "Any"
STATES = ("Active", "Inactive", ANY)
MEASURED, TABLE = "measured", "table"


Make = Callable[["DeploymentGoal", "Snapshot", "Model"], "DeploymentPlan"]
"""Makes a plan to a goal from what lives, which a model tells too."""


class Prepared(NamedTuple):
    """The document, the wanted system, the live system, and the plan between them."""

    document: SystemProfile
    goal: DeploymentGoal
    snapshot: Snapshot
    plan: DeploymentPlan
    survey: BuiltModel


class DeploymentInputs(NamedTuple):
    """The document, the wanted system and the live system."""

    document: SystemProfile
    goal: DeploymentGoal
    snapshot: Snapshot


class WayOptions(NamedTuple):
    """Options that constrain the way to the goal.

    Attributes:
        costs: ``NAME=NUMBER`` of kinds of steps.
        basis: Where the costs of the other kinds come from.
        stand_in: Generate what is missing.
        transmit: Stand-ins write values, and answer calls.
        replaces: End and replace what cannot be changed in place.
    """

    costs: tuple[str, ...] = ()
    basis: str = MEASURED
    stand_in: bool = False
    transmit: bool = False
    replaces: bool = False


class GoalOptions(NamedTuple):
    """Options that select the goal of a plan, and constrain the way to it.

    Attributes:
        state: State that every component is to be in, one of `STATES`.
        way: Those that constrain the way.
        prunes: End the other components, and remove the other connections.
    """

    state: str = STATES[0]
    way: WayOptions = WayOptions()
    prunes: bool = False


def options_record(document: SystemProfile, aim: GoalOptions) -> dict[str, Any]:
    """Return the options of a plan by name, as a saved plan tells them."""
    mapped = [f"{host}={other}" for host, other in document.mapped.items()]
    return {**aim.way._asdict(), "state": aim.state, "prunes": aim.prunes, "mapped": mapped}


def read_options(record: Mapping[str, Any]) -> tuple[tuple[str, ...], GoalOptions]:
    """Return the options that a saved plan tells.

    Raises:
        TypeError: One is missing, or there is no such option.
    """
    way = {name: value for name, value in record.items() if name in WayOptions._fields}
    others = {name: value for name, value in record.items() if name not in (*way, "mapped")}
    return tuple(record.get("mapped") or ()), GoalOptions(way=WayOptions(**way), **others)


def prepare(
    session: Session,
    document: SystemProfile,
    aim: GoalOptions,
    *,
    is_dry: bool,
    parallel: int = 0,
    lock: PlanLocks | None = None,
    make: Make | None = None,
    leaves_out: bool = False,
) -> Prepared:
    """Look at what lives, and plan, or `make` the plan otherwise.

    With `leaves_out` it is also planned for the rest where hosts are lost, and none is started.

    Raises:
        Impossible: There is no plan; names the conditions that cannot hold together.
    """
    from rtkit.deployment.system import without
    from rtkit.fast_dataclass import replace
    from rtkit.rtc.enums import LifeCycleState

    _, goal, snapshot = begin(
        session,
        document,
        aim.way,
        is_dry=is_dry,
        parallel=parallel,
        starts=not leaves_out,
        may_lack=leaves_out,
        lock=lock,
    )
    if leaves_out and snapshot.unreachable:
        goal = replace(goal, system=without(goal.system, snapshot.unreachable))
    wished = None if aim.state == ANY else LifeCycleState(aim.state)
    goal = replace(goal, state=wished, prunes=aim.prunes)
    survey = goal.survey(snapshot)
    session.warn(survey.notes, mark="")
    plan = (make or _cheapest)(goal, snapshot, survey.model)
    return Prepared(document, goal, snapshot, plan, survey)


def _cheapest(goal: DeploymentGoal, _snapshot: Snapshot, model: Model) -> DeploymentPlan:
    from rtkit.deployment.planning.deployment_plan import make_plan

    return make_plan(model, goal.ranks)


def begin(
    session: Session,
    document: SystemProfile,
    way: WayOptions,
    *,
    is_dry: bool,
    parallel: int = 0,
    starts: bool = False,
    may_lack: bool = False,
    lock: PlanLocks | None = None,
) -> DeploymentInputs:
    """Look at what lives; the goal is that all of the profile is active.

    Managers that do not run are an error, unless the plan `starts` them, or some `may_lack`. A
    `lock` keeps others off from before the look. What is to be on a host that is linked and cannot
    be reached is left out of a dry run.

    Raises:
        InvalidDocument: The profile makes no sense.
        Unreachable: No manager answers.
    """
    from rtkit.api import owning
    from rtkit.api.displaced import places_to_leave, where_they_live
    from rtkit.api.packaged import supplied, unpackaged
    from rtkit.api.placing import placed
    from rtkit.api.preflight import check_reserved, look_ahead
    from rtkit.deployment.goal import DeploymentGoal
    from rtkit.deployment.system import without

    places = placed(session, document, stand_in=way.stand_in)
    document = places.document
    moving = {**owning.elsewhere(session, document), **places.moving}
    if may_lack:
        document = where_they_live(session, document)
    else:
        session.warn(owning.absent_hosts(document))
        moving = {**places_to_leave(session, document), **moving}
    snapshot = looking.look(
        session,
        document,
        dry_run=is_dry,
        may_lack=may_lack,
        starts=starts,
        lock=lock,
        moving=moving,
    )
    packaged = (
        unpackaged(session, document, snapshot)
        if way.stand_in
        else supplied(session, document, snapshot, is_dry=is_dry)
    )
    document, packages = packaged.document, packaged.packages
    known = None if way.stand_in else packaged.types
    system = looking.wanted_system(
        session,
        document,
        snapshot,
        stand_in=way.stand_in,
        transmit=way.transmit,
        known_types=known,
        moving=moving,
    )
    if is_dry and snapshot.unreachable:
        system = without(system, snapshot.unreachable)
    check_reserved(session, system, snapshot)
    ranks = _ranks(session, document, system)
    lacks = {**packaged.lacks, **places.lacks}
    feasibility = look_ahead(session, system, snapshot, installs=packages.of, lacks=lacks)
    is_measured = way.basis == MEASURED
    table = settled_costs(
        session, way.costs, system, snapshot, is_measured=is_measured, packages=packages
    )
    goal = DeploymentGoal(
        system,
        ranks=ranks,
        costs=table,
        parallel=parallel,
        feasibility=feasibility,
        replaces=way.replaces,
        is_strict=session.is_strict,
        packages=packages,
    )
    return DeploymentInputs(document, goal, snapshot)


def settled_costs(
    session: Session,
    given: tuple[str, ...],
    system: WantedSystem,
    snapshot: Snapshot,
    *,
    is_measured: bool,
    packages: Packages = NO_PACKAGES,
) -> Costs:
    """Return the costs of steps: from the table, as measured, from the profile, from the user.

    Raises:
        UsageProblem: One is not NAME=NUMBER, or there is no such kind of step and no component.
    """
    from rtkit.api import step_times
    from rtkit.deployment.planning import step_costs as costs

    table = costs.Costs()
    user_costs = read_costs(given, system, snapshot, packages)
    if is_measured:
        types = step_times.types_of(system, snapshot)
        table = table.over(step_times.read(session).costs(types), costs.MEASURED)
    stated = {
        f"{kind} {component.instance}": cost
        for component in system.components
        for kind, cost in component.costs.items()
    }
    return table.over(stated, costs.PROFILE).over(user_costs, costs.USER)


def read_costs(
    given: tuple[str, ...],
    system: WantedSystem,
    snapshot: Snapshot,
    packages: Packages = NO_PACKAGES,
) -> Mapping[str, float]:
    """Return the costs that the user gave; a component stands for interrupting it.

    Raises:
        UsageProblem: One is not NAME=NUMBER, or there is no such kind of step, no component, or
            nothing of that name to which such a step could be done.
    """
    from rtkit.deployment.planning.default_costs import DEFAULT_COSTS, is_cost
    from rtkit.deployment.planning.step_costs import interruption, subjects
    from rtkit.rtc.nearest import did_you_mean

    costs: dict[str, float] = {}
    names = {component.instance for component in system.components}
    for item in given:
        name, equals, text = item.rpartition("=")
        try:
            number = float(text)
        except ValueError:
            number = -1.0
        if not equals or not is_cost(number):
            raise UsageProblem(f"--cost needs NAME=NUMBER with a number above 0: {item}")
        kind, _, subject = name.partition(" ")
        if name in names:
            costs.update(interruption(name, number))
        elif kind not in DEFAULT_COSTS:
            known = ", ".join(DEFAULT_COSTS)
            hint = did_you_mean(name, [*names, *DEFAULT_COSTS])
            raise UsageProblem(f"--cost: no component and no kind of step ({known}): {name}{hint}")
        elif subject and subject not in (there := subjects(kind, system, snapshot, packages)):
            hint = did_you_mean(subject, there)
            raise UsageProblem(f"--cost: nothing to {kind} is called {subject}{hint}")
        else:
            costs[name] = number
    return costs


def _ranks(session: Session, document: SystemProfile, system: WantedSystem) -> dict[str, int]:
    """Return the order in which the profile has components activated, if it has one."""
    from rtkit.deployment.conditions import start_orders
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.running import start_plan
    from rtkit.deployment.start_schedule import expected_order

    with document.naming():
        orders = start_orders(document.profile)
    if not orders:
        return {}
    plan = start_plan(system, LiveIndex(looking.nothing(session.usual_manager), system), orders)
    if any(condition.wait_ms for each in orders.values() for condition in each):
        session.verbose(
            "waiting times of Activation are kept by rtstart only; their order is kept here"
        )
    return {target.instance: rank for rank, target in enumerate(expected_order(plan))}
