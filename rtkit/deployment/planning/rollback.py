"""Rollback goals: desire the state before a plan, less what turned out impossible."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

from rtkit.deployment.facts import Snapshot
from rtkit.deployment.planning import model as var
from rtkit.deployment.planning.model import ConnectionVariable, Model, Wish, manager_of, owner_of
from rtkit.fast_dataclass import replace


class Rollback:
    """Goal of the state before a plan; impossible parts are given up, and the rest goes on."""

    def __init__(self, survey: Callable[[Snapshot], Model], before: Snapshot) -> None:
        """Prepare the way back to what lived `before`; `survey` returns the model of a snapshot."""
        self._survey = survey
        self._before = before
        self._was = survey(before)
        self._joined = {
            connector.connector_id: tuple(end.instance for end in connector.ports)
            for connector in before.connectors
        }
        self._failures: Counter[str] = Counter()

    def model(self, now: Snapshot) -> Model:
        """Return what lives now with all that lived before as desired, but what is given up."""
        whole = self._whole(now)
        given_up = {v for name in self._failures for v in self._near(whole, name)}
        return whole.wishing((v, value) for v, value in whole.desired.items() if v not in given_up)

    def give_up(self, variables: Iterable[str]) -> None:
        """Withdraw impossible desired values: more of what is near, the more often it failed."""
        self._failures.update(variables)

    def unlike(self, now: Snapshot) -> Iterator[str]:
        """Yield what is not as it was before."""
        whole = self._whole(now)
        for variable in whole.desired:
            was, value = self._was.now(variable), whole.now(variable)
            is_as_wished = whole.allows(variable, value)
            if not is_as_wished or (was == var.ERROR and value != var.ERROR):
                yield difference(whole, variable, was)
        yield from _contexts_unlike(self._before, now)
        names = {facts.instance for facts in now.components}
        for facts in self._before.components:
            if facts.zombie and facts.instance not in names:
                yield f"{facts.instance} is not there (was a zombie)"

    def gone(self, now: Snapshot) -> list[str]:
        """Return the managers that have ended."""
        ran = {each.manager for each in (self._before, *self._before.others) if each.pid}
        return [m.manager for m in (now, *now.others) if not m.pid and m.manager in ran]

    def _whole(self, now: Snapshot) -> Model:
        model = rollback_goal(self._survey(now), self._was, self._joined)
        return without(model, self._was, self.gone(now))

    def _near(self, model: Model, variable: str) -> Iterator[str]:
        """Yield the variables that are given up because of one that failed so often."""
        yield variable
        failures = self._failures[variable]
        if failures == 1 and not variable.startswith("cmp:"):
            return
        units = set(_units_of(model, variable))
        for _ in range(failures - 2):
            units |= {each for name in units for each in _beside(model, name)}
        for name in units:
            yield from (f"cmp:{name}", f"act:{name}")
            yield from (f"cfg:{key}" for key in model.keys_of[name])
            connectors = (f"con:{connector}" for connector in model.connectors_of[name])
            yield from (v for v in connectors if failures > 1 or model.desired.get(v) == var.YES)


def _units_of(model: Model, variable: str) -> Iterator[str]:
    """Yield the components that a variable is about, as far as the model has them."""
    kind, _, name = variable.partition(":")
    if kind == "con":
        yield from model.connectors[name].ends
    elif kind == "pkg":
        yield from (
            u.name for u in model.units.values() if u.package and name.endswith(f"/{u.package}")
        )
    elif kind in ("mgr", "mod"):
        manager, _, module = name.partition("/")
        for unit in model.units.values():
            places = (*unit.places, model.now(f"cmp:{unit.name}"))
            is_there = any(manager_of(place) == manager for place in places)
            if is_there and module in ("", unit.module):
                yield unit.name
    elif owner_of(name) in model.units:
        yield owner_of(name)


def _beside(model: Model, name: str) -> Iterator[str]:
    """Yield the components that one is connected with, composed of, or part of."""
    yield from (end for each in model.connectors_of[name] for end in model.connectors[each].ends)
    yield from model.wholes_of[name]
    yield from (each for each in model.units[name].members if each in model.units)


def _contexts_unlike(before: Snapshot, now: Snapshot) -> Iterator[str]:
    """Yield components that were Active in some of their contexts only, and now are in others.

    A plan knows of each whether it is Active at all, so this is not led back, but reported.
    """
    living = {facts.instance: facts for facts in now.components}
    for facts in before.components:
        was = {each.id: each.state for each in facts.contexts}
        there = living.get(facts.instance)
        if len(set(was.values())) < 2 or there is None:
            continue
        for each in there.contexts:
            if was.get(each.id, each.state) is not each.state:
                place = f"{facts.instance} is {each.state} in execution context {each.id}"
                yield f"{place} (was {was[each.id]})"


def difference(model: Model, variable: str, was: str) -> str:
    """Return in words how a variable is, and how it was."""
    kind, text, value = variable[:3], model.text_of(variable), model.now(variable)
    if kind == "cfg":
        return f"{text}{value} (was {was})"
    if kind in ("act", "mgr"):
        return f"{text} is {value} (was {was})"
    if var.ABSENT in (value, was) or var.NO in (value, was):
        return f"{text} is there" if was in (var.ABSENT, var.NO) else f"{text} is not there"
    return f"{text} is another" if kind == "con" else f"{text} is at {value} (was at {was})"


def rollback_goal(now: Model, before: Model, joined: Mapping[str, tuple[str, ...]]) -> Model:
    """Return the model of what lives now with all that lived before as desired.

    Things that somebody else made meanwhile, and nobody knew of before, are left as they are.

    Args:
        now: Facts of now, and the desired values.
        before: Facts of before.
        joined: The components that each connection joined before.
    """
    live, desired = dict(now.live), dict[str, Wish]()
    units, connectors = dict(now.units), dict(now.connectors)
    for name, unit in now.units.items():
        if name not in before.units:
            continue
        place = before.now(f"cmp:{name}")
        desired[f"cmp:{name}"] = place
        if place == var.ABSENT:
            continue
        units[name] = replace(unit, places=(place,), why_not="")
        was = before.now(f"act:{name}")
        # Nothing leads into Error; at rest it is as near to it as can be.
        desired[f"act:{name}"] = (var.ERROR, var.INACTIVE) if was == var.ERROR else was
    keys = dict(now.keys)
    for key, known in now.keys.items():
        variable = f"cfg:{key}"
        if variable in before.live:
            desired[variable] = before.live[variable]
            if known.is_fixed:  # what is created again is created as it was
                keys[key] = replace(known, default=before.live[variable])
    for name in now.connectors:
        if name not in before.connectors:
            continue
        variable = f"con:{name}"
        was = before.now(variable)
        if was == var.OTHER:
            # The connection that had its name is desired now, and the present one is the other.
            live[variable] = {var.YES: var.OTHER, var.OTHER: var.YES}.get(now.now(variable), var.NO)
            if not all(end in units for end in joined[name]):
                continue
            connectors[name] = ConnectionVariable(joined[name], text=now.connectors[name].text)
        desired[variable] = var.NO if was == var.NO else var.YES
    for variable in now.live:
        if variable.startswith(("mod:", "pkg:")):
            desired[variable] = before.now(variable)
    return replace(now, units=units, connectors=connectors, keys=keys, live=live, desired=desired)


def without(model: Model, before: Model, managers: Collection[str]) -> Model:
    """Return the same model with nothing desired of what was in managers that have ended."""
    if not managers:
        return model
    lost = {name for name in model.units if _home(before, model, name) in managers}

    def is_lost(variable: str) -> bool:
        kind, _, name = variable.partition(":")
        if kind == "pkg":
            return False
        if kind == "con":
            return not lost.isdisjoint(model.connectors[name].ends)
        if kind in ("mgr", "mod"):
            return name.partition("/")[0] in managers
        return owner_of(name) in lost

    return model.wishing((v, value) for v, value in model.desired.items() if not is_lost(v))


def _home(before: Model, now: Model, name: str) -> str:
    """Return the manager that a component was in, or is to be in."""
    was = before.now(f"cmp:{name}") if name in before.units else var.ABSENT
    places = [place for place in (was, now.now(f"cmp:{name}")) if place != var.ABSENT]
    return manager_of([*places, *now.units[name].places, ""][0])
