"""Collects the facts that a process reports of a component."""

from __future__ import annotations

import time
from collections.abc import Sequence

from rtkit.component.base import Component
from rtkit.component.contexts.input_wait import wait_of
from rtkit.component.describe import describe
from rtkit.deployment.facts import ComponentFacts
from rtkit.rtc.enums import merged_state
from rtkit.rtc.profiles import ExecutionContextProfile


class DatedFacts:
    """Facts of the components of a process, with since when each is in its state."""

    def __init__(self) -> None:
        self._since: dict[str, tuple[str, float]] = {}

    def of(self, component: Component) -> ComponentFacts:
        """Return the facts of a component; name, place and origin are the manager's to add."""
        described = describe(component)
        return ComponentFacts(
            instance=component.instance,
            type=component.type,
            process="",
            is_stand_in=component.is_stand_in,
            since=self._date(component.instance, described.contexts),
            waits=wait_of(component.instance),
            **described._asdict(),
        )

    def forget(self, instance: str) -> None:
        """Forget a component that is no more."""
        self._since.pop(instance, None)

    def _date(self, instance: str, contexts: Sequence[ExecutionContextProfile]) -> float:
        """Return since when a component is in its state [s since 1970]: a new one, since now."""
        state = merged_state([context.state for context in contexts])
        known = self._since.get(instance)
        if known is None or known[0] != state:
            known = self._since[instance] = state, time.time()
        return known[1]
