"""Checks limits: each needs a slave, and this host has to have as much as all of them together."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress

from rtkit.deployment.described import properties_of
from rtkit.deployment.extension import CREATE, LIMIT
from rtkit.deployment.limits import (
    NO_LIMITS,
    Capacity,
    SlaveLimits,
    limits_in,
    needs_slave,
    overbooked,
    read_limits,
)
from rtkit.errors import Malformed
from rtkit.report.finding import ERROR
from rtkit.rtc.create import parse_create
from rtkit.static_check.finding import TOP, StaticFinding
from rtkit.static_check.view import CheckedComponent, View, property_place


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
    said = {key: value for key, value in own.items() if key.startswith(LIMIT)}
    with suppress(Malformed):
        return read_limits(said) if said else limits_in(own.get(CREATE, ""))
    return NO_LIMITS


def _is_in_slave(part: CheckedComponent) -> bool:
    text = properties_of(part.component.properties).get(CREATE, "")
    if not text:
        return True  # how it is created is not stated here
    try:
        create = parse_create(text)
    except Malformed:
        return True
    return bool(create.place or create.address or create.options.get("members"))
