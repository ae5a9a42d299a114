"""Finds options of a create string that its component does not know."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtkit.component.base import Component
from rtkit.rtc.nearest import did_you_mean
from rtkit.settings.options import CONF, unknown_options


def odd_options(component: Component, options: Mapping[str, str]) -> list[str]:
    """Return findings about options that resemble known ones, a line each.

    Others are properties of the component, which may ask for them.
    """
    return [*_parameters(component, options), *unknown_options(options)]


def _parameters(component: Component, options: Mapping[str, str]) -> Iterator[str]:
    """Yield options for parameters that the component does not have."""
    if component.is_stand_in or component.composite_type:
        return
    known = component.configuration.values
    for key in options:
        if not key.startswith(CONF):
            continue
        set_id, _, name = key.removeprefix(CONF).partition(".")
        if set_id and name and name not in known and not set_id.startswith("_"):
            hint = did_you_mean(name, known, 1)
            yield f"{component.instance} has no parameter {name}{hint}: {key}"
