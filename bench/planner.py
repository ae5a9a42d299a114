"""Measures the planner: successors a second among a million states, large deployments.

The floor of the first makes the same successors of the same states without any search; that of
the others carries the plans out on the model.
"""

from __future__ import annotations

import os
import sys
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from random import Random
from typing import Any

from bench.harness import Lines, Row, timed
from bench.pairs import paired
from rtkit.deployment.planning.deployment_plan import make_plan
from rtkit.deployment.planning.model import (
    ComponentVariable,
    ConnectionVariable,
    Model,
    ParameterVariable,
    Wish,
)
from rtkit.deployment.planning.operators import judge
from rtkit.deployment.planning.rendering import quality
from rtkit.errors import LimitReached
from rtkit.planner import Limits, Problem, State, plan

_EXAMPLES = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "examples")
_STATES = 30_000
_ROUNDS = 3


def _successors() -> Lines:
    sys.path.insert(0, _EXAMPLES)
    from manipulation.large import Large

    instance = Large(1)
    problem = instance.problem()
    states: list[State] = []
    made = sum(
        1 for state in _looked_at(problem, instance, states) for _ in problem.successors(state)
    )

    def search() -> float:
        return _each(lambda: _search(problem, instance), made)

    def bare() -> float:
        return _each(lambda: [deque(problem.successors(state), 0) for state in states], made)

    metrics = paired(search, bare, _ROUNDS)
    what = "A* among 10^6 states, one successor (10 us are 100,000 a second on one core)"
    yield Row(what, "us", metrics, 10.0, False, "the model's own work on the same states")


def _search(problem: Problem, instance: Any) -> None:
    with suppress(LimitReached):
        plan(problem, instance.heuristic, Limits(states=_STATES))


def _looked_at(problem: Problem, instance: Any, states: list[State]) -> list[State]:
    """Return the states that the search expands."""

    def noted(state: State) -> Any:
        states.append(state)
        return problem.commands

    _search(problem.replaced(commands=noted), instance)
    return states


def _each(work: Callable[[], object], count: int) -> float:
    """Return the time of a processor that one of so many takes [us]."""
    begin = time.process_time()
    work()
    return (time.process_time() - begin) / count * 1e6


def _deployments() -> Lines:
    for components, connections, target_s in ((50, 100, 1), (200, 400, 5), (1000, 2000, 60)):
        for model, how in (
            (_model(components, connections), "from nothing"),
            (_changed(components, connections), "all of it changed, places free in two managers"),
        ):
            found = make_plan(model)
            metrics = paired(
                lambda model=model: timed(lambda: make_plan(model)),  # type: ignore[misc]
                lambda found=found: timed(lambda: judge(found.model, found.moves)),  # type: ignore[misc]
                _ROUNDS,
            )
            what = f"plan of {components:,} components, {connections:,} connections, {how}"
            what += f" ({quality(found)})"
            yield Row(what, "ms", metrics, target_s * 1000, False, "carrying it out on the model")


def _model(components: int, connections: int) -> Model:
    """Return a deployment in which each component may be in the manager or in a slave."""
    units, desired = {}, dict[str, Wish]()
    for number in range(components):
        name = f"c{number}"
        units[name] = ComponentVariable(
            name, f"T{number % 20}", (f"m:slave/s{number % 7}", "m:inproc")
        )
        desired |= {f"cmp:{name}": "*", f"act:{name}": "active"}
    wires = _wires(components, connections)
    desired |= dict.fromkeys((f"con:{name}" for name in wires), "yes")
    return Model({"m": None}, units, wires, desired=desired)


def _changed(components: int, connections: int) -> Model:
    """Return a deployment in which each component is active, in a wrong place or wrongly set."""
    chance = Random(1)
    places = [f"{manager}:{at}" for manager in "mn" for at in ("inproc", "slave/s0", "slave/s1")]
    units, keys = {}, {}
    live, desired = {"mgr:m": "up", "mgr:n": "up"}, dict[str, Wish]()
    for number in range(components):
        name = f"c{number}"
        may_be = tuple(chance.sample(places, 3))
        units[name], keys[f"{name}.gain"] = (
            ComponentVariable(name, f"T{number % 20}", may_be),
            ParameterVariable("0"),
        )
        live |= {f"cmp:{name}": chance.choice(places), f"act:{name}": "active"}
        live[f"cfg:{name}.gain"] = "1"
        wish: Wish = "*" if number % 2 else may_be
        desired |= {f"cmp:{name}": wish, f"act:{name}": "active", f"cfg:{name}.gain": "2"}
    wires = _wires(components, connections)
    for name in wires:
        live[f"con:{name}"] = chance.choice(["yes", "no", "other"])
        desired[f"con:{name}"] = chance.choice(["yes", "yes", "no"])
    return Model({"m": None, "n": None}, units, wires, keys, live, desired)


def _wires(components: int, connections: int) -> dict[str, ConnectionVariable]:
    wires = {}
    for number in range(connections):
        other = (number * 37 + number // components + 1) % components
        wires[f"k{number}"] = ConnectionVariable((f"c{number % components}", f"c{other}"))
    return wires


PARTS = {"successors": _successors, "deployments": _deployments}
