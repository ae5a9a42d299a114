"""The public instances, large ones, and what is told where there is no plan."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from deployments import large, model_from
from reference_model import plan_of, problem_of

from rtkit.deployment.planning.deployment_plan import make_plan
from rtkit.deployment.planning.explain import NoPlan
from rtkit.deployment.planning.operators import judge
from rtkit.planner import verify

FILE = json.loads(Path(__file__).with_name("instances.json").read_text())
INSTANCES = {
    name: model_from(plain, FILE["default_costs"]) for name, plain in FILE["instances"].items()
}


@pytest.mark.parametrize("name", INSTANCES)
def test_the_plan_of_an_instance_costs_what_it_must(name):
    model = INSTANCES[name]
    reference = FILE["instances"][name]["reference"]
    found = make_plan(model)
    assert (found.cost, found.gap) == (reference["optimum"], 0)
    assert len(found.moves) == len(reference["one_plan"])
    assert {move.text for move in found.moves} == set(reference["one_plan"])
    problem = problem_of(model)
    assert verify(problem, plan_of(problem, found.moves)) == ""


def test_steps_of_one_layer_need_nothing_of_each_other():
    found = make_plan(INSTANCES["bring-up"])
    told = [[found.moves[n].text for n in layer] for layer in found.layers]
    assert told[0] == ["start manager m1"]
    assert told[-1] == ["activate sim0", "activate las0", "activate nav0"]
    connected = [text for text in told[-2] if text.startswith("connect")]
    assert connected == ["connect scan", "connect dist", "connect cmd"]


def test_components_are_activated_by_their_ranks_and_rest_the_other_way_round():
    ranks = {"nav0": 0, "sim0": 1, "las0": 1}
    found = make_plan(INSTANCES["bring-up"], ranks)
    told = [[found.moves[n].text for n in layer] for layer in found.layers]
    assert told[-2:] == [["activate nav0"], ["activate sim0", "activate las0"]]
    model = INSTANCES["nothing-to-do"]
    rest = replace(model, desired={f"act:{name}": "inactive" for name in model.units})
    resting = [move.text for move in make_plan(rest, ranks).moves]
    assert resting[-1] == "deactivate nav0"
    assert len(make_plan(rest, ranks).layers) == 2


def test_what_is_kept_is_counted():
    assert make_plan(INSTANCES["switch-variant-live"]).kept == (1, 3, 3)
    model = INSTANCES["nothing-to-do"]
    moved = make_plan(replace(model, desired={"cmp:las0": "m1:slave", "con:scan": "yes"}))
    assert moved.kept == (1, 2, 1)
    assert [move.text for move in moved.moves] == [
        "deactivate las0",
        "disconnect scan",
        "disconnect dist",
        "delete las0",
        "create las0 on m1 in a slave",
        "connect scan",
    ]


def test_a_dear_interruption_is_avoided_where_that_is_possible():
    model = INSTANCES["switch-variant-live"]
    either = replace(model, desired={"cfg:nav0.goal_margin": "0.5", "act:nav0": "active"})
    dear = replace(either, costs={**model.costs, "deactivate nav0": 1000})
    assert [move.text for move in make_plan(dear).moves] == ["set nav0.goal_margin=0.5"]
    needed = replace(model, costs={**model.costs, "deactivate nav0": 1000})
    assert make_plan(needed).cost == 1002


def test_many_defaults_are_had_by_making_anew_when_that_is_cheaper():
    model = large(1, 0)
    keys = {f"c0.k{n}": model.keys["c0.gain"] for n in range(10)}
    live = {
        "mgr:m1": "up",
        "mod:m1/T0": "loaded",
        "cmp:c0": "m1:inproc",
        **{f"cfg:{key}": "9" for key in keys},
    }
    wished = {"cmp:c0": "m1:inproc", **{f"cfg:{key}": "0" for key in keys}}
    found = make_plan(replace(model, keys=keys, live=live, desired=wished))
    assert [move.text for move in found.moves] == ["delete c0", "create c0 on m1"]


@pytest.mark.parametrize("is_free", [False, True])
@pytest.mark.parametrize(("components", "connections"), [(50, 100), (200, 400), (1000, 2000)])
def test_large_deployments_are_planned_and_proved_cheapest(components, connections, is_free):
    model = large(components, connections, is_free=is_free)
    found = make_plan(model)
    assert found.gap == 0
    assert len(found.layers) == 5
    assert judge(model, found.moves) == ""
    modules = 20
    sets = sum(number % 3 != 0 for number in range(components))
    assert found.cost == 8 + 4 * modules + (3 + 1) * components + connections + sets


@pytest.mark.parametrize(
    ("changes", "wishes", "reason"),
    [
        (
            {"cmp:nav0": "absent", "con:dist": "yes"},
            {"cmp:nav0=absent", "con:dist=yes"},
            "",
        ),
        ({"cmp:nav0": "m1:slave"}, {"cmp:nav0=m1:slave"}, "nav0 can only be at m1:inproc"),
        ({"cmp:nav0": "absent", "act:nav0": "active"}, {"act:nav0=active", "cmp:nav0=absent"}, ""),
        ({"mod:m1/Nothing": "loaded"}, {"mod:m1/Nothing=loaded"}, "m1 does not find"),
        (
            {"mod:m1/BugNavigator": "absent", "cmp:nav0": "*"},
            {"mod:m1/BugNavigator=absent", "cmp:nav0=*"},
            "",
        ),
    ],
)
def test_what_is_impossible_is_explained(changes, wishes, reason):
    model = INSTANCES["bring-up"]
    others = {"cmp:sim0": "m1:inproc", "act:sim0": "active"}
    with pytest.raises(NoPlan) as caught:
        make_plan(replace(model, desired={**others, **changes}))
    assert set(caught.value.wishes) == wishes
    assert reason in str(caught.value)
    assert str(caught.value).startswith("impossible: ")


def test_a_missing_module_is_named():
    model = replace(INSTANCES["bring-up"], managers={"m1": frozenset(["WorldSim"])})
    with pytest.raises(NoPlan, match="m1 does not find module") as caught:
        make_plan(model)
    assert len(caught.value.wishes) == 1


def test_a_judge_finds_a_step_that_cannot_be_done():
    model = INSTANCES["bring-up"]
    moves = make_plan(model).moves
    assert "step 1 (load WorldSim on m1): does not hold: mgr:m1 is up" in judge(model, moves[1:])
    assert "desired does not hold at the end: act:nav0=inactive" in judge(model, moves[:-1])
