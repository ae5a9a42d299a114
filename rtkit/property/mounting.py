"""Mount points: names of a service that stand for another owner, to whom requests are passed on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, Protocol

from rtkit.property.requests import PropertyRequest, Requester


class MountTable(Protocol):
    """All mount points of one service; callers hold the lock of its host."""

    def add(self, name: str, mount: MountPoint, is_there: Callable[[], bool]) -> None:
        """Pass on what is asked about a name, and about all below it, while the object has it."""

    def remove(self, name: str) -> None:
        """Pass nothing on any more; tell listeners there that it is gone."""

    def takes(self, ask: PropertyRequest, *, is_again: bool = False) -> bool:
        """Answer a request, now or later, if it is about what is mounted; return whether it is.

        Again only if that has come since the object was asked.
        """

    def tick(self) -> None:
        """End the leases that are over."""

    def forget(self, caller: Requester) -> None:
        """Send nothing any more to who is gone."""


class MountPoint(ABC):
    """Value of an attribute that stands for another owner.

    Attributes:
        target: Where that owner is.
        has_value: The name itself is the object's own; the owner has only what is below.
    """

    target: str
    has_value: bool = False

    @abstractmethod
    def table_for(self, service: Any) -> MountTable:
        """Return a table for the mount points of a `Service` that has had none."""
