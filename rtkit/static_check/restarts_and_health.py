"""Checks the restart policies, health rules, limits and states that a system profile states."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

from rtkit.deployment.described import properties_of
from rtkit.deployment.extension import CREATE, SLAVE_RESTART, STATE_CHART, STATES, is_policy
from rtkit.deployment.health import read_rules
from rtkit.deployment.limits import read_limits
from rtkit.deployment.states.machine import machine_of
from rtkit.deployment.supervision import read_policy, restart_of
from rtkit.errors import Malformed
from rtkit.report.finding import ERROR, WARNING
from rtkit.rtc.create import parse_create
from rtkit.static_check.finding import TOP, StaticFinding
from rtkit.static_check.view import View, property_place


def restart_findings(view: View) -> Iterator[StaticFinding]:
    """Yield properties of supervision, and states, that make no sense."""
    for part in view.parts:
        for number, each in enumerate(part.component.properties):
            if is_policy(each.name):
                told = {each.name: each.value or ""}
                try:
                    read_policy(told)
                    read_rules(told)
                    read_limits(told)
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
    texts = (properties_of(part.component.properties).get(CREATE, "") for part in view.parts)
    found = set()
    for text in filter(None, texts):
        with suppress(Malformed):  # reported by another rule
            found.add(parse_create(text).place)
    return found


def _states(view: View) -> Iterator[StaticFinding]:
    """Yield what is wrong with states; those of a state chart are checked when it is read."""
    profile = view.profile
    told = properties_of(profile.properties)
    if STATE_CHART in told:
        return
    sets = {c.instance_name: [s.id for s in c.configuration_sets] for c in profile.components}
    try:
        machine_of(told, sets)
    except Malformed as error:
        named = property_place(TOP, profile.properties, STATES)
        where, text = named if named is not None else (TOP, None)
        yield StaticFinding(ERROR, "system-states", str(error), where, text)
