"""Keeps the last events of a core, bounded in number and size, with the state that they began in.

The ring has two halves, each beginning with a checkpoint. When the newer half is full and the core
is at rest, the older one goes: what is left always begins at a state, so it can be replayed.

See decision 48.
"""

from __future__ import annotations

import marshal
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rtkit.deployment.limits import Capacity
from rtkit.fast_dataclass import fields, is_record
from rtkit.manager.core.checkpoint import Checkpoint, copied, take
from rtkit.manager.core.core import Core
from rtkit.manager.core.events import ContainerReported, Event
from rtkit.manager.core.state import ManagerState

MOST_EVENTS = 4096
MOST_BYTES = 4 << 20
_EACH = 64
"""Memory that a value takes beside its characters, about [bytes]."""


CORE = "core"
"""The work in which a fault is the core's own: it comes again when it is replayed."""


class Fault(NamedTuple):
    """A fault of the manager's own: the work in which it was, and the exception with its place."""

    work: str
    error: str
    trace: str = ""


Item = Event | Capacity | Fault
"""An event; what the core found the host to have meanwhile; or a fault."""


class Recording(NamedTuple):
    """The content of a ring at one moment.

    Attributes:
        start: Where it begins; None when the core was not at rest for as long as the ring reaches.
        items: With the monotonic time of each [s].
        end: The state after all of them.
        lost: How many events there were before.
    """

    start: Checkpoint | None
    items: Sequence[tuple[float, Item]]
    end: ManagerState
    lost: int


class _Packed(NamedTuple):
    """A report of a container in few bytes, which nobody changes."""

    key: int
    message: bytes


class _Half:
    """A checkpoint, or None when its first events had to go; and events with their sizes."""

    def __init__(self, start: Checkpoint | None) -> None:
        self.start = start
        self.items: deque[tuple[float, Item | _Packed, int]] = deque()
        self.size = 0

    def is_full(self, events: int, size: int) -> bool:
        """Return whether it holds half of so many events or bytes."""
        return 2 * len(self.items) >= events or 2 * self.size >= size


class EventRing:
    """The last events of a core; it is told of each before the core is."""

    def __init__(
        self, core: Core, most_events: int = MOST_EVENTS, most_bytes: int = MOST_BYTES
    ) -> None:
        self._core = core
        self._most = (most_events, most_bytes)
        self._older: _Half | None = None
        self._newer = _Half(None)  # it begins with the first event: the shell completes the state
        self._lost = 0
        self._now = 0.0
        measure = core.state.capacity

        def measured() -> Capacity:
            capacity = measure()
            self._add(capacity)
            return capacity

        core.state.capacity = measured

    @property
    def size(self) -> tuple[int, int]:
        """Return how many events are held, and about how many bytes."""
        halves = [half for half in (self._older, self._newer) if half is not None]
        return sum(len(half.items) for half in halves), sum(half.size for half in halves)

    def record(self, event: Event, now: float) -> None:
        """Keep an event that the core is to take at monotonic time `now` [s]."""
        self._now = now
        newer = self._newer
        if (newer.start is None or newer.is_full(*self._most)) and self._core.is_at_rest:
            self._drop_older()
            self._older, self._newer = newer, _Half(take(self._core))
        self._add(event)

    def note(self, fault: Fault) -> None:
        """Keep a fault, among the events."""
        self._add(fault)

    def capture(self) -> Recording:
        """Return what is held now."""
        older, newer = self._older, self._newer
        if newer.start is None and not newer.items and self._core.is_at_rest:
            newer.start = take(self._core)
        halves = [newer] if older is None or older.start is None else [older, newer]
        skipped = len(older.items) if older is not None and len(halves) == 1 else 0
        return Recording(
            halves[0].start,
            [(now, _unpacked(item)) for half in halves for now, item, _ in half.items],
            copied(self._core.state),
            self._lost + skipped,
        )

    def about(self, instance: str) -> Callable[[], Iterator[tuple[float, Item]]]:
        """Return what yields the events that may be about an instance, safe on any thread."""
        halves = [half for half in (self._older, self._newer) if half is not None]
        items = [(now, item) for half in halves for now, item, _ in half.items]
        name = instance.encode()

        def unpacked() -> Iterator[tuple[float, Item]]:
            for now, item in items:
                if not isinstance(item, _Packed):
                    yield now, item
                elif name in item.message:
                    yield now, _unpacked(item)

        return unpacked

    def _add(self, item: Item) -> None:
        packed, size = _packed(item)
        newer, older = self._newer, self._older
        newer.items.append((self._now, packed, size))
        newer.size += size
        events, held = self._most
        if older is not None:
            is_over = len(older.items) + len(newer.items) > events
            if is_over or older.size + newer.size > held:
                self._drop_older()
        while len(newer.items) > events or (newer.size > held and len(newer.items) > 1):
            newer.size -= newer.items.popleft()[2]
            newer.start = None
            self._lost += 1

    def _drop_older(self) -> None:
        if self._older is not None:
            self._lost += len(self._older.items)
            self._older = None


def _packed(item: Item) -> tuple[Item | _Packed, int]:
    if type(item) is ContainerReported:
        try:
            data = marshal.dumps(dict(item.message))
        except ValueError:  # it came from this process, and has something that JSON lacks
            return item, _size(item)
        return _Packed(item.key, data), len(data) + _EACH
    return item, _size(item)


def _unpacked(item: Item | _Packed) -> Item:
    if isinstance(item, _Packed):
        return ContainerReported(item.key, marshal.loads(item.message))
    return item


def _size(value: Any) -> int:
    """Return about how many bytes a value takes."""
    kind = type(value)
    if kind is str:
        return _EACH + len(value)
    if kind is int or kind is float or kind is bool or value is None:
        return _EACH
    if isinstance(value, Mapping):
        return _EACH + sum(_size(key) + _size(item) for key, item in value.items())
    if isinstance(value, (list, tuple)):
        return _EACH + sum(map(_size, value))
    if is_record(type(value)):
        return _EACH + sum(_size(getattr(value, field.name)) for field in fields(value))
    return _EACH
