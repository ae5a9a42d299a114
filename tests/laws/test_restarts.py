"""What a manager makes again is what a plan would: afterwards `rtplan` has nothing to do.

The real core over simulated processes; random systems, brought up by the commands and changed by
users, whose slaves die and whose components fall into Error.
"""

from __future__ import annotations

from dataclasses import replace

from fake_manager import FakeManager
from fake_tree import fake_tree
from hypothesis import given, settings
from hypothesis import strategies as st
from systems import ACTIVE, INSTANCES, disturbances, make_world, profiles

from rtkit.deployment import actions as act
from rtkit.deployment.facts import RestartStatus, Snapshot
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.runner import PlanRunner
from rtkit.deployment.running import start_plan
from rtkit.deployment.system import WantedSystem
from rtkit.deployment.wanted import wanted
from rtkit.rtc.enums import LifeCycleState
from rtkit.tree.resurrect import resurrect
from rtkit.tree.start import Starter

few = settings(max_examples=40, deadline=None)
ends = st.lists(st.sampled_from(["s1", "s2", *INSTANCES]), min_size=1, max_size=4)


def silent(*_: object) -> None:
    """Hear nothing."""


def always_restarting() -> FakeManager:
    """Return a manager that makes everything again."""
    world = FakeManager(make_world().types.values())
    world.shell.state.settings.change("manager.restart", "always")
    world.shell.state.settings.change("manager.shutdown_on_nortcs", "NO")
    return world


def brought_up(world: FakeManager, profile: object) -> WantedSystem:
    tree = fake_tree(world)
    system = wanted(profile, world.host)
    resurrect(tree, system, tree.snapshot(), PlanRunner(tree, silent))
    plan = start_plan(system, LiveIndex(tree.snapshot(), system))
    Starter(tree, plan, silent, silent).run()
    return system


def end(world: FakeManager, what: str) -> None:
    """Kill a slave, or have a component fall into Error; all that follows is done."""
    facts = world.snapshot()
    component = facts.component(what)
    if component is not None and not component.zombie:
        world.set_state(what, LifeCycleState.ERROR, "ValueError: no (a.py:1)")
    elif any(each.name == what and each.state == "up" for each in facts.processes):
        world.kill(what)
    world.settle()


def shown(facts: Snapshot) -> tuple[object, ...]:
    """Return what is to be the same again: all but pids, and what was done about ends."""
    components = {c.instance: replace(c, restart_status=RestartStatus()) for c in facts.components}
    return components, {wire.connector_id: wire for wire in facts.connectors}


@given(profiles(), ends)
@few
def test_after_restarts_there_is_nothing_to_plan(profile, ended):
    world = always_restarting()
    system = brought_up(world, profile)
    goal = DeploymentGoal(system, ACTIVE)
    assert not goal.plan(world.snapshot()).moves
    for each in ended:
        end(world, each)
        assert not goal.plan(world.snapshot()).moves


@given(profiles(), disturbances(), ends)
@few
def test_what_users_changed_is_there_again(profile, changes, ended):
    world = always_restarting()
    brought_up(world, profile)
    for each in changes:
        if not isinstance(each, str) and _is_possible(world, each):
            world.perform(each)
    world.settle()
    before = shown(world.snapshot())
    for each in ended:
        end(world, each)
        assert shown(world.snapshot()) == before


@given(profiles())
@few
def test_after_a_loss_of_power_there_is_nothing_to_plan(profile):
    world = always_restarting()
    system = brought_up(world, profile)
    world.settle()
    world.lose_power()
    assert not DeploymentGoal(system, ACTIVE).plan(world.snapshot()).moves


@given(
    profiles(stand_ins=False), st.lists(st.tuples(st.integers(0, 30), st.booleans()), max_size=3)
)
@few
def test_managers_killed_while_they_restore_leave_nothing_out(profile, kills):
    """Each is killed after some steps, some with all slaves; those that live are repaired."""
    world = always_restarting()
    system = brought_up(world, profile)
    world.settle()
    before = shown(world.snapshot())
    for steps, is_all_lost in kills:
        if is_all_lost:
            world.end_slaves()
        world.begin_anew()
        world.serve(steps)
    world.begin_anew()
    world.settle()
    assert shown(world.snapshot()) == before
    assert not DeploymentGoal(system, ACTIVE).plan(world.snapshot()).moves


@given(profiles(stand_ins=False), disturbances(), st.booleans())
@few
def test_what_was_done_and_not_recorded_holds_or_does_not(profile, changes, is_killed_twice):
    """The manager is killed in the commit: what is shown then is there after a loss of power."""
    world = always_restarting()
    brought_up(world, profile)
    world.settle()
    for each in changes:
        if not isinstance(each, str) and _is_possible(world, each):
            world.perform_unrecorded(each)
            world.begin_anew()
            if is_killed_twice:
                world.serve(2)
                world.begin_anew()
            world.settle()
            found = shown(world.snapshot())
            world.lose_power()
            assert shown(world.snapshot()) == found


def _is_possible(world: FakeManager, action: act.Action) -> bool:
    return not isinstance(action, act.Delete) or action.instance in world.shell.state.components
