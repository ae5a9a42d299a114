"""Arguments of methods and accessors, as parameters of requests."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from rtkit.property.annotations import hints_of_function, spec_of
from rtkit.property.codes import PropertyError
from rtkit.property.conversion import to_value
from rtkit.property.fitting import from_value
from rtkit.property.members import Member, is_data
from rtkit.property.parameters import no_parameter
from rtkit.property.property_spec import RequestParameter
from rtkit.property.values import Value

Taken = Mapping[str, tuple[tuple[RequestParameter, ...], dict[str, Any]]]
"""Arguments of getter and setter, with the hints, by their names."""


def accepted(thing: object, member: Member, own: tuple[int, int] = (0, 1)) -> Taken:
    """Return what getter and setter take beside their own arguments, with hints, by their names."""
    found = {}
    for accessor, first in zip((member.getter, member.setter), own, strict=True):
        declared, hints = arguments_of(getattr(thing, accessor)) if accessor else (None, {})
        if declared is not None and declared[first:]:
            found[accessor] = (declared[first:], hints)
    return found


def declared_of(takes: Taken) -> tuple[RequestParameter, ...]:
    """Return what requests about a property may state, from what its accessors take."""
    return tuple({each.key: each for of in takes.values() for each in of[0]}.values())


def given_to(accessor: str, takes: Taken, given: dict[str, Value]) -> dict[str, Any]:
    """Return parameters of a request as arguments of an accessor.

    Raises:
        PropertyError: ``bad-parameter``: it takes no such.
    """
    known, hints = takes.get(accessor, ((), {}))
    named = {}
    for key, value in given.items():
        if all(each.key != key for each in known):
            raise no_parameter(accessor, key, (each.key for each in known))
        try:
            named[key] = from_value(value, hints.get(key), None)
        except PropertyError as error:
            raise PropertyError("bad-parameter", f"{key}: {error}") from None
    return named


def arguments_of(
    method: Callable[..., object],
) -> tuple[tuple[RequestParameter, ...] | None, dict[str, Any]]:
    """Return the arguments of a method, None if they are unknown or of any number."""
    try:
        parameters = inspect.signature(method).parameters.values()
    except (ValueError, TypeError):
        return None, {}
    hints = hints_of_function(method)
    if any(each.kind in (each.VAR_POSITIONAL, each.POSITIONAL_ONLY) for each in parameters):
        return None, {}
    named = [each for each in parameters if each.kind != each.VAR_KEYWORD]
    declared = tuple(_parameter(each, hints.get(each.name)) for each in named)
    return declared, hints


def _parameter(parameter: inspect.Parameter, hint: Any) -> RequestParameter:
    default = None
    if parameter.default is not parameter.empty:
        value = to_value(parameter.default) if is_data(parameter.default) else ()
        default = () if isinstance(value, bytes) else value
    spec = spec_of(hint, None, "rw", "")
    return RequestParameter(parameter.name, spec.type, default, spec.choices, spec=spec)
