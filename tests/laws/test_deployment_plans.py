"""A plan reaches its goal from wherever the world is, and a failed one leaves no trace."""

from __future__ import annotations

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree
from hypothesis import given, settings
from hypothesis import strategies as st
from systems import ACTIVE, INACTIVE, by_key, disturb, disturbances, make_world, profiles

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.capture import SystemHeading, capture
from rtkit.deployment.creation import creation_plan
from rtkit.deployment.deviations import deviations
from rtkit.deployment.layered_plan import merged
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.runner import PlanRunner
from rtkit.deployment.running import start_plan, stop_plan, teardown_plan
from rtkit.deployment.system import WantedSystem
from rtkit.deployment.wanted import wanted
from rtkit.deployment.wiring import wiring_plan
from rtkit.errors import Refused
from rtkit.profile import rts_model as rts
from rtkit.rtc.enums import ReturnCode
from rtkit.tree.resurrect import resurrect

few = settings(max_examples=40, deadline=None)


def bring_up(world: FakeManager, profile: rts.RtsProfile) -> tuple[WantedSystem, list[str]]:
    """Bring the system up through the real client, all checks included; return what it told."""
    tree = fake_tree(world)
    before = tree.snapshot()
    system = wanted(profile, world.host)
    told: list[str] = []
    resurrect(tree, system, before, PlanRunner(tree, told.append))
    return system, told


def reach(world: FakeManager, profile: rts.RtsProfile) -> WantedSystem:
    """Bring the system up; only sets and parameters that a type does not have may be missing."""
    system, told = bring_up(world, profile)
    assert all("No such configuration" in line for line in told), told
    return system


def rest(world: FakeManager, system: WantedSystem) -> list[str]:
    """Return what a further plan would still do."""
    live = LiveIndex(world.snapshot(), system)
    steps = (*creation_plan(system, live).steps, *wiring_plan(system, live).steps)
    return [step.text for step in steps if step.action is not None]


@given(profiles())
@few
def test_from_nothing_the_goal_is_reached_and_a_second_plan_is_empty(profile):
    world = make_world()
    system = reach(world, profile)
    assert rest(world, system) == []
    live = LiveIndex(world.snapshot(), system)
    assert not [d for d in deviations(system, live, INACTIVE) if d.kind != "parameter"]


@given(profiles(), disturbances())
@few
def test_the_goal_is_reached_again_after_any_disturbance(profile, disturbances):
    world = make_world()
    system = reach(world, profile)
    disturb(world, disturbances)
    reach(world, profile)
    assert rest(world, system) == []


@given(profiles())
@few
def test_start_check_stop_teardown(profile):
    world = make_world()
    system = reach(world, profile)

    def run(plan_for):
        plan = plan_for(system, LiveIndex(world.snapshot(), system))
        assert not any(step.blocked for step in plan.steps)
        assert all(world.perform(action).ok for action, _ in merged(plan.steps))

    run(start_plan)
    assert all(c.state == "Active" for c in world.components.values())
    run(stop_plan)
    assert all(c.state == "Inactive" for c in world.components.values())
    run(lambda system, live: teardown_plan(system, live, ends_components=True))
    assert world.snapshot() == make_world().snapshot()


@given(profiles(), disturbances(), st.integers(0, 12), st.booleans())
@few
def test_a_failed_or_interrupted_run_leaves_no_trace(profile, disturbances, when, interrupts):
    world = make_world()
    reach(world, profile)
    disturb(world, [d for d in disturbances if not isinstance(d, str)])
    before = world.snapshot()
    count = 0

    def fault(_action: act.Action) -> Result | None:
        nonlocal count
        count += 1
        if count - 1 != when:
            return None
        if interrupts:
            raise KeyboardInterrupt
        return Result(ReturnCode.ERROR, "refused", "no luck")

    world.fault = fault
    try:
        _, told = bring_up(world, profile)
    except (Refused, KeyboardInterrupt):
        assert by_key(world.snapshot()) == by_key(before)
        return
    assert count <= when or any(line.endswith(": no luck") for line in told)


@given(profiles())
@few
def test_saved_and_brought_up_again_is_the_same(profile):
    world, again = make_world(), make_world()
    reach(world, profile)
    heading = SystemHeading("2025-01-01T00:00:00")
    saved = capture(world.snapshot(), heading, takes_all=True)
    reach(again, saved)
    assert capture(again.snapshot(), heading, takes_all=True) == saved
    by_name = [{c.instance: c for c in w.snapshot().components} for w in (world, again)]
    assert by_name[0].keys() == by_name[1].keys()


@pytest.mark.parametrize("state", [INACTIVE, ACTIVE])
@given(profiles(), disturbances())
@few
def test_a_check_finds_just_what_a_plan_would_change(state, profile, disturbances):
    world = make_world()
    system = reach(world, profile)
    disturb(world, disturbances)
    live = LiveIndex(world.snapshot(), system)
    kinds = {d.kind for d in deviations(system, live, state)} - {"state"}
    changes = {
        step.text.split()[0] + step.text.split()[1]
        for step in (*creation_plan(system, live).steps, *wiring_plan(system, live).steps)
        if step.action is not None or step.blocked
    }
    assert ("component" in kinds) == ("Createcomponent" in changes)
    assert ("connection" in kinds) == any(text.startswith("Connect") for text in changes)
