"""The way back: what lived before as what is wished now."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rtkit.deployment.planning.model import (
    ABSENT,
    NO,
    OTHER,
    YES,
    Model,
    Wire,
    Wish,
    manager_of,
    owner_of,
)
from rtkit.records import replace


def way_back(now: Model, before: Model, joined: Mapping[str, tuple[str, ...]]) -> Model:
    """Return the model of what lives now with all that lived before as its wishes.

    What somebody else made meanwhile, and nobody knew of before, is left as it is.

    Args:
        now: What lives, and what was wished.
        before: What lived before.
        joined: The components that each connection joined before.
    """
    live, desired = dict(now.live), dict[str, Wish]()
    units, wires = dict(now.units), dict(now.wires)
    for name, unit in now.units.items():
        if name not in before.units:
            continue
        place = before.now(f"cmp:{name}")
        desired[f"cmp:{name}"] = place
        if place == ABSENT:
            continue
        units[name] = replace(unit, places=(place,), why_not="")
        desired[f"act:{name}"] = before.now(f"act:{name}")
    for key in now.keys:
        variable = f"cfg:{key}"
        if variable in before.live:
            desired[variable] = before.live[variable]
    for name in now.wires:
        if name not in before.wires:
            continue
        variable = f"con:{name}"
        was = before.now(variable)
        if was == OTHER:
            # What was there under its name is what is wished now, and what is there the other.
            live[variable] = {YES: OTHER, OTHER: YES}.get(now.now(variable), NO)
            if not all(end in units for end in joined[name]):
                continue
            wires[name] = Wire(joined[name], text=now.wires[name].text)
        desired[variable] = NO if was == NO else YES
    for variable in now.live:
        if variable.startswith("mod:"):
            desired[variable] = before.now(variable)
    return replace(now, units=units, wires=wires, live=live, desired=desired)


def without(model: Model, before: Model, managers: Collection[str]) -> Model:
    """Return the same model with no wishes of what was in managers that have ended."""
    if not managers:
        return model
    lost = {name for name in model.units if _home(before, model, name) in managers}

    def is_lost(variable: str) -> bool:
        kind, _, name = variable.partition(":")
        if kind == "con":
            return not lost.isdisjoint(model.wires[name].ends)
        if kind in ("mgr", "mod"):
            return name.partition("/")[0] in managers
        return owner_of(name) in lost

    return model.wishing((v, wish) for v, wish in model.desired.items() if not is_lost(v))


def _home(before: Model, now: Model, name: str) -> str:
    """Return the manager that a component was in, or is to be in."""
    was = before.now(f"cmp:{name}") if name in before.units else ABSENT
    places = [place for place in (was, now.now(f"cmp:{name}")) if place != ABSENT]
    return manager_of([*places, *now.units[name].places, ""][0])
