"""Collects the facts that a process reports of a component."""

from __future__ import annotations

import time

from rtkit.component.base import Component
from rtkit.component.describe import describe
from rtkit.deployment.facts import ComponentFacts
from rtkit.fast_dataclass import replace


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


class DatedFacts:
    """Facts of the components of a process, with since when each is in its state."""

    def __init__(self) -> None:
        self._since: dict[str, tuple[str, float]] = {}

    def of(self, component: Component) -> ComponentFacts:
        """Return the facts of a component; its state changed at the latest now."""
        facts = facts_of(component)
        state, since = self._since.get(facts.instance, ("", 0.0))
        if facts.state != state:
            since = time.time()
            self._since[facts.instance] = facts.state, since
        return replace(facts, since=since)

    def forget(self, instance: str) -> None:
        """Forget a component that is no more."""
        self._since.pop(instance, None)
