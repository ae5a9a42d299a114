"""Plans of random deployments: as cheap as a search of everything finds, and valid in any order."""

from __future__ import annotations

import random

import pytest
from deployments import models
from hypothesis import given, note, settings
from hypothesis import strategies as st
from reference_model import plan_of, problem_of

from rtkit.deployment.planning.deployment_plan import DeploymentPlan, make_plan
from rtkit.deployment.planning.explain import NoPlan
from rtkit.deployment.planning.model import Model
from rtkit.deployment.planning.operators import judge
from rtkit.errors import Impossible, LimitReached
from rtkit.planner import Limits, plan, verify

MOST_STATES = 600


def after(model: Model, found: DeploymentPlan) -> Model:
    """Return the model in which the plan was carried out."""
    live = {variable: model.now(variable) for variable in model.variables()}
    for move in found.moves:
        live.update(move.changes)
    return Model(**{**vars_of(model), "live": live})


def vars_of(model: Model) -> dict[str, object]:
    return {name: getattr(model, name) for name in model.__dataclass_fields__}


@given(models(most=2))
@settings(max_examples=60, deadline=None)
@pytest.mark.timeout(300)
def test_a_plan_is_as_cheap_as_a_search_of_everything_finds(model):
    problem = problem_of(model)
    try:
        found = make_plan(model)
    except NoPlan:
        with pytest.raises((Impossible, LimitReached)):
            plan(problem, limits=Limits(states=MOST_STATES))
        return
    note([move.text for move in found.moves])
    assert found.gap == 0
    assert verify(problem, plan_of(problem, found.moves)) == ""
    assert make_plan(after(model, found)).moves == ()
    try:
        best = plan(problem, limits=Limits(states=MOST_STATES))
    except LimitReached:
        return
    note(best.commands)
    assert found.cost == best.cost


@given(models(), st.randoms(use_true_random=False))
@settings(max_examples=60, deadline=None)
def test_what_may_be_done_at_once_may_be_done_in_any_order(model, chance: random.Random):
    try:
        found = make_plan(model)
    except NoPlan:
        return
    by_layer = [list(layer) for layer in found.layers]
    for layer in by_layer:
        chance.shuffle(layer)
    assert judge(model, [found.moves[n] for layer in by_layer for n in layer]) == ""
    left, done, serial = set(range(len(found.moves))), set(), []
    while left:
        ready = sorted(n for n in left if found.before[n] <= done)
        serial.append(chance.choice(ready))
        done.add(serial[-1])
        left.remove(serial[-1])
    assert judge(model, [found.moves[n] for n in serial]) == ""


@given(models())
@settings(max_examples=60, deadline=None)
def test_a_component_is_activated_after_its_connections_and_parameters(model):
    try:
        found = make_plan(model)
    except NoPlan:
        return
    layer_of = {n: number for number, layer in enumerate(found.layers) for n in layer}
    changed = {
        variable: layer_of[n] for n, move in enumerate(found.moves) for variable, _ in move.changes
    }
    for n, move in enumerate(found.moves):
        if move.kind == "activate":
            wires = [f"con:{wire}" for wire in model.connectors_of[move.subject]]
            keys = [f"cfg:{key}" for key in model.keys_of[move.subject]]
            assert all(changed.get(each, -1) < layer_of[n] for each in (*wires, *keys))


@given(models())
@settings(max_examples=60, deadline=None)
def test_of_wishes_that_cannot_hold_together_none_can_be_left_out(model):
    wishes = conflict(model)
    named = [wish for wish in model.desired.items() if wish[0] in wishes]
    if wishes:
        with pytest.raises(NoPlan):
            make_plan(model.wishing(named))
    for each in named:
        make_plan(model.wishing([other for other in named if other != each]))


def conflict(model: Model) -> set[str]:
    """Return the variables of the wishes that are said not to hold together, if any."""
    try:
        make_plan(model)
    except NoPlan as error:
        return set(error.variables)
    return set()


@given(models(), st.data())
@settings(max_examples=60, deadline=None)
def test_broken_off_anywhere_the_rest_is_planned_from_there(model, data):
    try:
        found = make_plan(model)
    except NoPlan:
        return
    live = {variable: model.now(variable) for variable in model.variables()}
    count = data.draw(st.integers(0, len(found.moves)))
    for move in found.moves[:count]:
        live.update(move.changes)
    rest = make_plan(Model(**{**vars_of(model), "live": live}))
    assert rest.cost == sum(move.cost for move in found.moves[count:])
