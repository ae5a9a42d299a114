"""Participant: one component in one execution context, with its state and work per cycle."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from rtkit.component.configuration.config import Configuration
from rtkit.component.contexts.callbacks import Failure, overrides
from rtkit.component.contexts.lifecycle import ACTIVE, ERROR, INACTIVE
from rtkit.rtc.enums import LifeCycleState


class DrivenComponent(Protocol):
    """Component as an execution context knows it; it also has all `callbacks.Callbacks`."""

    instance: str
    configuration: Configuration
    is_alive: bool
    cause: str
    report: Callable[[str], None]

    @property
    def composite(self) -> DrivenComponent | None:
        """The composite that it is a member of."""

    @property
    def member_components(self) -> tuple[DrivenComponent, ...]:
        """Its members, if it is a composite."""

    @property
    def has_changes(self) -> bool:
        """Return whether a value waits at some in port."""

    @property
    def read_count(self) -> int:
        """Values that were read from all in ports."""

    def take_part(self, context: Any) -> None:
        """Note the context that took it in."""

    def leave(self, context: Any) -> None:
        """Forget the context that let it go."""

    def takes_settings_from(self, context: object) -> bool:
        """Return whether settings wait that this context is to have it take over."""

    def keep_failure(self, callback: str, failure: Failure) -> None:
        """Keep and log the failure that led to Error."""


class Participant:
    """One component in one context.

    Attributes:
        handle: The id by which the component knows the context.
        reported: The last failure of on_error that was reported.
        executes: Whether it has an on_execute of its own; likewise `updates`, `handles_error`.
    """

    __slots__ = ("component", "executes", "handle", "handles_error", "reported", "state", "updates")

    def __init__(self, component: DrivenComponent, handle: str) -> None:
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
