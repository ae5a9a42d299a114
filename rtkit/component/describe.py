"""A component as facts."""

from __future__ import annotations

from collections.abc import Mapping
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


def describe(component: Component) -> Description:
    """Return what the component is like now."""
    configuration = component.configuration
    return Description(
        ports=tuple(port.profile for port in tuple(component.ports.values())),
        sets={set_id: dict(values) for set_id, values in configuration.sets.items()},
        active_set=configuration.active_set,
        contexts=tuple(context.profile_for(component) for context in component.participations),
        cause=component.cause,
    )
