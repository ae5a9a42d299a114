"""Who asks through a door and may listen there, as much as there is room for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.property.listening import Listener
from rtkit.property.messages import Caller

if TYPE_CHECKING:
    from rtkit.serving.room import Room


class Hearer(Caller):
    """A caller with listeners.

    Args:
        room: How much there is room for, and what may be done.
    """

    def __init__(self, room: Room, identity: str = "") -> None:
        super().__init__(identity)
        self.access = room.access
        self._room = room
        self._listeners: list[Listener] = []

    @property
    def listening(self) -> int:
        """How much it listens to."""
        return len(self._listeners)

    @property
    def has_pending(self) -> bool:
        """Whether an event waits to be sent."""
        return any(each.pending for each in self._listeners)

    def listen(self, listener: Listener) -> None:
        """See `Caller.listen`."""
        self._room.check_listeners(self.listening)
        self._listeners.append(listener)

    def unlisten(self, listener: Listener) -> None:
        """See `Caller.unlisten`."""
        if listener in self._listeners:
            self._listeners.remove(listener)
