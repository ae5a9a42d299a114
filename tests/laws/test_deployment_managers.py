"""A system in several managers is brought up, repaired, taken back as one in a single manager."""

from __future__ import annotations

from dataclasses import replace

from fake_manager import meet
from fake_tree import fake_tree
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from systems import ACTIVE, INACTIVE, INSTANCES, disturb, disturbances, make_world, profiles

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.applying import Applier
from rtkit.deployment.capture import SystemHeading, capture
from rtkit.deployment.deviations import deviations
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.moving import MoveRecord, before, ends_elsewhere, move_goal, record_of
from rtkit.deployment.multi_manager import homes_in
from rtkit.deployment.planning.operators import judge
from rtkit.deployment.runner import PlanRunner
from rtkit.deployment.running import start_plan, stop_plan, teardown_plan
from rtkit.deployment.wanted import wanted
from rtkit.errors import RtkitError, Unreachable
from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty
from rtkit.rtc.enums import ReturnCode
from rtkit.rtc.serde import decode_text, encode_text
from rtkit.tree.manager_set import ManagerSet
from rtkit.tree.resurrect import resurrect
from rtkit.tree.start import Starter

few = settings(max_examples=20, deadline=None)
NAMES = ("manager", "m1", "m2")


@st.composite
def spread(draw):
    """Return a profile whose components are in several managers, and who is in which."""
    profile = draw(profiles())
    homes = {c.instance_name: draw(st.sampled_from(NAMES)) for c in profile.components}
    return placed(profile, homes), homes


def placed(profile, homes):
    """Return a profile with each component at home."""

    def path(component):
        host, rest = component.path_uri.split("/", 1)
        home = homes[component.instance_name]
        return component.path_uri if home == NAMES[0] else f"{host}/{home}.mgr/{rest}"

    return replace(
        profile,
        components=tuple(replace(c, path_uri=path(c)) for c in profile.components),
    )


class Managers:
    """Simulated managers, and a fleet of connections to them."""

    def __init__(self, homes):
        self.homes = homes
        self.worlds = {name: make_world(name) for name in NAMES}
        meet(self.worlds)

    def fleet(self):
        trees = {name: fake_tree(world) for name, world in self.worlds.items()}
        return ManagerSet(NAMES, trees, self.homes)

    def snapshot(self):
        return self.fleet().snapshot()

    def goal(self, profile, state=ACTIVE, ranks=None):
        stand_ins = {c.instance for c in self.snapshot().components if c.is_stand_in}
        system = wanted(profile, "box", stand_ins=stand_ins, managers=NAMES[1:])
        return DeploymentGoal(system, state, ranks=ranks or {})

    def reach(self, goal, *, rolls_back=False):
        fleet = self.fleet()
        before = fleet.snapshot()
        plan = goal.plan(before)
        assert judge(plan.model, plan.moves) == ""
        Applier(fleet, goal, silent, silent).run(plan, before, rolls_back=rolls_back)
        return plan

    def check(self, goal):
        """All is as wanted, where it is wanted, and there is nothing left to do."""
        now = self.snapshot()
        live = LiveIndex(now, goal.system)
        found = deviations(goal.system, live, goal.state)
        assert [d.text for d in found if d.kind not in ("parameter", "active-set")] == []
        assert homes_in(now).items() >= self.homes.items()
        assert not goal.plan(now).moves

    def disturb(self, disturbances):
        for number, each in enumerate(disturbances):
            disturb(self.worlds[NAMES[number % len(NAMES)]], [each])


def plain_profile(homes):
    """Return four components without connections."""
    made = tuple(
        rts.ComponentInstance(
            "RTC:::Node:",
            f"localhost/{name}.rtc",
            name,
            execution_contexts=(rts.OwnedContext("0", "PERIODIC", 10.0),),
            properties=(ExtensionProperty("rtkit.create", "Node"),),
        )
        for name in homes
    )
    date = "2025-01-01T00:00:00"
    return placed(rts.RtsProfile("RTSystem:a:b:1", "0.2", date, date, components=made), homes)


def attempt(work):
    """Return what is told when something fails; empty when it does not."""
    try:
        work()
    except RtkitError as error:
        return str(error)
    return ""


def silent(*_):
    """Hear nothing."""


@given(spread(), disturbances(), st.sampled_from([ACTIVE, INACTIVE]))
@few
def test_the_goal_is_reached_from_anywhere_and_a_second_plan_is_empty(drawn, disturbances, state):
    profile, homes = drawn
    managers = Managers(homes)
    managers.reach(managers.goal(profile, state))
    managers.disturb(disturbances)
    goal = managers.goal(profile, state)
    managers.reach(goal)
    managers.check(goal)
    for name, world in managers.worlds.items():
        assert {c for c in world.components if c in homes} == {c for c in homes if homes[c] == name}


@given(spread())
@few
def test_what_is_saved_of_it_is_wanted_again_as_it_is(drawn):
    profile, homes = drawn
    managers = Managers(homes)
    managers.reach(managers.goal(profile))
    saved = capture(managers.snapshot(), SystemHeading("2025-01-01T00:00:00"), takes_all=True)
    goal = managers.goal(saved)
    assert {c.instance: c.manager or NAMES[0] for c in goal.system.components} == homes
    managers.check(goal)
    elsewhere = Managers(homes)
    elsewhere.reach(elsewhere.goal(saved))
    elsewhere.check(elsewhere.goal(profile))


@given(spread())
@few
def test_it_costs_as_much_as_in_one_manager(drawn):
    profile, homes = drawn
    together = Managers(dict.fromkeys(homes, NAMES[0]))
    whole = placed(profile, together.homes)
    whole = replace(
        whole,
        components=tuple(
            replace(c, path_uri=f"localhost/{c.instance_name}.rtc") for c in whole.components
        ),
    )
    several = Managers(homes)
    one = together.goal(whole).plan(together.snapshot())
    other = several.goal(profile).plan(several.snapshot())
    assert (one.cost, other.cost, other.gap) == (one.cost, one.cost, 0)


@given(spread(), disturbances(), st.integers(0, 14), st.booleans())
@few
def test_what_fails_in_one_manager_is_taken_back_in_all(drawn, disturbances, when, comes_up):
    profile, homes = drawn
    managers = Managers(homes)
    if comes_up:
        managers.reach(managers.goal(profile))
        managers.disturb(disturbances)
    count = 0

    def fault(_action):
        nonlocal count
        count += 1
        return Result(ReturnCode.ERROR, "refused", "no luck") if count - 1 == when else None

    for world in managers.worlds.values():
        world.fault = fault
    goal = managers.goal(profile)
    why = attempt(lambda: managers.reach(goal, rolls_back=True))
    assert not why or "everything is as it was before" in why
    if why and not comes_up:
        # A zombie cannot be brought back; what never was is gone again.
        assert not any(world.components for world in managers.worlds.values())
    for world in managers.worlds.values():
        world.fault = lambda _: None
    goal = managers.goal(profile)
    managers.reach(goal)
    managers.check(goal)


@given(
    spread(),
    disturbances(),
    st.sampled_from(NAMES[1:]),
    st.integers(0, 6),
    st.booleans(),
    st.booleans(),
)
@settings(max_examples=40, deadline=None)
def test_a_manager_that_ends_stops_it_and_run_again_it_finishes(
    drawn, disturbances, name, when, comes_up, rolls_back
):
    profile, homes = drawn
    managers = Managers(homes)
    if comes_up:
        managers.reach(managers.goal(profile))
        managers.disturb(disturbances)
    world = managers.worlds[name]
    count = 0

    def end(_action):
        nonlocal count
        count += 1
        if count > when:
            if not world.gone:
                world.go(f"manager {name!r} ended before it answered")
            raise Unreachable(world.gone)

    world.fault = end
    fleet = managers.fleet()
    before = fleet.snapshot()
    fleet.trees[name].has_ended = lambda: bool(world.gone)
    goal = managers.goal(profile)
    told = []
    applier = Applier(fleet, goal, told.append, silent)
    why = attempt(lambda: applier.run(goal.plan(before), before, rolls_back=rolls_back))
    assert not why or f"manager {name!r} ended" in why
    if why and rolls_back:
        assert f"but for what was in manager {name}" in why
        others = [w for n, w in managers.worlds.items() if n != name]
        assert comes_up or not any(w.components for w in others)
    elif why:
        assert "run it again to go on" in why
        assert any(f"start manager {name}" in line for line in told)
    world.fault = lambda _: None
    if world.gone:
        world.come_back()
    goal = managers.goal(profile)
    managers.reach(goal)
    managers.check(goal)


@given(spread())
@few
def test_the_commands_of_one_purpose_lead_where_plans_lead(drawn):
    profile, homes = drawn
    by_plan, by_commands = Managers(homes), Managers(homes)
    goal = by_plan.goal(profile)
    by_plan.reach(goal)
    fleet = by_commands.fleet()
    resurrect(fleet, goal.system, fleet.snapshot(), PlanRunner(fleet, silent))
    Starter(
        fleet, start_plan(goal.system, LiveIndex(fleet.snapshot(), goal.system)), silent, silent
    ).run()
    by_commands.check(goal)
    Starter(
        fleet, stop_plan(goal.system, LiveIndex(fleet.snapshot(), goal.system)), silent, silent
    ).run()
    by_commands.check(by_commands.goal(profile, INACTIVE))
    live = LiveIndex(fleet.snapshot(), goal.system)
    PlanRunner(fleet, silent).run(teardown_plan(goal.system, live, ends_components=True))
    assert not any(world.components for world in by_commands.worlds.values())


@given(st.permutations(INSTANCES), st.lists(st.sampled_from(NAMES), min_size=4, max_size=4))
@few
def test_activations_keep_their_order_across_managers(order, where):
    homes = dict(zip(INSTANCES, where, strict=True))
    managers = Managers(homes)
    log: list[act.Action] = []
    for world in managers.worlds.values():
        world.fault = lambda action: log.append(action)
    managers.reach(managers.goal(plain_profile(homes), ranks={n: r for r, n in enumerate(order)}))
    assert [a.instance for a in log if isinstance(a, act.ChangeState)] == list(order)


# moves

PLACES = st.tuples(st.sampled_from(NAMES), st.sampled_from(["", "s", "arm"]))
HEADING = SystemHeading("2025-01-01T00:00:00")


def begun(managers, instance, place):
    """Return the record of a move, as it is read again from its file."""
    source = homes_in(managers.snapshot())[instance]
    homes = ends_elsewhere(managers.fleet().at(source).snapshot(), instance)
    record = record_of(managers.snapshot(), instance, source, place, homes)
    return decode_text(MoveRecord, encode_text(record))


def carry_out(managers, record):
    """Move by what lives now."""
    fleet = managers.fleet()
    fleet.homes = dict(record.homes)
    now, goal = fleet.snapshot(), move_goal(record)
    was = before(now, record)
    plan = goal.plan(now, was)
    assert judge(plan.model, plan.moves) == ""
    Applier(fleet, goal, silent, silent).run(plan, was, rolls_back=True)


def described(managers, moved=""):
    """Return all that is saved of what lives; of who has moved all but the place."""
    whole = ManagerSet(NAMES, managers.fleet().trees, {}).snapshot()
    profile = capture(whole, HEADING, takes_all=True)

    def placeless(component):
        kept = [p for p in component.properties if p.name != "rtkit.create"]
        return replace(component, path_uri="", properties=tuple(kept))

    def anywhere(connector):
        ends = (
            replace(end, properties=()) if end.instance_name == moved else end
            for end in (connector.source, connector.target)
        )
        return replace(connector, source=next(ends), target=next(ends))

    components = [placeless(c) if c.instance_name == moved else c for c in profile.components]
    states = {c.instance: c.state for c in whole.components}
    return (
        components,
        sorted(map(anywhere, profile.data_port_connectors), key=lambda c: c.connector_id),
        sorted(map(anywhere, profile.service_port_connectors), key=lambda c: c.connector_id),
        states,
    )


def bearers(managers, instance):
    return [name for name, world in managers.worlds.items() if instance in world.components]


def system(data, drawn):
    profile, homes = drawn
    managers = Managers(homes)
    managers.reach(managers.goal(profile, data.draw(st.sampled_from([ACTIVE, INACTIVE]))))
    instance = data.draw(st.sampled_from(sorted(homes)))
    place = data.draw(PLACES)
    found = []
    why = attempt(lambda: found.append(begun(managers, instance, place)))
    assert found or "cannot be moved" in why
    assume(found)
    return managers, instance, place, found[0]


@given(st.data(), spread())
@few
def test_it_is_there_what_it_was_here_and_a_second_move_does_nothing(data, drawn):
    managers, instance, (manager, slave), record = system(data, drawn)
    was = described(managers, instance)
    carry_out(managers, record)
    assert described(managers, instance) == was
    assert bearers(managers, instance) == [manager]
    assert managers.snapshot().component(instance).process == (slave or manager)
    again = begun(managers, instance, (manager, slave))
    now = managers.snapshot()
    assert not move_goal(again).plan(now, before(now, again)).moves


@given(st.data(), spread(), st.integers(0, 12))
@few
def test_killed_anywhere_it_goes_on_by_its_record(data, drawn, when):
    managers, instance, (manager, _), record = system(data, drawn)
    was = described(managers, instance)
    count = 0

    def killed(_action):
        nonlocal count
        count += 1
        assert len(bearers(managers, instance)) <= 1
        if count > when:
            raise Unreachable("killed")

    for world in managers.worlds.values():
        world.fault = killed
    attempt(lambda: carry_out(managers, record))
    for world in managers.worlds.values():
        world.fault = lambda _: None
    carry_out(managers, record)
    assert described(managers, instance) == was
    assert bearers(managers, instance) == [manager]


@given(st.data(), spread(), st.integers(0, 12))
@few
def test_what_fails_leaves_it_as_and_where_it_was(data, drawn, when):
    managers, instance, _, record = system(data, drawn)
    was, count = described(managers), 0

    def fault(_action):
        nonlocal count
        count += 1
        return Result(ReturnCode.ERROR, "refused", "no luck") if count - 1 == when else None

    for world in managers.worlds.values():
        world.fault = fault
    why = attempt(lambda: carry_out(managers, record))
    for world in managers.worlds.values():
        world.fault = lambda _: None
    if why:
        assert "everything is as it was before" in why
        assert described(managers) == was
        assert bearers(managers, instance) == [record.source.manager]
