"""Checks properties of rtkit in a profile: restarts, health, limits, placement, states.

A limit needs a slave, and this host has to have as much as all limits allow together.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import suppress

from rtkit.deployment.described import properties_of
from rtkit.deployment.extension import (
    CREATE,
    LIMIT,
    MOVABLE,
    PLACE,
    SLAVE_RESTART,
    STATE_CHART,
    STATES,
    is_policy,
)
from rtkit.deployment.health import read_rules
from rtkit.deployment.known_keys import odd_properties
from rtkit.deployment.limits import (
    NO_LIMITS,
    Capacity,
    SlaveLimits,
    limits_in,
    needs_slave,
    overbooked,
    read_limits,
)
from rtkit.deployment.owned import read_movable
from rtkit.deployment.placement.requirements import check_named, read_requirements, shared_slaves
from rtkit.deployment.states.machine import machine_of
from rtkit.deployment.supervision import read_policy, restart_of
from rtkit.errors import Malformed
from rtkit.report.finding import ERROR, WARNING
from rtkit.static_check.finding import TOP, ProfileLocation, StaticFinding
from rtkit.static_check.view import CheckedComponent, View, property_place


def restart_findings(view: View) -> Iterator[StaticFinding]:
    """Yield properties of supervision, and states, that make no sense."""
    for part in view.parts:
        for number, each in enumerate(part.component.properties):
            if is_policy(each.name) and not each.name.startswith(PLACE):
                stated = {each.name: each.value or ""}
                try:
                    read_policy(stated)
                    read_rules(stated)
                    read_limits(stated)
                except Malformed as error:
                    where = part.place.below("properties", number).at("value")
                    text = f"{part.name}: {error}"
                    yield StaticFinding(ERROR, "supervision", text, where, each.value)
    for number, each in enumerate(view.profile.properties):
        if each.name.startswith(SLAVE_RESTART):
            where = TOP.below("properties", number)
            try:
                restart_of(each.name, each.value or "")
            except Malformed as error:
                yield StaticFinding(ERROR, "supervision", str(error), where.at("value"), each.value)
            if each.name.removeprefix(SLAVE_RESTART) not in _slaves(view):
                text = f"no component is in such a slave: {each.name}"
                yield StaticFinding(WARNING, "supervision", text, where.at("name"), each.name)
    yield from _states(view)


def _slaves(view: View) -> set[str]:
    """Return the slaves in which components are made, as far as the profile states it."""
    return {part.create.place for part in view.parts if part.create.implementation_id}


def _states(view: View) -> Iterator[StaticFinding]:
    """Yield what is wrong with states; those of a state chart are checked when it is read."""
    profile = view.profile
    properties = properties_of(profile.properties)
    if STATE_CHART in properties:
        return
    sets = {c.instance_name: [s.id for s in c.configuration_sets] for c in profile.components}
    try:
        machine_of(properties, sets)
    except Malformed as error:
        named = property_place(TOP, profile.properties, STATES)
        where, text = named if named is not None else (TOP, None)
        yield StaticFinding(ERROR, "system-states", str(error), where, text)


def limit_remarks(
    view: View, capacity: Callable[[], Capacity] = Capacity
) -> Iterator[StaticFinding]:
    """Yield limits of components that no slave would have, and what is more than a host has."""
    found = {part.name: _limits(part) for part in view.parts}
    limited = {name: limits for name, limits in found.items() if limits}
    for part in view.parts:
        if part.name in limited and not _is_in_slave(part):
            named = property_place(part.place, part.component.properties, CREATE)
            where, text = named if named is not None else (part.place, None)
            yield StaticFinding(ERROR, "limits", needs_slave(part.name), where, text)
    why = overbooked(limited, capacity()) if limited else ""
    if why:
        yield StaticFinding(ERROR, "limits", why, TOP)


def _limits(part: CheckedComponent) -> SlaveLimits:
    """Return the limits of a component; none where they make no sense (another rule)."""
    own = properties_of(part.component.properties)
    stated = {key: value for key, value in own.items() if key.startswith(LIMIT)}
    with suppress(Malformed):
        return read_limits(stated) if stated else limits_in(own.get(CREATE, ""))
    return NO_LIMITS


def _is_in_slave(part: CheckedComponent) -> bool:
    create = part.create  # without a type how it is created is not stated here
    return not create.implementation_id or bool(create.place) or create.is_place_open


def property_remarks(view: View) -> Iterator[StaticFinding]:
    """Yield the properties that nobody heeds because they are misspelt or stand elsewhere."""
    for odd in odd_properties(view.profile):
        place = ProfileLocation(odd.steps).at("name")
        yield StaticFinding(WARNING, "unknown-property", odd.text, place, odd.key)


def placement_findings(view: View) -> Iterator[StaticFinding]:
    """Yield requirements about places, and policies of moving, that make no sense."""
    required = {}
    names = {part.name for part in view.parts}
    for part in view.parts:
        items = part.component.properties
        found = list(_bad_requirements(part, names))
        yield from found
        if not found and any(each.name.startswith(PLACE) for each in items):
            try:
                required[part.name] = read_requirements(properties_of(items))
            except Malformed as error:
                text = f"{part.name}: {error}"
                yield StaticFinding(ERROR, "placement", text, part.place)
    try:
        dict(shared_slaves(required, {part.name: part.create.place for part in view.parts}))
    except Malformed as error:
        yield StaticFinding(ERROR, "placement", str(error), TOP)


def _bad_requirements(part: CheckedComponent, names: Collection[str]) -> Iterator[StaticFinding]:
    for number, each in enumerate(part.component.properties):
        text = each.value or ""
        try:
            if each.name == MOVABLE:
                read_movable(part.name, text)
            elif each.name.startswith(PLACE):
                check_named(part.name, read_requirements({each.name: text}), names)
        except Malformed as error:
            where = part.place.below("properties", number).at("value")
            why = str(error) if each.name == MOVABLE else f"{part.name}: {error}"
            yield StaticFinding(ERROR, "placement", why, where, each.value)
