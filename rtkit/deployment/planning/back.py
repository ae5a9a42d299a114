"""The way back: what lived before as what is wished now."""

from __future__ import annotations

from dataclasses import replace

from rtkit.deployment.planning.model import ABSENT, NO, OTHER, YES, Model, Wish


def way_back(now: Model, before: Model) -> Model:
    """Return the model of what lives now with all that lived before as its wishes.

    What somebody else made meanwhile, and nobody knew of before, is left as it is.
    """
    live, desired = dict(now.live), dict[str, Wish]()
    units = dict(now.units)
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
        desired[variable] = NO if was == NO else YES
    for variable in now.live:
        if variable.startswith("mod:"):
            desired[variable] = before.now(variable)
    return replace(now, units=units, live=live, desired=desired)
