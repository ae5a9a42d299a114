"""A component as facts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from rtkit.component.base import Component
from rtkit.rtc.profiles import ExecutionContextProfile, PortProfile


class Description(NamedTuple):
    """What others may know of a component, all of it plain data."""

    ports: tuple[PortProfile, ...]
    sets: Mapping[str, Mapping[str, str]]
    active_set: str
    contexts: tuple[ExecutionContextProfile, ...]
    cause: str
    composite_type: str
    members: tuple[str, ...]
    composite: str


def describe(component: Component) -> Description:
    """Return what the component is like now."""
    configuration = component.configuration
    return Description(
        ports=tuple(
            port.profile if name == port.name else replace(port.profile, name=name)
            for name, port in tuple(component.ports.items())
        ),
        sets={set_id: dict(values) for set_id, values in configuration.sets.items()},
        active_set=configuration.active_set,
        contexts=tuple(context.profile_for(component) for context in component.participations),
        cause=component.cause,
        composite_type=getattr(component, "composite_type", ""),
        members=tuple(member.instance for member in component.member_components),
        composite=component.composite.instance if component.composite is not None else "",
    )
