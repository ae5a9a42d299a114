"""Collects the facts that a process reports of a component."""

from __future__ import annotations

from rtkit.component.base import Component
from rtkit.component.describe import describe
from rtkit.deployment.facts import ComponentFacts


def facts_of(component: Component) -> ComponentFacts:
    """Return the facts of a component; name, place and origin are the manager's to add."""
    described = describe(component)
    return ComponentFacts(
        instance=component.instance,
        type=component.type,
        process="",
        ports=described.ports,
        sets=described.sets,
        active_set=described.active_set,
        contexts=described.contexts,
        is_stand_in=component.is_stand_in,
        cause=described.cause,
        composite_type=described.composite_type,
        members=described.members,
        composite=described.composite,
        fsm_state=described.fsm_state,
        fsm_states=described.fsm_states,
        fsm_events=described.fsm_events,
        code=described.code,
    )
