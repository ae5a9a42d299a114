"""Renders a deployment plan as text for people, as JSON, and as a graph."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any

from rtkit.deployment.planning.deployment_plan import DeploymentPlan
from rtkit.deployment.planning.model import NO, UNKNOWN, YES, owner_of
from rtkit.deployment.planning.operators import Operator
from rtkit.deployment.planning.step_costs import ORIGINS, TABLE, USUAL, Costs
from rtkit.report.finding import counted

NOTHING_TO_DO = "nothing to do"


def lines(
    plan: DeploymentPlan, costs: Costs = USUAL, unreachable: Collection[str] = ()
) -> Iterator[str]:
    """Yield a plan for people: steps with costs and changes, what is done at once, what is kept.

    Where not all costs are of the table, their sources are stated; managers that are `unreachable`
    are no part of it.
    """
    if not plan.moves:
        what = "what can be reached" if unreachable else "everything"
        yield f"{NOTHING_TO_DO}: {what} is as wanted"
    else:
        steps = counted(len(plan.moves), "step")
        looked_at = f", {plan.looked_at} combinations looked at" if plan.looked_at else ""
        yield f"plan: {steps}, cost {plan.cost:g} ({quality(plan)}){looked_at}"
        rows = [
            (str(number), move.text, f"{move.cost:g}", change)
            for number, (move, change) in enumerate(zip(plan.moves, changes(plan), strict=True), 1)
        ]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for number, text, cost, change in rows:
            line = f"  {number:>{widths[0]}}  {text:<{widths[1]}}  {cost:>{widths[2]}}  {change}"
            yield line.rstrip()
        if any(len(layer) > 1 for layer in plan.layers):
            yield f"at once: {'; '.join(_ranges([n + 1 for n in each]) for each in plan.layers)}"
        yield from _sources(plan, costs)
    managers, units, connectors = plan.kept
    kept = [(managers, "manager"), (units, "component"), (connectors, "connection")]
    yield f"kept: {', '.join(counted(*each) for each in kept if each[0]) or 'nothing'}"


def quality(plan: DeploymentPlan) -> str:
    """Return how good a plan is proved to be."""
    return f"at most {plan.gap:g} above the cheapest" if plan.gap else "optimal"


def changes(plan: DeploymentPlan) -> Iterator[str]:
    """Yield what each step changes."""
    state: dict[str, str] = {}
    for move in plan.moves:
        variable, value = move.changes[0]
        before = state.get(variable, plan.model.now(variable))
        yield _replacing(plan, move) or _change(move, "?" if before == UNKNOWN else before, value)
        state.update(move.changes)


def as_plain(plan: DeploymentPlan, costs: Costs = USUAL) -> dict[str, Any]:
    """Return a plan as plain data for JSON; steps are numbered from 1."""
    layer_of = {n: number for number, layer in enumerate(plan.layers, 1) for n in layer}
    managers, units, connectors = plan.kept
    return {
        "cost": round(plan.cost, 6),
        "optimal": plan.gap == 0,
        "gap": plan.gap,
        "looked_at": plan.looked_at,
        "steps": [
            {
                "number": n + 1,
                "layer": layer_of[n],
                "after": sorted(each + 1 for each in plan.before[n]),
                "kind": move.kind,
                "subject": _subject(move),
                "text": move.text,
                "cost": move.cost,
                "cost_from": costs.origin(move.kind, move.subject),
                "change": change,
            }
            for n, (move, change) in enumerate(zip(plan.moves, changes(plan), strict=True))
        ],
        "kept": {"managers": managers, "components": units, "connections": connectors},
    }


def to_dot(plan: DeploymentPlan) -> Iterator[str]:
    """Yield the lines of a graph for Graphviz: an edge from what must be done just before."""
    yield "digraph plan {"
    yield "  rankdir=LR;"
    yield "  node [shape=box];"
    for n, move in enumerate(plan.moves):
        text = f"{n + 1} {move.text}".replace("\\", "\\\\").replace('"', '\\"').replace("\n", " ")
        yield f'  s{n + 1} [label="{text}"];'
    for n, before in enumerate(_just_before(plan.before)):
        for each in before:
            yield f"  s{each + 1} -> s{n + 1};"
    yield "}"


def _just_before(before: Sequence[Collection[int]]) -> Iterator[list[int]]:
    """Yield for each step those before it that are not before another one before it."""
    all_before: list[int] = []  # of each step a number with a bit for each step
    for each in before:
        further = 0
        for one in each:
            further |= all_before[one]
        yield [one for one in sorted(each) if not further >> one & 1]
        all_before.append(further | sum(1 << one for one in each))


def _sources(plan: DeploymentPlan, costs: Costs) -> Iterator[str]:
    kinds: dict[str, dict[str, None]] = {}
    for move in plan.moves:
        kinds.setdefault(costs.origin(move.kind, move.subject), {})[move.kind] = None
    if kinds.keys() - {TABLE}:
        parts = (f"{source}: {', '.join(kinds[source])}" for source in ORIGINS if source in kinds)
        yield f"costs: {'; '.join(parts)}"


def _change(move: Operator, before: str, after: str) -> str:
    if move.kind == "configure":
        return f"{before} -> {after}"
    if move.kind in ("activate", "deactivate", "reset"):
        return f"{move.subject} {before} -> {after}"
    return f"{before} -> {after}" if {before, after} - {NO, YES} else ""


def _replacing(plan: DeploymentPlan, move: Operator) -> str:
    """Return why a component is ended though it is wanted: what cannot be changed in place."""
    model = plan.model
    if move.kind != "delete":
        return ""
    fixed = (f"cfg:{key}" for key in model.keys_of[move.subject] if model.keys[key].is_fixed)
    reasons = [model.now(each) for each in fixed if not model.allows(each, model.now(each))]
    return f"replace: {'; '.join(reasons)}" if reasons else ""


def _subject(move: Operator) -> str:
    if move.kind == "configure":
        return f"{owner_of(move.subject)}.{move.subject.partition('.')[2]}"
    return move.subject.replace("\n", "/")


def _ranges(numbers: Sequence[int]) -> str:
    """Return numbers with those that follow one another as a range: ``2-4 7``."""
    ranges: list[list[int]] = []
    for number in numbers:
        if ranges and ranges[-1][-1] == number - 1:
            ranges[-1].append(number)
        else:
            ranges.append([number])
    return " ".join(f"{each[0]}-{each[-1]}" if len(each) > 1 else f"{each[0]}" for each in ranges)
