"""Saved plans: a plan with all its inputs, as text, to be kept in a file and carried out later.

A saved plan holds the live state and the desired state as the planner saw them (a `Model`). So a
later run reports what has changed since.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from hashlib import sha256
from typing import Any

from rtkit.deployment.planning.default_costs import DEFAULT_COSTS
from rtkit.deployment.planning.deployment_plan import DeploymentPlan
from rtkit.deployment.planning.model import (
    ComponentVariable,
    ConnectionVariable,
    Model,
    ParameterVariable,
    owner_of,
)
from rtkit.deployment.planning.operators import Operator, Operators, judge
from rtkit.deployment.planning.rendering import as_plain
from rtkit.deployment.planning.rollback import difference
from rtkit.deployment.planning.sequencing import order
from rtkit.errors import InvalidDocument, Malformed

_SCHEMA = "rtkit.saved-plan"
_VERSION = 1
_TABLES = {
    "units": ("units", ComponentVariable),
    "wires": ("connectors", ConnectionVariable),
    "keys": ("keys", ParameterVariable),
}
"""Attribute of a model, and class, of each table in the text."""


@dataclass(frozen=True)
class SavedPlan:
    """A plan as it was made.

    Attributes:
        made: When, as people read it.
        about: Its origin: the profile and the options.
        model: Values of then: present, possible and desired ones.
        ranks: Components of lower numbers are activated before those of higher ones.
        steps: Kind, subject, value and cost of each step, in order.
        gap: By how much it may be dearer than the cheapest.
    """

    made: str
    about: Mapping[str, Any]
    model: Model
    ranks: Mapping[str, int]
    steps: tuple[tuple[str, str, str, float], ...]
    gap: float

    def plan(self, model: Model) -> DeploymentPlan:
        """Return the plan over what lives, which must be as it was.

        Raises:
            Malformed: The steps do not lead there.
        """
        moves = Operators(model)
        try:
            made = tuple(_move(moves, *step) for step in self.steps)
            why = judge(model, made)
        except KeyError as error:
            why = f"there is no {error}"
        if why:
            raise Malformed(f"its steps do not lead where they should: {why}")
        before = tuple(map(frozenset, order(made, self.ranks)))
        return DeploymentPlan(model, made, before, self.gap)


def to_text(plan: DeploymentPlan, ranks: Mapping[str, int], made: str, about: Any) -> str:
    """Return a plan as text."""
    model = plan.model
    data = {
        "made": made,
        "about": about,
        # For people; what is carried out stands below.
        "plan": [step["text"] for step in as_plain(plan)["steps"]],
        "steps": [[move.kind, move.subject, move.value, move.cost] for move in plan.moves],
        "ranks": dict(ranks),
        "gap": plan.gap,
        **{key: _tables(getattr(model, name)) for key, (name, _) in _TABLES.items()},
        "live": dict(model.live),
        "desired": dict(model.desired),
        "managers": {n: None if m is None else sorted(m) for n, m in model.managers.items()},
        "slaves_need_modules": model.slaves_need_modules,
        "hosts": dict(model.hosts),
    }
    whole = {"schema": f"{_SCHEMA}/{_VERSION}", "digest": _digest(data), **data}
    return json.dumps(whole, indent=1, allow_nan=False) + "\n"


def from_text(text: bytes, source: str) -> SavedPlan:
    """Read a plan that was saved.

    Raises:
        InvalidDocument: It is cut, was changed, or is of another version; states which.
    """
    try:
        data = json.loads(text)
        schema, digest = data.pop("schema"), data.pop("digest")
    except (ValueError, RecursionError, KeyError, AttributeError) as error:
        raise InvalidDocument(f"{source}: the saved plan is cut or damaged: {error}") from error
    if schema != f"{_SCHEMA}/{_VERSION}":
        raise InvalidDocument(f"{source}: {schema} is of another version of rtkit")
    if digest != _digest(data):
        raise InvalidDocument(f"{source}: the saved plan was changed, or is damaged")
    try:
        return SavedPlan(
            data["made"],
            data["about"],
            _model(data),
            {str(name): int(rank) for name, rank in data["ranks"].items()},
            tuple((str(k), str(s), str(v), float(cost)) for k, s, v, cost in data["steps"]),
            float(data["gap"]),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InvalidDocument(f"{source}: the saved plan cannot be read: {error}") from error


def changes(was: Model, now: Model) -> Iterator[str]:
    """Yield in words what is otherwise than it was when a plan was made."""
    units = set(was.units) & set(now.units)
    for kind, old, new in (
        ("cmp", was.units, now.units),
        ("con", was.connectors, now.connectors),
        ("mgr", was.managers, now.managers),
    ):
        title = "component " if kind == "cmp" else ""
        texts = {
            name: title + (now if name in new else was).text_of(f"{kind}:{name}")
            for name in {**old, **new}
        }
        yield from (f"{texts[name]} is not there any more" for name in old if name not in new)
        yield from (f"{texts[name]} is there now" for name in new if name not in old)
        yield from (
            f"{texts[name]} would be made otherwise"
            for name in old
            if name in new and old[name] != new[name]
        )
    variables = dict.fromkeys([*was.variables(), *now.variables()])
    come = {name for name in units if was.now(f"cmp:{name}") != now.now(f"cmp:{name}")}
    for variable in variables:
        is_key = variable.startswith("cfg:")
        is_of_one = is_key or variable.startswith("act:")
        if is_of_one and (owner_of(variable[4:]) in come or owner_of(variable[4:]) not in units):
            continue  # reported already: all that is so shows when a component lives
        if not all(_knows(model, variable) for model in (was, now)):
            if is_key:
                yield f"parameter {variable[4:]} is another"
            continue
        if was.now(variable) != now.now(variable):
            yield difference(now, variable, was.now(variable))
        elif was.desired.get(variable) != now.desired.get(variable):
            yield f"what is wished of {variable.partition(':')[2]} is another"


def _knows(model: Model, variable: str) -> bool:
    kind, _, name = variable.partition(":")
    tables: dict[str, Mapping[str, Any]] = {"cfg": model.keys, "con": model.connectors}
    tables |= {"cmp": model.units, "act": model.units, "mgr": model.managers}
    return name in tables[kind] if kind in tables else True


def _move(moves: Operators, kind: str, subject: str, value: str, cost: float) -> Operator:
    if kind not in DEFAULT_COSTS:
        raise KeyError(kind)
    if kind in ("create", "create_slave"):
        made = moves.create(subject, value)
    else:
        made = getattr(moves, kind)(*([subject, value] if kind == "configure" else [subject]))
    return replace(made, cost=cost)


def _model(data: Mapping[str, Any]) -> Model:
    tables = {
        name: {one: cls(**_tupled(record)) for one, record in data[key].items()}
        for key, (name, cls) in _TABLES.items()
    }
    managers = {
        name: None if found is None else frozenset(found)
        for name, found in data["managers"].items()
    }
    live, desired = (_tupled(data[name]) for name in ("live", "desired"))
    needed = bool(data["slaves_need_modules"])
    hosts = dict(data.get("hosts", {}))
    wishes = {"live": live, "desired": desired, "hosts": hosts}
    return Model(managers, slaves_need_modules=needed, **wishes, **tables)


def _tables(table: Mapping[str, Any]) -> dict[str, Any]:
    return {
        name: {each.name: getattr(record, each.name) for each in fields(record)}
        for name, record in table.items()
    }


def _tupled(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _tupled(each) for key, each in value.items()}
    return tuple(map(_tupled, value)) if isinstance(value, list) else value


def _digest(data: Any) -> str:
    text = json.dumps(data, sort_keys=True, separators=(",", ":"))
    return sha256(text.encode()).hexdigest()
