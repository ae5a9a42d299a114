"""Explains why there is no plan: desired values in conflict, and the reasons of each."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from rtkit.deployment.planning.decide import Stuck, check_managers, decide
from rtkit.deployment.planning.model import ABSENT, ANY, NO, YES, Model, Wish, manager_of, owner_of
from rtkit.errors import Impossible
from rtkit.planner import minimal_conflict

Wished = tuple[str, Wish]


class NoPlan(Impossible):
    """Nothing leads to the desired state.

    Attributes:
        wishes: Desired values; without any one of them the others can hold: ``VARIABLE=VALUE``.
        variables: The same desired values by the variables that they are about.
        reasons: Obstacles to them.
        more: Further obstacles, to other desired values.
    """

    def __init__(
        self,
        wishes: Sequence[Wished],
        words: Sequence[str],
        reasons: Sequence[str],
        more: Sequence[str] = (),
    ) -> None:
        self.wishes = tuple(map(_text, wishes))
        self.variables = tuple(variable for variable, _ in wishes)
        self.reasons = tuple(reasons)
        self.more = tuple(more)
        how = "cannot hold together" if len(wishes) > 1 else "cannot be"
        message = f"impossible: {', '.join(words)} {how}"
        message += f" ({'; '.join(reasons)})" if reasons else ""
        super().__init__(message + (f"; moreover: {'; '.join(more)}" if more else ""))


def explained(model: Model, error: Impossible) -> NoPlan:
    """Return a minimal set of desired values that make it impossible, with reasons."""
    near = _near(model, error.units) if isinstance(error, Stuck) else None
    wishes = list(model.desired.items())
    local = [w for w in wishes if near is None or _concerns(model, w[0], near)]
    if near is not None and _is_possible(model, local):
        local = wishes
    found = minimal_conflict(local, lambda some: _is_possible(model, some))
    words = [_words(model, desired) for desired in found or local]
    reasons = list(dict.fromkeys(_reasons(model, found)))
    more = [why for why in _unmakable(model) if why not in reasons]
    return NoPlan(found or local, words, reasons, more)


def _is_possible(model: Model, wishes: Sequence[Wished]) -> bool:
    asked = model.wishing(wishes)
    try:
        check_managers(asked)
        decide(asked)
    except Impossible:
        return False
    return True


def _near(model: Model, units: Collection[str]) -> set[str]:
    return {
        *units,
        *(
            end
            for name in units
            for connector in model.connectors_of[name]
            for end in model.connectors[connector].ends
        ),
    }


def _concerns(model: Model, variable: str, units: Collection[str]) -> bool:
    kind, _, name = variable.partition(":")
    if kind == "con":
        return any(end in units for end in model.connectors[name].ends)
    return kind in ("mgr", "mod", "pkg") or owner_of(name) in units


def _text(desired: Wished) -> str:
    variable, value = desired
    return f"{variable}={value if isinstance(value, str) else '|'.join(value)}"


def _words(model: Model, desired: Wished) -> str:
    """Return a desired value in words for people."""
    variable, values = desired
    kind, _, name = variable.partition(":")
    value = values if isinstance(values, str) else " or ".join(values)
    text = model.text_of(variable)
    match kind:
        case "cmp":
            return {ANY: name, ABSENT: f"no {name}"}.get(value, f"{name} at {value}")
        case "cfg":
            return f"{text}{value}"
        case "con":
            return text if value == YES else f"no {text}"
        case "mod":
            module, _, manager = text.rpartition(" on ")
            return f"{module} {value} on {manager}"
        case "pkg":
            return f"no {text}" if value == ABSENT else text
    return f"{text} {value}"


def _reasons(model: Model, wishes: Sequence[Wished]) -> Iterator[str]:
    asked = model.wishing(wishes)
    for variable, _ in wishes:
        kind, _, name = variable.partition(":")
        if kind == "con":
            connector = model.connectors[name]
            if connector.why_not and not asked.allows(variable, NO):
                yield connector.why_not
            for end in dict.fromkeys(connector.ends):
                yield from _unit_reasons(asked, end)
        elif kind == "mod":
            manager, _, module = name.partition("/")
            found = model.managers.get(manager, frozenset())
            if found is not None and module not in found and not asked.allows(variable, ABSENT):
                yield f"{manager} does not find module {module}"
        elif kind in ("cmp", "act", "cfg"):
            yield from _unit_reasons(asked, owner_of(name))


def _unmakable(model: Model) -> Iterator[str]:
    """Yield why components cannot be made that must be: who repairs one thing wants to know all."""
    for name, unit in model.units.items():
        is_there = model.now(f"cmp:{name}") != ABSENT
        if unit.why_not and not is_there and not model.allows(f"cmp:{name}", ABSENT):
            yield unit.why_not


def _unit_reasons(model: Model, name: str) -> Iterator[str]:
    """Yield why a component cannot be made, where it does not live."""
    unit = model.units[name]
    variable = f"cmp:{name}"
    if model.now(variable) != ABSENT and model.allows(variable, model.now(variable)):
        return
    if unit.why_not:
        yield unit.why_not
    for place in unit.places:
        manager = manager_of(place)
        found = model.managers.get(manager, frozenset())
        if manager not in model.managers:
            yield f"there is no manager {manager}"
        elif found is not None and unit.module and unit.module not in found:
            yield f"{manager} does not find module {unit.module}"
    if not unit.why_not and unit.places and variable in model.desired:
        fits = [place for place in unit.places if model.allows(variable, place)]
        if not fits and not model.allows(variable, ABSENT):
            yield f"{name} can only be at {' or '.join(unit.places)}"
    missing = [m for m in unit.members if m not in model.units]
    if missing:
        yield f"{name} is composed of {missing[0]}, which there is not"
