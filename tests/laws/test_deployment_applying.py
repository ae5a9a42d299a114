"""What rtapply does in a simulated world, from anywhere, whatever fails on the way."""

from __future__ import annotations

from dataclasses import replace

from fake_manager import FakeManager
from fake_tree import fake_tree
from hypothesis import given, settings
from hypothesis import strategies as st
from systems import ACTIVE, INACTIVE, INSTANCES, by_key, disturb, disturbances, make_world, profiles

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.applying import Applier
from rtkit.deployment.deviations import deviations
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.planning.operators import judge
from rtkit.deployment.wanted import wanted
from rtkit.errors import RtkitError
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import LifeCycleState, ReturnCode

few = settings(max_examples=20, deadline=None)


def goal_of(world: FakeManager, profile, state=ACTIVE, parallel=0) -> DeploymentGoal:
    stand_ins = {c.instance for c in world.components.values() if c.is_stand_in}
    return DeploymentGoal(
        wanted(profile, world.host, stand_ins=stand_ins), state, parallel=parallel
    )


def reach(world: FakeManager, goal: DeploymentGoal, *, rolls_back: bool = False) -> list[str]:
    """Plan and apply; return the steps that were told."""
    tree = fake_tree(world)
    before = tree.snapshot()
    plan = goal.plan(before)
    assert judge(plan.model, plan.moves) == ""
    done: list[str] = []
    Applier(tree, goal, lambda _: None, done.append).run(plan, before, rolls_back=rolls_back)
    return done


def attempt(world: FakeManager, goal: DeploymentGoal, *, rolls_back: bool = False) -> str:
    """Return what is told when the goal is not reached; empty when it is."""
    try:
        reach(world, goal, rolls_back=rolls_back)
    except (RtkitError, KeyboardInterrupt) as error:
        return str(error) or "interrupted"
    return ""


def is_left(world: FakeManager, goal: DeploymentGoal) -> bool:
    return bool(goal.plan(world.snapshot()).moves)


def differs(world: FakeManager, goal: DeploymentGoal) -> list[str]:
    """Return what deviates but for sets and parameters that a type does not have."""
    live = LiveIndex(world.snapshot(), goal.system)
    found = deviations(goal.system, live, goal.state)
    return [d.text for d in found if d.kind not in ("parameter", "active-set")]


@given(profiles(), disturbances(), st.sampled_from([ACTIVE, INACTIVE]), st.sampled_from([0, 1, 2]))
@few
def test_the_goal_is_reached_from_anywhere_and_a_second_plan_is_empty(
    profile, disturbances, state, parallel
):
    world = make_world()
    goal = goal_of(world, profile, state, parallel)
    reach(world, goal)
    disturb(world, disturbances)
    goal = goal_of(world, profile, state, parallel)
    reach(world, goal)
    assert differs(world, goal) == []
    performed = len(world.performed)
    assert not is_left(world, goal)
    assert reach(world, goal) == []
    assert len(world.performed) == performed


@given(profiles(), profiles())
@few
def test_one_system_becomes_another(first, second):
    world = make_world()
    reach(world, goal_of(world, first))
    goal = goal_of(world, second)
    ours = {c.instance for c in goal.system.components}
    others = [c for c in world.snapshot().components if c.instance not in ours]
    moved = {c.instance for c in goal.system.components if is_elsewhere(world, c)}
    why = attempt(world, goal)
    if why:
        # Of another type, or a stand-in of another kind: that is told and not replaced.
        assert "--replace makes it again" in why
        why = attempt(world, replace(goal, replaces=True))
        assert not why
        assert differs(world, goal) == []
        assert not is_left(world, goal)
        return
    assert differs(world, goal) == []
    assert not is_left(world, goal)
    for facts in others:
        now = world.components[facts.instance]
        assert replace(now, names=()) == replace(facts, names=())
    ended = {a.instance for a in world.performed if isinstance(a, act.Delete)}
    assert ended <= moved


def is_elsewhere(world: FakeManager, component) -> bool:
    facts = world.components.get(component.instance)
    place = component.create.partition("manager_name=")[2].partition("&")[0] or world.manager
    return facts is not None and facts.process != place


@given(
    profiles(), disturbances(), st.integers(0, 14), st.sampled_from(["fail", "interrupt", "kill"])
)
@few
def test_broken_off_anywhere_it_is_run_again_and_finishes(profile, disturbances, when, how):
    world = make_world()
    reach(world, goal_of(world, profile))
    disturb(world, disturbances)
    count = 0

    def fault(_action: act.Action) -> Result | None:
        nonlocal count
        count += 1
        if count - 1 != when:
            return None
        if how == "interrupt":
            raise KeyboardInterrupt
        if how == "kill":
            world.fault = lambda _: Result(ReturnCode.ERROR, "refused", "gone")
        return Result(ReturnCode.ERROR, "refused", "no luck")

    world.fault = fault
    goal = goal_of(world, profile)
    why = attempt(world, goal)
    assert not why or "left" in why
    world.fault = lambda _: None
    goal = goal_of(world, profile)
    reach(world, goal)
    assert differs(world, goal) == []
    assert not is_left(world, goal)


@given(profiles(), disturbances(), st.integers(0, 14))
@few
def test_nothing_is_activated_before_what_it_needs(profile, disturbances, when):
    """Whenever a component is activated, its wanted connections and parameters hold."""
    world = make_world()
    goal = goal_of(world, profile)
    count = 0

    def watch(action: act.Action) -> Result | None:
        nonlocal count
        count += 1
        if count == when + 1:
            # What somebody else does meanwhile.
            disturb(world, [d for d in disturbances if not isinstance(d, act.SetParameters)])
        return None

    begun = lacking_at_activations(world, goal)
    if when == 0:
        reach(world, goal)
        assert not any(begun)
        return
    world.fault = watch
    if not attempt(world, goal):
        assert differs(world, goal) == []


@given(
    profiles(), disturbances(), st.sets(st.integers(0, 14), min_size=1, max_size=4), st.booleans()
)
@few
def test_steps_that_fail_activate_nothing_before_what_it_needs(
    profile, disturbances, failing, is_there
):
    """However often it is run again; in the end the goal is reached, with nothing left to do."""
    world = make_world()
    if is_there:
        reach(world, goal_of(world, profile, INACTIVE))
        disturb(world, disturbances)
    goal = goal_of(world, profile)
    begun = lacking_at_activations(world, goal)
    count = 0

    def fault(_action: act.Action) -> Result | None:
        nonlocal count
        count += 1
        return Result(ReturnCode.ERROR, "refused", "no luck") if count - 1 in failing else None

    world.fault = fault
    tries = 1
    while attempt(world, goal):
        tries += 1
        assert tries <= len(failing) + 1
    assert not any(begun), begun
    assert differs(world, goal) == []
    assert not is_left(world, goal)


def lacking_at_activations(world: FakeManager, goal: DeploymentGoal) -> list[list[str]]:
    """Return a list to which is added what each activation lacks at the moment that it begins."""
    begun: list[list[str]] = []
    perform = world.perform

    def performing(action: act.Action) -> Result:
        if isinstance(action, act.ChangeState) and action.transition == "activate":
            begun.append(lacking(world, goal, action.instance))
        return perform(action)

    world.perform = performing
    return begun


def lacking(world: FakeManager, goal: DeploymentGoal, instance: str) -> list[str]:
    live = LiveIndex(world.snapshot(), goal.system)
    path = goal.system.component(instance).path
    found = deviations(goal.system, live, goal.state)
    return [d.text for d in found if path in d.path.split() and d.kind == "connection"]


@given(
    profiles(),
    profiles(),
    st.sets(st.sampled_from(INSTANCES), max_size=2),
    st.integers(0, 14),
    st.none() | st.sampled_from(INSTANCES),
)
@few
def test_after_a_failure_the_way_back_leads_to_what_was(first, second, ill, when, failing):
    """Also with components in Error; what fails on the way back is told, the rest goes back."""
    world = make_world()
    reach(world, goal_of(world, first))
    for instance in ill & world.components.keys():
        world.set_state(instance, LifeCycleState.ERROR, "ValueError: no")
    before = world.snapshot()
    count = 0

    def fault(action: act.Action) -> Result | None:
        nonlocal count
        count += 1
        if count - 1 == when or (count > when and failing in instances_of(action)):
            return Result(ReturnCode.ERROR, "refused", "no luck")
        return None

    goal = goal_of(world, second)
    world.fault = fault
    why = attempt(world, goal, rolls_back=True)
    if "no luck" not in why:
        return
    _, back, told = why.partition("everything is as it was before")
    assert back, why
    unlike = {
        key
        for was, now in zip(essence(before), essence(world.snapshot()), strict=True)
        for key in was.keys() | now.keys()
        if was.get(key) != now.get(key)
    }
    assert bool(unlike) == bool(told)
    assert all(key in told for key in unlike)


def instances_of(action: act.Action) -> set[str]:
    if isinstance(action, act.Create):
        return {parse_create(action.create).instance_name}
    if isinstance(action, act.Connect):
        return {end.instance for end in action.connector.ports}
    return {getattr(action, "instance", "")}


def essence(snapshot: Snapshot) -> tuple[dict[str, object], ...]:
    """Return facts that are to be as they were: not how a create string is written."""
    components, connectors, _ = by_key(snapshot)
    return (
        {
            name: replace(c, create="", names=tuple(sorted(c.names)))
            for name, c in components.items()
        },
        connectors,
    )
