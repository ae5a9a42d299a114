"""Participant: one component in one execution context, with its state and work per cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.component.callbacks import overrides
from rtkit.component.lifecycle import ACTIVE, ERROR, INACTIVE
from rtkit.rtc.enums import LifeCycleState

if TYPE_CHECKING:
    from rtkit.component.base import Component


class Participant:
    """One component in one context.

    Attributes:
        handle: The id by which the component knows the context.
        reported: The last failure of on_error that was reported.
        executes: Whether it has an on_execute of its own; likewise `updates`, `handles_error`.
    """

    __slots__ = (
        "component",
        "executes",
        "handle",
        "handles_error",
        "reported",
        "state",
        "updates",
    )

    def __init__(self, component: Component, handle: str) -> None:
        self.component = component
        self.handle = handle
        self.state: LifeCycleState = INACTIVE
        self.reported = ""
        self.executes = overrides(component, "on_execute")
        self.updates = overrides(component, "on_state_update")
        self.handles_error = overrides(component, "on_error")

    @property
    def has_work(self) -> bool:
        """Return whether a cycle would call it."""
        if self.state is ACTIVE:
            return self.executes or self.updates
        return self.state is ERROR and self.handles_error
