"""Every kind of drift in a simulated world: a check finds it, a plan reaches it, and then holds."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree
from hypothesis import given, settings
from hypothesis import strategies as st
from systems import INSTANCES, PORTS, SETS, disturb, disturbances, make_world, profiles

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.applying import Applier
from rtkit.deployment.deviations import deviations, surplus
from rtkit.deployment.extension import policy_in
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.wanted import wanted
from rtkit.errors import RtkitError
from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty
from rtkit.rtc.enums import LifeCycleState, ReturnCode
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import ConnectorProfile, PortRef, TypeProfile

few = settings(max_examples=20, deadline=None)
DATE = "2025-01-01T00:00:00"
OTHER = ComponentPattern(TypeProfile("Other"), PORTS, SETS)
Drift = tuple[act.Action | str, ...]


def made_otherwise(create: str) -> st.SearchStrategy[Drift]:
    """Return what ends a component of the profile, and has another one live in its place."""
    return st.sampled_from(INSTANCES).map(
        lambda name: (act.Delete(name), act.Create(f"{create}&instance_name={name}"))
    )


WIRES = st.tuples(st.sampled_from(INSTANCES), st.sampled_from(["Extra0", *INSTANCES])).map(
    lambda ends: (
        act.Connect(ConnectorProfile("x", "x", (PortRef(ends[0], "out"), PortRef(ends[1], "in")))),
    )
)
SURPLUS = st.one_of(st.just((act.Create("Node?instance_name=Extra0"),)), WIRES)
DRIFTS = st.lists(
    st.one_of(
        disturbances(supervised=True).map(tuple),
        made_otherwise("Node?x=z"),
        made_otherwise("Other?x=y"),
        SURPLUS,
    ),
    max_size=5,
)


def new_world() -> FakeManager:
    world = make_world()
    world.types["Other"] = OTHER
    return world


def one_component() -> rts.RtsProfile:
    made = rts.ComponentInstance(
        "RTC:::Node:",
        "localhost/A.rtc",
        "A",
        execution_contexts=(rts.OwnedContext("0", "PERIODIC", 10.0),),
        properties=(
            ExtensionProperty("rtkit.create", "Node"),
            ExtensionProperty("rtkit.restart", "always"),
        ),
    )
    return rts.RtsProfile("RTSystem:a:b:1", "0.2", DATE, DATE, components=(made,))


def goal_of(world: FakeManager, profile: rts.RtsProfile) -> DeploymentGoal:
    return DeploymentGoal(wanted(profile, world.host), replaces=True, prunes=True)


def reach(world: FakeManager, goal: DeploymentGoal, *, rolls_back: bool = False) -> None:
    tree = fake_tree(world)
    before = tree.snapshot()
    applier = Applier(tree, goal, lambda _: None, lambda _: None)
    applier.run(goal.plan(before), before, rolls_back=rolls_back)


def attempt(world: FakeManager, goal: DeploymentGoal, *, rolls_back: bool = False) -> str:
    """Return what is told when the goal is not reached; empty when it is."""
    try:
        reach(world, goal, rolls_back=rolls_back)
    except RtkitError as error:
        return str(error)
    return ""


def found(world: FakeManager, goal: DeploymentGoal) -> list[str]:
    """Return what a check finds, and what there is besides that a prune removes."""
    live = LiveIndex(world.snapshot(), goal.system)
    besides = (s for s in surplus(goal.system, live) if s.kind in ("component", "connection"))
    differing = deviations(goal.system, live, LifeCycleState.ACTIVE)
    return [each.text for each in (*differing, *besides)]


def drift(world: FakeManager, drifts: list[Drift]) -> None:
    for each in drifts:
        disturb(world, list(each))


@given(profiles(stand_ins=False, supervised=True), DRIFTS)
@few
def test_every_drift_is_found_and_reached_and_then_there_is_nothing_to_do(profile, drifts):
    world = new_world()
    goal = goal_of(world, profile)
    reach(world, goal)
    assert found(world, goal) == []
    drift(world, drifts)
    assert bool(goal.plan(world.snapshot()).moves) is bool(found(world, goal))
    reach(world, goal)
    assert found(world, goal) == []
    performed = len(world.performed)
    reach(world, goal)
    assert len(world.performed) == performed


@given(profiles(stand_ins=False, supervised=True), DRIFTS)
@few
def test_without_leave_nothing_is_made_again_and_nothing_ended(profile, drifts):
    world = new_world()
    goal = goal_of(world, profile)
    reach(world, goal)
    drift(world, drifts)
    wires = set(world.connectors)
    world.performed.clear()
    why = attempt(world, replace(goal, replaces=False, prunes=False))
    if why:
        assert "--replace makes it again" in why
        assert not world.performed
    assert not any(isinstance(action, act.Delete) for action in world.performed)
    assert wires <= set(world.connectors)


@given(profiles(stand_ins=False, supervised=True), DRIFTS, st.integers(0, 14))
@few
def test_after_a_failure_the_way_back_leads_to_the_drift_that_was(profile, drifts, when):
    world = new_world()
    goal = goal_of(world, profile)
    reach(world, goal)
    drift(world, drifts)
    before = essence(world)
    count = 0

    def fault(_action: act.Action) -> Result | None:
        nonlocal count
        count += 1
        return Result(ReturnCode.ERROR, "refused", "no luck") if count - 1 == when else None

    world.fault = fault
    why = attempt(world, goal, rolls_back=True)
    assert not why or "no luck" in why
    if why.endswith("everything is as it was before"):
        assert essence(world) == before


def essence(world: FakeManager) -> dict[str, object]:
    """Return what a way back restores of each component that lives, and the connections."""
    parts: dict[str, object] = {
        name: (
            facts.type,
            facts.process,
            facts.sets,
            facts.active_set,
            facts.state,
            [context.rate for context in facts.contexts],
            policy_in(facts.create),
        )
        for name, facts in world.components.items()
        if not facts.zombie
    }
    return {**parts, "wires": dict(world.connectors)}


@pytest.mark.parametrize("way", ["rate", "policy", "name"])
def test_what_can_change_while_it_lives_interrupts_nobody(way):
    changes = {
        "rate": act.SetRate("A", "0", 7.0),
        "policy": act.SetPolicy("A", {"rtkit.restart": "on-failure"}),
        "name": act.Unregister("localhost/A.rtc"),
    }
    world = new_world()
    goal = goal_of(world, one_component())
    reach(world, goal)
    assert world.perform(changes[way]).ok
    assert found(world, goal)
    world.performed.clear()
    reach(world, goal)
    kinds = {"rate": act.SetRate, "policy": act.SetPolicy, "name": act.Register}
    assert [type(each) for each in world.performed] == [kinds[way]]
