"""Describes a component as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from rtkit.component.base import Component
from rtkit.component.values.typenames import type_name
from rtkit.fast_dataclass import replace
from rtkit.rtc.data_types import scoped_name
from rtkit.rtc.profiles import ExecutionContextProfile, PortProfile

CODE = "_rtkit_code"
"""Attribute of a component class that came from a file: its CRC-32 then, and where it is."""


class Description(NamedTuple):
    """Public description of a component, all of it plain data."""

    ports: tuple[PortProfile, ...]
    sets: Mapping[str, Mapping[str, str]]
    active_set: str
    contexts: tuple[ExecutionContextProfile, ...]
    cause: str
    composite_type: str
    members: tuple[str, ...]
    composite: str
    fsm_state: str = ""
    fsm_states: Mapping[str, Mapping[str, str]] = {}
    fsm_events: Mapping[str, str] = {}
    code: str = ""


def describe(component: Component) -> Description:
    """Return the present description of the component."""
    configuration = component.configuration
    return Description(
        ports=tuple(
            port.profile if name == port.name else replace(port.profile, name=name)
            for name, port in tuple(component.ports.items())
        ),
        sets={set_id: dict(values) for set_id, values in configuration.sets.items()},
        active_set=configuration.active_set,
        code=getattr(type(component), CODE, ""),
        contexts=tuple(context.profile_for(component) for context in component.participations),
        cause=component.cause,
        composite_type=component.composite_type,
        members=tuple(member.instance for member in component.member_components),
        composite=component.composite.instance if component.composite is not None else "",
        **_machine(component),
    )


def _machine(component: Component) -> dict[str, Any]:
    """Return the description of a state machine; nothing for a component without one."""
    if not component.has_machine:
        return {}
    from rtkit.component.fsm import FsmComponent

    if not isinstance(component, FsmComponent):
        return {}
    events = component.event_in.events
    return {
        "fsm_state": component.state,
        "fsm_states": component.machine.table,
        "fsm_events": {
            event: scoped_name(type_name(cls)) or "Any" for event, cls in events.items()
        },
    }
