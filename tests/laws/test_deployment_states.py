"""Systems led from state to state in a simulated world, whatever is wished in each."""

from __future__ import annotations

from dataclasses import replace

from fake_manager import FakeManager
from fake_tree import fake_tree
from hypothesis import given, settings
from hypothesis import strategies as st
from systems import INSTANCES, disturb, disturbances, make_world, profiles

from rtkit.deployment import actions as act
from rtkit.deployment.applying import Applier
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.states.variants import StateDifference, variant
from rtkit.deployment.wanted import wanted

few = settings(max_examples=25, deadline=None)
systems = profiles(stand_ins=False)
names = st.sampled_from(["*", *INSTANCES])
wish = st.one_of(
    st.builds(
        StateDifference,
        names,
        st.just(""),
        st.sampled_from(["Active", "Inactive", "Absent", "Any"]),
    ),
    st.builds(
        StateDifference, st.sampled_from(INSTANCES), st.just(".a"), st.sampled_from(["0", "1", "7"])
    ),
    st.builds(StateDifference, st.sampled_from(INSTANCES), st.just("active_set"), st.just("fast")),
)
states = st.lists(st.lists(wish, max_size=4), min_size=2, max_size=3)


def goal_in(goal: DeploymentGoal, wished: list[StateDifference]) -> DeploymentGoal:
    made = variant(goal.system, wished)
    return replace(goal, system=made.system, states=made.states, absent=made.absent)


def lead(world: FakeManager, goal: DeploymentGoal) -> None:
    tree = fake_tree(world)
    before = tree.snapshot()
    Applier(tree, goal, lambda _: None, lambda _: None).run(goal.plan(before), before)


@given(systems, states, st.lists(st.integers(0, 2), min_size=1, max_size=4), disturbances())
@few
def test_every_state_is_reached_from_every_other_and_then_holds(profile, told, way, others):
    world = make_world()
    usual = DeploymentGoal(wanted(profile, world.host))
    goals = [goal_in(usual, wished) for wished in told]
    for number, index in enumerate(way):
        goal = goals[index % len(goals)]
        lead(world, goal)
        snapshot = world.snapshot()
        assert goal.holds(snapshot)
        assert not goal.plan(snapshot).moves
        alive = {c.instance for c in snapshot.components if not c.zombie}
        assert goal.absent.isdisjoint(alive)
        performed = len(world.performed)
        lead(world, goal)
        assert len(world.performed) == performed
        if number == 0:
            disturb(world, others)


@given(systems, states)
@few
def test_what_two_states_wish_alike_is_not_touched(profile, told):
    world = make_world()
    usual = DeploymentGoal(wanted(profile, world.host))
    one, other = (variant(usual.system, wished) for wished in told[:2])
    goals = [goal_in(usual, wished) for wished in told[:2]]
    lead(world, goals[0])
    world.performed.clear()
    lead(world, goals[1])
    alike = {
        component.instance
        for component in other.system.components
        if component == one.system.component(component.instance)
        and one.states[component.instance] == other.states[component.instance]
        and (component.instance in one.absent) == (component.instance in other.absent)
    }
    touching = (act.Create, act.Delete, act.ChangeState, act.SetParameters, act.ActivateSet)
    for action in world.performed:
        if isinstance(action, act.Create):
            assert action.names[0].rpartition("/")[2].removesuffix(".rtc") not in alike
        elif isinstance(action, touching):
            assert action.instance not in alike
