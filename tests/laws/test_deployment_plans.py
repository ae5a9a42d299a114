"""A plan reaches its goal from wherever the world is, and a failed one leaves no trace."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.capture import Heading, capture
from rtkit.deployment.check import deviations
from rtkit.deployment.creation import creation_plan
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.live import Live
from rtkit.deployment.plan import merged
from rtkit.deployment.running import start_plan, stop_plan, teardown_plan
from rtkit.deployment.system import System
from rtkit.deployment.wanted import wanted
from rtkit.deployment.wiring import wiring_plan
from rtkit.deployment.world import World
from rtkit.errors import Refused
from rtkit.profile import rts_model as rts
from rtkit.profile.common import Property
from rtkit.rtc.enums import LifeCycleState, PortType, ReturnCode
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import PortProfile, TypeProfile
from rtkit.tree.apply import Runner
from rtkit.tree.fake import fake_tree
from rtkit.tree.resurrect import resurrect

SETS = {"default": {"a": "0", "b": "0"}, "fast": {"a": "1", "b": "1"}}
PORTS = (
    PortProfile("out", PortType.OUT),
    PortProfile("in", PortType.IN),
    PortProfile("in2", PortType.IN),
)
INSTANCES = ("Node0", "Node1", "Node2", "Node3")
INACTIVE, ACTIVE = LifeCycleState.INACTIVE, LifeCycleState.ACTIVE


def make_world() -> World:
    return World([ComponentPattern(TypeProfile("Node"), PORTS, SETS)])


few = settings(max_examples=40, deadline=None)
values = st.sampled_from(["0", "1", "2", "", "x y"])
set_values = st.dictionaries(
    st.sampled_from(["default", "fast"]),
    st.dictionaries(st.sampled_from("ab"), values, max_size=2),
    max_size=2,
)


@st.composite
def components(draw: st.DrawFn, instance: str) -> rts.Component:
    slave = draw(st.sampled_from(["", "&manager_name=s1", "&manager_name=s2"]))
    told = [Property("rtkit.create", f"Node?x=y{slave}")]
    if draw(st.booleans()):
        told.append(Property("rtkit.stand-in", "yes"))
    sets = draw(set_values)
    return rts.Component(
        "RTC:::Node:",
        f"{draw(st.sampled_from(['localhost', 'localhost/dir', 'box']))}/{instance}.rtc",
        instance,
        data_ports=tuple(
            rts.Port(p.name, properties=(Property("port.port_type", p.port_type.value),))
            for p in PORTS
        ),
        active_configuration_set=draw(st.sampled_from([None, "default", "fast"])),
        configuration_sets=tuple(
            rts.ConfigurationSet(
                name, tuple(rts.ConfigurationData(key, value) for key, value in data.items())
            )
            for name, data in sets.items()
        ),
        execution_contexts=(rts.ExecutionContext("0", "PERIODIC", 10.0),),
        properties=tuple(told),
    )


@st.composite
def profiles(draw: st.DrawFn) -> rts.RtsProfile:
    instances = INSTANCES[: draw(st.integers(1, len(INSTANCES)))]
    made = tuple(draw(components(instance)) for instance in instances)
    ends = st.sampled_from(instances)
    wires = draw(
        st.lists(st.tuples(ends, ends, st.sampled_from(["in", "in2"])), max_size=4, unique=True)
    )
    return rts.RtsProfile(
        "RTSystem:a:b:1",
        "0.2",
        "2025-01-01T00:00:00",
        "2025-01-01T00:00:00",
        components=made,
        data_port_connectors=tuple(
            rts.DataPortConnector(
                f"w{number}",
                "wire",
                "IDL:RTC/TimedLong:1.0",
                "corba_cdr",
                "push",
                rts.TargetPort("RTC:::Node:", source, f"{source}.out"),
                rts.TargetPort("RTC:::Node:", sink, f"{sink}.{port}"),
            )
            for number, (source, sink, port) in enumerate(wires)
        ),
    )


@st.composite
def disturbances(draw: st.DrawFn) -> list[act.Action | str]:
    """Return what others did to the world: actions, and slaves that were killed."""
    instance = st.sampled_from(INSTANCES)
    one = st.one_of(
        st.builds(act.Delete, instance),
        st.builds(act.Disconnect, st.sampled_from(["w0", "w1", "w2", "w3"])),
        st.builds(act.ActivateSet, instance, st.sampled_from(["default", "fast"])),
        st.builds(
            act.SetParameters,
            instance,
            st.sampled_from(["default", "fast"]),
            st.dictionaries(st.sampled_from("ab"), values, min_size=1, max_size=2),
        ),
        st.sampled_from(["s1", "s2"]),
    )
    return draw(st.lists(one, max_size=6))


def bring_up(world: World, profile: rts.RtsProfile) -> tuple[System, list[str]]:
    """Bring the system up through the real client, all checks included; return what it told."""
    tree = fake_tree(world)
    before = tree.snapshot()
    system = wanted(profile, world.host)
    told: list[str] = []
    resurrect(tree, system, before, Runner(tree, told.append))
    return system, told


def reach(world: World, profile: rts.RtsProfile) -> System:
    """Bring the system up; only sets and parameters that a type does not have may be missing."""
    system, told = bring_up(world, profile)
    assert all("No such configuration" in line for line in told), told
    return system


def disturb(world: World, disturbances: list[act.Action | str]) -> None:
    for each in disturbances:
        if not isinstance(each, str):
            world.perform(each)
        elif each in world.processes:
            world.kill(each)


def by_key(snapshot: Snapshot) -> tuple[object, ...]:
    """Return facts without the order in which they came to be, and without process ids."""
    return (
        {c.instance: c for c in snapshot.components},
        {wire.connector_id: wire for wire in snapshot.connectors},
        {process.name for process in snapshot.processes},
    )


def rest(world: World, system: System) -> list[str]:
    """Return what a further plan would still do."""
    live = Live(world.snapshot(), system)
    steps = (*creation_plan(system, live).steps, *wiring_plan(system, live).steps)
    return [step.text for step in steps if step.action is not None]


@given(profiles())
@few
def test_from_nothing_the_goal_is_reached_and_a_second_plan_is_empty(profile):
    world = make_world()
    system = reach(world, profile)
    assert rest(world, system) == []
    live = Live(world.snapshot(), system)
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
        plan = plan_for(system, Live(world.snapshot(), system))
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
    heading = Heading("2025-01-01T00:00:00")
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
    live = Live(world.snapshot(), system)
    kinds = {d.kind for d in deviations(system, live, state)} - {"state"}
    changes = {
        step.text.split()[0] + step.text.split()[1]
        for step in (*creation_plan(system, live).steps, *wiring_plan(system, live).steps)
        if step.action is not None or step.blocked
    }
    assert ("component" in kinds) == ("Createcomponent" in changes)
    assert ("connection" in kinds) == any(text.startswith("Connect") for text in changes)
