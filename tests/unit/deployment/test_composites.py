"""Composites in plans: saved with their members, made after them, driven through their context."""

from __future__ import annotations

from dataclasses import replace

from rtkit.deployment import actions as act
from rtkit.deployment.capture import SystemHeading, capture
from rtkit.deployment.creation import creation_plan
from rtkit.deployment.described import guests_of
from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.live_index import LiveIndex, context_of
from rtkit.deployment.part import part_of
from rtkit.deployment.system import WantedComponent, WantedSystem
from rtkit.rtc.enums import ExecutionKind
from rtkit.rtc.pattern import ContextPattern
from rtkit.rtc.profiles import ConnectorProfile, ExecutionContextProfile, PortRef, TypeProfile

TYPE = "PeriodicECSharedComposite"


def facts(instance, **more):
    made = ComponentFacts(instance, TypeProfile("Step"), "robot", create="Step")
    return replace(made, names=(f"localhost/{instance}.rtc",), **more)


def composite(instance, members, composite=""):
    return facts(
        instance,
        composite_type="PeriodicECShared",
        members=tuple(members),
        composite=composite,
        sets={"default": {"members": ",".join(members), "exported_ports": "A.out"}},
        active_set="default",
    )


def snapshot(*components, wires=()):
    return Snapshot("h", "manager", 1, "1", components=components, connectors=wires)


NESTED = (
    facts("A", composite="Inner"),
    facts("B", composite="Inner"),
    composite("Inner", "AB", "Outer"),
    composite("Outer", ["Inner"]),
    facts("Alone"),
)
WIRE = ConnectorProfile("w", "w", (PortRef("Outer", "A.out"), PortRef("Outer", "A.out")))


def test_what_is_connected_is_saved_with_all_that_it_makes_up():
    made = capture(snapshot(*NESTED, wires=[WIRE]), SystemHeading("2025-01-01T00:00:00"))
    assert [c.instance_name for c in made.components] == ["A", "B", "Inner", "Outer"]
    by_name = {c.instance_name: c for c in made.components}
    assert by_name["A"].composite_type == "None"
    assert by_name["Inner"].composite_type == "PeriodicECShared"
    assert [ref.instance_name for ref in by_name["Inner"].participants] == ["A", "B"]
    assert [ref.instance_name for ref in by_name["Outer"].participants] == ["Inner"]


def test_it_is_made_again_with_the_members_that_it_has_now():
    old = replace(NESTED[2], create=f"{TYPE}?members=X,Y&exported_ports=X.out")
    made = capture(snapshot(*NESTED[:2], old), SystemHeading(""), takes_all=True)
    told = {p.name: p.value for p in made.components[2].properties}
    assert told["rtkit.create"] == (f"{TYPE}?members=A,B&exported_ports=A.out&instance_name=Inner")
    empty = replace(composite("Inner", ""), create=f"{TYPE}?members=X")
    made = capture(snapshot(empty), SystemHeading(""), takes_all=True)
    told = {p.name: p.value for p in made.components[0].properties}
    assert told["rtkit.create"] == f"{TYPE}?exported_ports=A.out&instance_name=Inner"


def wanted(instance, members=""):
    create = f"{TYPE}?members={members}" if members else "Step"
    name = f"localhost/{instance}.rtc"
    create += f"{'&' if members else '?'}instance_name={instance}"
    return WantedComponent("RTC:::Step:", instance, name, f"/{name}", create=create)


def made_in(system):
    plan = creation_plan(system, LiveIndex(snapshot(), system))
    layers = {}
    for number, layer in enumerate(plan.layers):
        for step in layer.steps:
            assert isinstance(step.action, act.Create)
            instance = step.action.create.rpartition("=")[2]
            layers.setdefault((number, layer.name), []).append(instance)
    return layers


def test_composites_are_made_after_their_members_inner_ones_first():
    system = WantedSystem((wanted("Outer", "Inner,C"), wanted("Inner", "A,B"), *map(wanted, "ABC")))
    assert made_in(system) == {
        (0, "create"): ["A", "B", "C"],
        (1, "compose"): ["Inner"],
        (2, "compose"): ["Outer"],
    }


def test_members_that_live_already_or_are_not_told_of_hold_up_nobody():
    system = WantedSystem((wanted("W", "Nobody"), wanted("A")))
    assert made_in(system) == {(0, "create"): ["W", "A"]}


def test_a_circle_comes_to_an_end():
    system = WantedSystem((wanted("V", "W"), wanted("W", "V"), wanted("A")))
    assert made_in(system) == {(0, "create"): ["A"], (1, "compose"): ["V", "W"]}


def context(id, owner, is_running):
    return ExecutionContextProfile(id, ExecutionKind.PERIODIC, 1.0, owner, is_running)


def test_a_member_is_started_in_the_context_that_drives_it():
    own, foreign = context("0", "A", False), context("W/0", "W", True)
    want = replace(wanted("A"), contexts=(ContextPattern(),))
    member = facts("A", composite="W", contexts=(own, foreign))
    assert context_of(member, want, 0) is foreign
    assert context_of(replace(member, composite=""), want, 0) is own
    running = replace(own, is_running=True)
    assert context_of(replace(member, contexts=(running, foreign)), want, 0) is running


def test_what_is_told_of_one_names_its_kin():
    told = part_of(snapshot(*NESTED), ["Inner"])
    assert {c.instance for c in told.components} == {"A", "B", "Inner", "Outer"}


def test_who_is_driven_by_a_context_of_another_is_saved_and_attached_again():
    own = replace(context("0", "Host", True), participants=("Guest",))
    host = facts("Host", contexts=(own,))
    guest = facts("Guest", contexts=(replace(own, id="Host/0"),))
    wire = ConnectorProfile("w", "w", (PortRef("Guest", "out"), PortRef("Guest", "in")))
    made = capture(snapshot(host, guest, facts("Alone"), wires=[wire]), SystemHeading(""))
    assert [c.instance_name for c in made.components] == ["Guest", "Host"]
    saved = made.components[1].execution_contexts[0]
    assert [ref.instance_name for ref in saved.participants] == ["Guest"]
    assert made.components[0].execution_contexts == ()
    assert guests_of(made.components[1]) == (("0", "Guest"),)
    want = WantedSystem((replace(wanted("Host"), guests=(("0", "Guest"),)), wanted("Guest")))
    plan = creation_plan(want, LiveIndex(snapshot(), want))
    assert plan.layers[-1].steps[0].action == act.Attach("Host", "0", "Guest")
    plan = creation_plan(want, LiveIndex(snapshot(host, guest), want))
    assert plan.is_done


def test_whom_a_composite_drives_is_not_said_twice():
    own = replace(context("0", "Inner", True), participants=("A", "B"))
    told = replace(NESTED[2], contexts=(own,))
    made = capture(snapshot(*NESTED[:2], told), SystemHeading(""), takes_all=True)
    assert made.components[2].execution_contexts[0].participants == ()
