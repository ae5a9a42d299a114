"""The commands of one purpose each lead where the planned way leads that has the same goal."""

from __future__ import annotations

from dataclasses import replace

from fake_manager import FakeManager
from fake_tree import fake_tree
from hypothesis import given, settings
from hypothesis import strategies as st
from systems import ACTIVE, INACTIVE, by_key, make_world, profiles

from rtkit.deployment.applying import Applier
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.runner import PlanRunner
from rtkit.deployment.running import start_plan, stop_plan, teardown_plan
from rtkit.deployment.system import WantedSystem
from rtkit.deployment.wanted import wanted
from rtkit.profile import rts_model as rts
from rtkit.tree.resurrect import resurrect
from rtkit.tree.start import Starter

few = settings(max_examples=25, deadline=None)


def plain(world: FakeManager) -> tuple[object, ...]:
    """Return what lives, but for how a create string is written and in which order names came."""
    components, connectors, processes = by_key(world.snapshot())
    return (
        {n: replace(c, create="", names=tuple(sorted(c.names))) for n, c in components.items()},
        connectors,
        processes,
    )


def silent(*_: object) -> None:
    """Hear nothing."""


def applied(world: FakeManager, goal: DeploymentGoal) -> None:
    tree = fake_tree(world)
    before = tree.snapshot()
    Applier(tree, goal, silent, silent).run(goal.plan(before), before)


def resurrected(world: FakeManager, profile: rts.RtsProfile) -> WantedSystem:
    tree = fake_tree(world)
    system = wanted(profile, world.host)
    resurrect(tree, system, tree.snapshot(), PlanRunner(tree, silent))
    return system


def started(world: FakeManager, system: WantedSystem, *, stops: bool = False) -> None:
    plan_for = stop_plan if stops else start_plan
    plan = plan_for(system, LiveIndex(world.snapshot(), system))
    Starter(fake_tree(world), plan, silent, silent).run()


@given(profiles(), st.sampled_from(["up", "started", "stopped", "down"]))
@few
def test_both_ways_lead_to_the_same(profile, how):
    by_commands, by_plan = make_world(), make_world()
    system = resurrected(by_commands, profile)
    applied(by_plan, DeploymentGoal(system, None))
    assert plain(by_commands) == plain(by_plan)
    if how == "up":
        return
    started(by_commands, system)
    applied(by_plan, DeploymentGoal(system, ACTIVE))
    if how == "stopped":
        started(by_commands, system, stops=True)
        applied(by_plan, DeploymentGoal(system, INACTIVE))
    if how == "down":
        plan = teardown_plan(
            system, LiveIndex(by_commands.snapshot(), system), ends_components=True
        )
        PlanRunner(fake_tree(by_commands), silent).run(plan)
        applied(
            by_plan, DeploymentGoal(system, absent=frozenset(c.instance for c in system.components))
        )
    assert plain(by_commands) == plain(by_plan)


@given(profiles())
@few
def test_each_leaves_nothing_to_do_to_the_other(profile):
    world = make_world()
    system = resurrected(world, profile)
    assert not DeploymentGoal(system, None).plan(world.snapshot()).moves
    started(world, system)
    assert not DeploymentGoal(system, ACTIVE).plan(world.snapshot()).moves
    performed = len(world.performed)
    resurrected(world, profile)
    assert len(world.performed) == performed
