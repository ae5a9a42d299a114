"""The commands of one purpose each lead where the planned way leads that has the same goal."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st
from systems import ACTIVE, INACTIVE, by_key, make_world, profiles

from rtkit.deployment.applying import Applier
from rtkit.deployment.goal import Goal
from rtkit.deployment.live import Live
from rtkit.deployment.runner import Runner
from rtkit.deployment.running import start_plan, stop_plan, teardown_plan
from rtkit.deployment.system import System
from rtkit.deployment.wanted import wanted
from rtkit.deployment.world import World
from rtkit.profile import rts_model as rts
from rtkit.tree.fake import fake_tree
from rtkit.tree.resurrect import resurrect
from rtkit.tree.start import Starter

few = settings(max_examples=25, deadline=None)


def plain(world: World) -> tuple[object, ...]:
    """Return what lives, but for how a create string is written and in which order names came."""
    components, connectors, processes = by_key(world.snapshot())
    return (
        {n: replace(c, create="", names=tuple(sorted(c.names))) for n, c in components.items()},
        connectors,
        processes,
    )


def silent(*_: object) -> None:
    """Hear nothing."""


def applied(world: World, goal: Goal) -> None:
    tree = fake_tree(world)
    before = tree.snapshot()
    Applier(tree, goal, silent, silent).run(goal.plan(before), before)


def resurrected(world: World, profile: rts.RtsProfile) -> System:
    tree = fake_tree(world)
    system = wanted(profile, world.host)
    resurrect(tree, system, tree.snapshot(), Runner(tree, silent))
    return system


def started(world: World, system: System, *, stops: bool = False) -> None:
    plan_for = stop_plan if stops else start_plan
    plan = plan_for(system, Live(world.snapshot(), system))
    Starter(fake_tree(world), plan, silent, silent).run()


@given(profiles(), st.sampled_from(["up", "started", "stopped", "down"]))
@few
def test_both_ways_lead_to_the_same(profile, how):
    by_commands, by_plan = make_world(), make_world()
    system = resurrected(by_commands, profile)
    applied(by_plan, Goal(system, None))
    assert plain(by_commands) == plain(by_plan)
    if how == "up":
        return
    started(by_commands, system)
    applied(by_plan, Goal(system, ACTIVE))
    if how == "stopped":
        started(by_commands, system, stops=True)
        applied(by_plan, Goal(system, INACTIVE))
    if how == "down":
        plan = teardown_plan(system, Live(by_commands.snapshot(), system), ends_components=True)
        Runner(fake_tree(by_commands), silent).run(plan)
        applied(by_plan, Goal(system, absent=frozenset(c.instance for c in system.components)))
    assert plain(by_commands) == plain(by_plan)


@given(profiles())
@few
def test_each_leaves_nothing_to_do_to_the_other(profile):
    world = make_world()
    system = resurrected(world, profile)
    assert not Goal(system, None).plan(world.snapshot()).moves
    started(world, system)
    assert not Goal(system, ACTIVE).plan(world.snapshot()).moves
    performed = len(world.performed)
    resurrected(world, profile)
    assert len(world.performed) == performed
