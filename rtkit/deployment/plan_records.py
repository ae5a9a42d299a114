"""Records of plans by layers, and of starts and stops, in the form of those of ``rtplan``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from rtkit.deployment.actions import Create
from rtkit.deployment.conditions import OrderTarget
from rtkit.deployment.layered_plan import Check, LayeredPlan, PlannedAction
from rtkit.deployment.planning.measured_times import kind_of
from rtkit.deployment.planning.model import cost_name
from rtkit.deployment.planning.step_costs import Costs
from rtkit.deployment.start_schedule import ScheduledAction, StartPlan
from rtkit.rtc.create import parse_create

_KINDS: Mapping[str, str] = {
    "compose": "create",
    "attach": "connect",
    "activate sets": "configure",
    "exit": "delete",
}
"""Kinds of steps by the names of layers, where these are others."""
_Numbered = tuple[int, str, PlannedAction]


def layered_record(plans: Iterable[LayeredPlan], costs: Costs) -> dict[str, Any]:
    """Return plans that are carried out one after the other as one record, like `as_plain`."""
    given = list(plans)
    checks = [check for plan in given for check in plan.checks]
    return _record(_in_layers(given), checks, costs)


def start_record(plan: StartPlan, costs: Costs) -> dict[str, Any]:
    """Return a start or stop as a record; those that wait for nothing go one after the other."""
    kind = plan.transition.value
    steps = ((layer, kind, turn.step) for layer, turn in _turns_in_layers(plan))
    return _record(steps, plan.checks, costs)


def _in_layers(plans: Iterable[LayeredPlan]) -> Iterator[_Numbered]:
    number = 0
    for layer in (layer for plan in plans for layer in plan.layers):
        kind = _KINDS.get(layer.name, layer.name)
        steps = [step for step in layer.steps if step.text]
        for n, step in enumerate(steps):
            number += 1 if layer.is_ordered or n == 0 else 0
            yield number, kind, step


def _turns_in_layers(plan: StartPlan) -> Iterator[tuple[int, ScheduledAction]]:
    yield from enumerate(plan.immediate, 1)
    first = len(plan.immediate) + 1
    layers: dict[OrderTarget, int] = {}
    left = list(plan.delayed)
    while left:
        waiting = {turn.target for turn in left}
        ready = [turn for turn in left if not any(c.preceding in waiting for c in turn.conditions)]
        for turn in ready or left:
            before = (layers.get(c.preceding, 0) for c in turn.conditions if c.preceding)
            layers[turn.target] = max((each + 1 for each in before), default=first)
            layers[turn.target] = max(layers[turn.target], first)
        left = [turn for turn in left if turn.target not in layers]
    yield from ((layers[turn.target], turn) for turn in plan.delayed)


def _record(steps: Iterable[_Numbered], checks: Iterable[Check], costs: Costs) -> dict[str, Any]:
    records = [_step(number, *each, costs) for number, each in enumerate(steps, 1)]
    return {
        "cost": round(sum(each["cost"] for each in records), 6),
        "checks": [
            {"text": each.text, "required": each.is_required, "failure": each.failure}
            for each in checks
        ],
        "steps": records,
    }


def _step(number: int, layer: int, kind: str, step: PlannedAction, costs: Costs) -> dict[str, Any]:
    action = step.action
    kind = (kind_of(action) if action is not None else "") or kind
    subject = _subject(action) or step.where
    name = cost_name(costs.values, kind, subject)
    return {
        "number": number,
        "layer": layer,
        "kind": kind,
        "subject": subject,
        "text": step.text,
        "cost": 0 if action is None else costs.values[name],
        "cost_from": costs.origin(kind, subject),
        "change": "",
        "required": step.is_required,
        "holds": step.holds,
        "blocked": step.blocked,
    }


def _subject(action: object) -> str:
    if isinstance(action, Create):
        return parse_create(action.create).instance_name
    connector = getattr(action, "connector", None)
    if connector is not None:
        return str(connector.connector_id)
    words = ("instance", "connector_id", "participant", "path")
    return next((str(getattr(action, each)) for each in words if hasattr(action, each)), "")
