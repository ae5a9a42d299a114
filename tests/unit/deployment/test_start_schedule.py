"""Plans of a start and stop as they are shown: lines, warnings, order, graph."""

import shutil
import subprocess

import pytest

from rtkit.deployment import actions as act
from rtkit.deployment.conditions import start_orders, stop_orders
from rtkit.deployment.plan_graph import to_dot
from rtkit.deployment.running import start_plan, stop_plan
from rtkit.rtc.enums import Transition

P = "/localhost/Sink{}.rtc"


def start(make, world, profile):
    return start_plan(*make.live(profile, world), start_orders(profile))


def stop(make, world, profile):
    orders = stop_orders(profile)
    return stop_plan(*make.live(profile, world), orders, started=start_orders(profile))


def shown(plan):
    """Return the lines of the actions alone, without what is the same in all."""
    return [turn.step.line.replace("/localhost/", "") for turn in plan.turns]


def targets(plan):
    return "".join(turn.target.instance[-1] for turn in plan.turns)


@pytest.fixture
def four_kinds(make):
    return make.ordered(
        make.sinks(6, optional="Sink5"),
        make.entry("Sink0", 3, wait=5000),
        make.entry("Sink0", 3, after="Sink1", timeout=2000),
        make.entry("Sink1", 2),
        make.entry("Sink2", 1),
        make.entry("Sink3", 4, after="Sink0", timing="ASYNC"),
        make.entry("Sink5", 4, after="Sink3", timing="SYNC"),
        make.entry("Sink5", 9, wait=10),
    )


def test_lines(make, world, four_kinds):
    in_context = "in execution context 0"
    assert shown(start(make, world, four_kinds)) == [
        f"{{1}} Activate Sink4.rtc {in_context} (Required)",
        f"{{2}} [Order 1] Activate Sink2.rtc {in_context} (Required)",
        f"{{3}} [Order 2] Activate Sink1.rtc {in_context} (Required)",
        f"{{4}} [Order 3/Wait 5000ms, Sync to Sink1.rtc]"
        f" Activate Sink0.rtc {in_context} (Required)",
        f"{{5}} [Order 4/After Sink0.rtc's action] Activate Sink3.rtc {in_context} (Required)",
        f"{{6}} [Order 4/Sync to Sink3.rtc, Order 9/Wait 10ms] Activate Sink5.rtc {in_context}",
    ]


def test_the_plan_without_its_words(make, world, four_kinds):
    world.perform(act.Create("Sink?instance_name=Sink0"))
    plan = start(make, world, four_kinds)
    assert (len(plan.immediate), len(plan.delayed)) == (3, 3)
    assert plan.has_conditions
    assert plan.last_moment_s == 5.0
    assert plan.delayed[0].step.action == act.ChangeState("Sink0", "0", Transition.ACTIVATE)
    assert plan.delayed[1].step.blocked == f"Component missing: {P.format(3)}"
    assert not start(make, world, make.sinks(2)).has_conditions


def test_an_order_alone_only_sorts(make, world):
    profile = make.ordered(
        make.sinks(4), make.entry("Sink0", 2), make.entry("Sink3", 2), make.entry("Sink2", 1)
    )
    plan = start(make, world, profile)
    assert targets(plan) == "1203"
    assert not plan.delayed


def test_who_depends_on_something_optional_is_warned(make, world):
    profile = make.ordered(
        make.sinks(4, optional="Sink0"),
        make.entry("Sink1", 1, after="Sink0", timing="ASYNC"),
        make.entry("Sink2", 2, after="Sink0 Sink1"),
    )
    assert list(start(make, world, profile).warnings()) == [
        "action {3} depends on the optional action {1}, which may never be done:"
        " After /localhost/Sink0.rtc's action",
        "action {4} depends on the optional action {1}, which may never be done:"
        " Sync to /localhost/Sink0.rtc",
    ]
    assert list(start(make, world, make.sinks(2, optional="Sink0")).warnings()) == []
    assert list(stop(make, world, profile).warnings()) == []


def test_a_stop_is_the_reverse_of_the_start(make, world, four_kinds):
    assert targets(stop(make, world, make.sinks(4))) == "3210"
    assert targets(start(make, world, four_kinds)) == "421035"
    plan = stop(make, world, four_kinds)
    assert targets(plan) == "530124"
    assert not plan.has_conditions
    assert shown(plan)[0] == "{1} Deactivate Sink5.rtc in execution context 0"


def test_the_reverse_is_that_of_what_happens_not_of_the_numbers(make, world):
    profile = make.ordered(
        make.sinks(4),
        make.entry("Sink0", 1, wait=500),
        make.entry("Sink1", 2, after="Sink2"),
        make.entry("Sink2", 3, wait=20),
        make.entry("Sink3", 4, wait=100),
    )
    assert targets(start(make, world, profile)) == "0123"
    assert targets(stop(make, world, profile)) == "0312"


def test_a_stop_has_orders_of_its_own(make, world, four_kinds):
    profile = make.ordered(
        four_kinds, make.entry("Sink4", 1), make.entry("Sink5", 2, after="Sink4"), stop=True
    )
    plan = stop(make, world, profile)
    assert targets(plan) == "321045"
    assert shown(plan)[-1] == (
        "{6} [Order 2/Sync to Sink4.rtc] Deactivate Sink5.rtc in execution context 0"
    )


def test_contexts_are_told_where_there_are_several(make, world):
    two = (("a", "PERIODIC", 10.0), ("b", "PERIODIC", 10.0))
    profile = make.ordered(
        make.profile(make.component("Sink0", contexts=two)),
        make.entry("Sink0", context="a", after="Sink0/b"),
    )
    assert shown(start(make, world, profile)) == [
        "{1} Activate Sink0.rtc in execution context b (Required)",
        "{2} [Order 1/Sync to Sink0.rtc in execution context b]"
        " Activate Sink0.rtc in execution context a (Required)",
    ]


def test_a_graph(make, world, four_kinds):
    lines = [line.strip() for line in to_dot(start(make, world, four_kinds))]
    assert lines[0] == "digraph start {"
    assert lines[-1] == "}"
    assert 'a6 [label="{6} Activate\\n/localhost/Sink5.rtc", style=dashed];' in lines
    assert [line for line in lines if "->" in line] == [
        "begin -> a1;",
        'a1 -> a2 [label="Order 1"];',
        'a2 -> a3 [label="Order 2"];',
        "a3 -> delayed;",
        'delayed -> a4 [label="Order 3/Wait 5000ms"];',
        'a3 -> a4 [label="Order 3/Sync, at most 2000ms"];',
        'a4 -> a5 [label="Order 4/After", style=dashed];',
        'a5 -> a6 [label="Order 4/Sync"];',
        'delayed -> a6 [label="Order 9/Wait 10ms"];',
    ]


def test_a_graph_of_a_stop_and_of_odd_names(make, world):
    odd = make.component("Sink0", uri='localhost/a"\\b.rtc')
    lines = list(to_dot(stop(make, world, make.profile(odd))))
    assert lines[0] == "digraph stop {"
    assert '  a1 [label="{1} Deactivate\\n/localhost/a\\"\\\\b.rtc", style=dashed];' in lines
    assert not any("delayed" in line for line in lines)


@pytest.mark.skipif(shutil.which("dot") is None, reason="graphviz absent")
def test_graphviz_takes_it(make, world, four_kinds):
    text = "\n".join(to_dot(start(make, world, four_kinds)))
    done = subprocess.run(["dot", "-Tplain"], input=text, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_thousands_of_actions(make, world):
    entries = [make.entry(f"Sink{n}", n, after=f"Sink{n - 1}") for n in range(1, 2000)]
    plan = stop(make, world, make.ordered(make.sinks(2000), *entries))
    assert [turn.target.instance for turn in plan.turns[:2]] == ["Sink1999", "Sink1998"]
