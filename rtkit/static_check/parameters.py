"""Checks the configuration sets of a system against the parameters of the types."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtkit.component.configuration.constraint_check import Declared, hinted, misfit_of
from rtkit.deployment.described import sets_of
from rtkit.deployment.extension import CREATE
from rtkit.deployment.system import HIDDEN
from rtkit.errors import Malformed
from rtkit.profile.rts_model import ConfigurationData
from rtkit.report.finding import ERROR, WARNING
from rtkit.rtc.create import parse_create
from rtkit.static_check.blueprint import Blueprint, ParameterType
from rtkit.static_check.finding import ProfileLocation, StaticFinding
from rtkit.static_check.ports import listed
from rtkit.static_check.view import CheckedComponent, View, property_place

_DEFAULT = "default"
_OF_COMPOSITES = ("members", "exported_ports")


def parameter_findings(view: View) -> Iterator[StaticFinding]:
    """Yield active sets that are none, and parameters and values that a type cannot have."""
    for part in view.parts:
        yield from _active_set(part)
        yield from _create_string(part)
        hints = sets_of(part.component.configuration_sets)
        for number, each in enumerate(part.component.configuration_sets):
            if each.id.startswith(HIDDEN):
                continue
            place = part.place.below("configuration_sets", number)
            for position, data in enumerate(each.data):
                where = place.below("data", position)
                if part.blueprint is None:
                    yield from _hinted(part, hints, each.id, data, where)
                else:
                    yield from _parameter(part, part.blueprint, each.id, data, where)


def _active_set(part: CheckedComponent) -> Iterator[StaticFinding]:
    """Yield an active set that can be none, or is not among those that the system lists.

    A component may have sets that neither its profile nor the system speaks of.
    """
    active = part.component.active_configuration_set
    listed_sets = [each.id for each in part.component.configuration_sets]
    if not active or active == _DEFAULT or not (listed_sets or active.startswith("_")):
        return
    can_be = [name for name in listed_sets if not name.startswith("_")]
    if active in can_be:
        return
    is_hidden = active.startswith("_")
    text = f"{part.name}: configuration set {active} is active, but is not listed"
    if is_hidden:
        text = f"{part.name}: configuration set {active} is hidden and cannot be active"
    where = part.place.at("active_configuration_set")
    allowed = listed(dict.fromkeys((_DEFAULT, *can_be)))
    yield StaticFinding(
        ERROR if is_hidden else WARNING, "unknown-set", text, where, active, allowed
    )


def _create_string(part: CheckedComponent) -> Iterator[StaticFinding]:
    """Yield values in the create string of a component with which it would not be made."""
    stated = property_place(part.place, part.component.properties, CREATE)
    if stated is None or part.blueprint is None:
        return
    where, text = stated
    try:
        options = parse_create(text).options
    except Malformed as error:
        yield StaticFinding(ERROR, "create-string", f"{part.name}: {error}", where, text)
        return
    for key, value in options.items():
        head, _, name = key.rpartition(".")
        known = part.blueprint.parameters.get(name)
        set_id = head.removeprefix("conf.")
        if known is None or set_id == head or set_id.startswith(HIDDEN):
            continue
        why = misfit_of(known.declared, value)
        if why and value != known.default:
            yield _misfit(part, key, known, value, why, where)


def _hinted(
    part: CheckedComponent,
    hints: Mapping[str, Mapping[str, str]],
    set_id: str,
    data: ConfigurationData,
    place: ProfileLocation,
) -> Iterator[StaticFinding]:
    """Yield a value that violates what the system profile itself states of the parameter."""
    if data.data is None:
        return
    declared = hinted(hints, data.name)
    why = misfit_of(declared, data.data)
    if why:
        known = ParameterType(declared, "")
        found = _misfit(part, f"{set_id}.{data.name}", known, data.data, why, place.at("data"))
        yield found._replace(severity=WARNING)


def _parameter(
    part: CheckedComponent,
    blueprint: Blueprint,
    set_id: str,
    data: ConfigurationData,
    place: ProfileLocation,
) -> Iterator[StaticFinding]:
    known = blueprint.parameters.get(data.name)
    if known is None:
        if not (part.is_composite and data.name in _OF_COMPOSITES):
            text = f"{part.name} has no configuration parameter {data.name} (set {set_id})"
            names = listed(name for name in blueprint.parameters if not name.startswith(HIDDEN))
            yield StaticFinding(
                ERROR, "unknown-parameter", text, place.at("name"), data.name, names
            )
        return
    if data.data is None:
        return
    why = misfit_of(known.declared, data.data)
    if why:
        yield _misfit(part, f"{set_id}.{data.name}", known, data.data, why, place.at("data"))


def _misfit(
    part: CheckedComponent,
    name: str,
    known: ParameterType,
    value: str,
    why: str,
    place: ProfileLocation,
) -> StaticFinding:
    declared = known.declared
    is_type = bool(misfit_of(Declared(declared.type), value))
    rule = "parameter-type" if is_type else "parameter-constraint"
    stated = declared.rule if declared.rule in why else ""  # else its author's sentence is enough
    allowed = declared.type if is_type else stated
    text = f"{name} of {part.name} cannot be {value!r}: {why}"
    is_default = value == known.default and part.blueprint is not None
    if is_default:
        text += "; it is the default, which its own declaration forbids"
    severity = WARNING if is_default else ERROR
    return StaticFinding(severity, rule, text, place, value, allowed)
