"""Edits configuration sets: each function returns the component that comes of it."""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.fast_dataclass import replace
from rtkit.profile import rts_model as rts
from rtkit.rtc.nearest import did_you_mean


def configured(
    component: rts.ComponentInstance, name: str, values: Mapping[str, str | None]
) -> rts.ComponentInstance:
    """Return a component with other values in one of its sets; None takes a parameter out.

    Raises:
        NotFound: It has no such set.
    """
    number = _set_number(component, name)
    known = component.configuration_sets[number]
    data = [
        replace(each, data=values.get(each.name)) if each.name in values else each
        for each in known.data
        if values.get(each.name, "") is not None
    ]
    listed = {each.name for each in known.data}
    data += [
        rts.ConfigurationData(each, value)
        for each, value in values.items()
        if each not in listed and value is not None
    ]
    sets = list(component.configuration_sets)
    sets[number] = replace(known, data=tuple(data))
    return replace(component, configuration_sets=tuple(sets))


def with_set(component: rts.ComponentInstance, name: str, source: str) -> rts.ComponentInstance:
    """Return a component with one set more, a copy of another one if that is named.

    Raises:
        NotFound: There is no set to copy.
        Refused: It has a set of that name.
        Malformed: No set can have that name.
    """
    if not name.strip():
        raise Malformed("a configuration set needs a name")
    if any(each.id == name for each in component.configuration_sets):
        raise Refused(f"{component.instance_name} has a set {name} already")
    data = component.configuration_sets[_set_number(component, source)].data if source else ()
    made = rts.ConfigurationSet(name, data)
    active = component.active_configuration_set or name
    return replace(
        component,
        configuration_sets=(*component.configuration_sets, made),
        active_configuration_set=active,
    )


def without_set(component: rts.ComponentInstance, name: str) -> rts.ComponentInstance:
    """Return a component without one of its sets.

    Raises:
        NotFound: It has no such set.
        Refused: It is the active one.
    """
    number = _set_number(component, name)
    if component.active_configuration_set == name:
        raise Refused(f"{name} is the active set: make another one active first")
    sets = component.configuration_sets
    return replace(component, configuration_sets=(*sets[:number], *sets[number + 1 :]))


def with_active_set(component: rts.ComponentInstance, name: str) -> rts.ComponentInstance:
    """Return a component with another active set.

    Raises:
        NotFound: It has no such set.
    """
    _set_number(component, name)
    return replace(component, active_configuration_set=name)


def _set_number(component: rts.ComponentInstance, name: str) -> int:
    names = [each.id for each in component.configuration_sets]
    if name not in names:
        hint = did_you_mean(name, names)
        raise NotFound(f"{component.instance_name} has no configuration set {name}{hint}")
    return names.index(name)
