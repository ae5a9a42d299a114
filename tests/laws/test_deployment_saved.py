"""Plans that are saved: read again they are the same, and what has changed is told."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from deployments import models
from hypothesis import given, settings
from hypothesis import strategies as st

from rtkit.api.system_profiles import is_saved_plan
from rtkit.deployment.planning.deployment_plan import DeploymentPlan, make_plan
from rtkit.deployment.planning.model import Model
from rtkit.deployment.planning.saved import changes, from_text, to_text
from rtkit.errors import Impossible, InvalidDocument, Malformed

few = settings(max_examples=20, deadline=None)


def plan_of(model: Model) -> DeploymentPlan:
    """Return a plan, of what lives to itself where there is none to what is wished."""
    try:
        return make_plan(model)
    except Impossible:
        return make_plan(model.wishing(()))


def text_of(plan: DeploymentPlan) -> bytes:
    return to_text(plan, {"a": 1}, "today", {"options": {}}).encode()


@given(models())
@few
def test_a_plan_is_read_as_it_was_saved(model):
    plan = plan_of(model)
    text = text_of(plan)
    assert is_saved_plan(text)
    saved = from_text(text, "p")
    assert list(changes(saved.model, plan.model)) == []
    again = saved.plan(plan.model)
    assert (again.moves, again.cost, again.gap) == (plan.moves, plan.cost, plan.gap)


@given(models(), st.data())
@few
def test_each_change_is_told(model, data):
    saved = from_text(text_of(plan_of(model)), "p")
    live = {v: x for v, x in saved.model.live.items() if not v.startswith("mod:")}
    variable = data.draw(st.sampled_from(sorted(live)))
    now = replace(saved.model, live={**saved.model.live, variable: "another"})
    assert len(list(changes(saved.model, now))) == 1
    assert len(list(changes(now, saved.model))) == 1
    name = data.draw(st.sampled_from(sorted(saved.model.units)))
    unit = replace(saved.model.units[name], module="Z")
    units = {**saved.model.units, name: unit}
    assert list(changes(saved.model, replace(saved.model, units=units))) == [
        f"component {name} would be made otherwise"
    ]


@given(models(), st.data())
@few
def test_what_is_cut_or_changed_is_refused(model, data):
    text = text_of(plan_of(model))
    cut = data.draw(st.integers(1, len(text) - 1))
    if text[:cut].strip() != text.strip():
        with pytest.raises(InvalidDocument, match="is cut or damaged"):
            from_text(text[:cut], "p")
    changed = json.loads(text)
    changed["steps"] = [["deactivate", "a", "", 1.0], *changed["steps"]]
    with pytest.raises(InvalidDocument, match="was changed"):
        from_text(json.dumps(changed).encode(), "p")


def test_another_version_is_named():
    text = text_of(make_plan(Model({}, {})))
    newer = text.replace(b"saved-plan/1", b"saved-plan/2")
    assert is_saved_plan(newer)
    with pytest.raises(InvalidDocument, match=r"p: rtkit.saved-plan/2 is of another version"):
        from_text(newer, "p")


def test_steps_that_lead_nowhere_are_refused():
    plan = make_plan(Model({"m": None}, {}, desired={"mgr:m": "up"}))
    saved = from_text(text_of(plan), "p")
    for steps in (
        (("activate", "nobody", "", 1.0),),
        (("fly", "m", "", 1.0),),
        (("start_manager", "m", "", 1.0),) * 2,
    ):
        with pytest.raises(Malformed, match="its steps do not lead where they should"):
            replace(saved, steps=steps).plan(plan.model)
