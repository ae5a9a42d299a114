"""Draws a start or stop as a graph for Graphviz: the actions, their conditions and delays."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.deployment.conditions import OrderTarget, StartCondition
from rtkit.deployment.start_schedule import ScheduledAction, StartPlan
from rtkit.rtc.enums import Transition

_BEGIN = "begin"
_ARMED = "delayed"


def to_dot(plan: StartPlan) -> Iterator[str]:
    """Yield the lines of a graph; optional actions have a dashed border.

    The actions that wait for nothing are a chain, in their order. Behind it the delayed ones begin:
    an edge is a condition, dashed when only the sending of the action before counts.
    """
    yield f"digraph {'start' if plan.transition is Transition.ACTIVATE else 'stop'} {{"
    yield "  rankdir=LR;"
    yield "  node [shape=box];"
    yield f"  {_BEGIN} [shape=circle, label={_quoted(_BEGIN)}];"
    for turn in plan.turns:
        style = "" if turn.step.is_required else ", style=dashed"
        label = f"{{{turn.id}}} {plan.transition.value.capitalize()}\n{turn.name}"
        yield f"  a{turn.id} [label={_quoted(label)}{style}];"
    before = _BEGIN
    for turn in plan.immediate:
        places = sorted({condition.sequence for condition in turn.conditions})
        yield _edge(before, f"a{turn.id}", ", ".join(f"Order {place}" for place in places))
        before = f"a{turn.id}"
    if plan.delayed:
        yield f"  {_ARMED} [shape=circle, label={_quoted(_ARMED)}];"
        yield _edge(before, _ARMED, "")
    ids = {turn.target: turn.id for turn in plan.turns}
    for turn in plan.delayed:
        for condition in turn.conditions:
            yield _condition(condition, turn, ids)
    yield "}"


def _condition(
    condition: StartCondition, turn: ScheduledAction, ids: dict[OrderTarget, int]
) -> str:
    label = f"Order {condition.sequence}"
    if condition.preceding is None:
        label += f"/Wait {condition.wait_ms}ms" if condition.wait_ms else ""
        return _edge(_ARMED, f"a{turn.id}", label)
    label += "/Sync" if condition.is_sync else "/After"
    label += f", at most {condition.timeout_ms}ms" if condition.timeout_ms else ""
    before = f"a{ids[condition.preceding]}"
    return _edge(before, f"a{turn.id}", label, is_dashed=not condition.is_sync)


def _edge(before: str, after: str, label: str, *, is_dashed: bool = False) -> str:
    options = [f"label={_quoted(label)}"] if label else []
    options += ["style=dashed"] if is_dashed else []
    return f"  {before} -> {after}" + (f" [{', '.join(options)}]" if options else "") + ";"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
