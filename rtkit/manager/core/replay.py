"""Replays a recording: what the core does at each event, and whether it ends as the manager did."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from rtkit.deployment.limits import Capacity
from rtkit.errors import Malformed, Refused, RtkitError
from rtkit.manager.core import checkpoint
from rtkit.manager.core.dump import to_plain
from rtkit.manager.core.event_ring import CORE, Fault, Item, Recording
from rtkit.manager.core.events import Event, Instruction


class ReplayedEvent(NamedTuple):
    """An event with what the core did at it, or a fault that the manager noted.

    Attributes:
        error: Error of the core; a report that cannot be read is refused so, too.
        is_bug: That is a fault of its own.
    """

    at: float
    item: Item
    instructions: tuple[Instruction, ...] = ()
    error: str = ""
    is_bug: bool = False


class Replay:
    """Replays one recording, step by step.

    Attributes:
        differences: In what way it went otherwise than in the manager; complete after `steps`.
    """

    def __init__(self, recording: Recording) -> None:
        """Prepare.

        Raises:
            Refused: The recording has no state to begin with.
            Malformed: It is not what a core of this version takes.
        """
        if recording.start is None:
            raise Refused(
                "cannot be replayed: the manager was not at rest for as long as its ring reaches"
            )
        self._recording = recording
        self._core = checkpoint.restored(recording.start)
        self._capacities: list[Capacity] = []
        self._core.state.capacity = self._capacity
        self.differences: list[str] = []

    @property
    def state(self) -> Any:
        """Return the state as it is now."""
        return self._core.state

    def steps(self) -> Iterator[ReplayedEvent]:
        """Yield what is done at each event."""
        items = self._recording.items
        for index, (at, item) in enumerate(items):
            if isinstance(item, Capacity):
                continue  # it was taken with the event before
            if isinstance(item, Fault):
                yield ReplayedEvent(at, item)
                continue
            if not isinstance(item, Event):
                raise Malformed(f"neither an event nor a fault: {type(item).__name__}")
            self._capacities = list(_capacities(items, index + 1))
            yield self._step(at, item, _fault_behind(items, index + 1))
        self.differences += differences(to_plain(self._recording.end), to_plain(self._core.state))

    def _step(self, at: float, event: Event, noted: Fault | None) -> ReplayedEvent:
        done: tuple[Instruction, ...] = ()
        error, is_bug = "", False
        try:
            done = tuple(self._core.handle(event, at))
        except RtkitError as refusal:
            error = str(refusal)
        except Exception as bug:  # whatever it is, it is what was to be found
            error, is_bug = described(bug), True
        was = noted.error if noted is not None else ""
        if was != (error if is_bug else ""):
            self.differences.append(
                f"{type(event).__name__}: raises {error or 'nothing'}, raised {was or 'nothing'}"
            )
        return ReplayedEvent(at, event, done, error, is_bug)

    def _capacity(self) -> Capacity:
        return self._capacities.pop(0) if self._capacities else Capacity()


def described(error: BaseException) -> str:
    """Return an exception in one line."""
    return f"{type(error).__name__}: {error}"


def differences(was: Any, now: Any, path: str = "state", most: int = 20) -> list[str]:
    """Return where two plain values differ, one line each, the first `most` of them."""
    if isinstance(was, dict) and isinstance(now, dict):
        found: list[str] = []
        for key in [*was, *(key for key in now if key not in was)]:
            below = f"{path}.{key}"
            found += differences(was.get(key), now.get(key), below, most - len(found))
            if len(found) >= most:
                break
        return found
    return [] if was == now else [f"{path}: is {now!r}, was {was!r}"]


def _capacities(items: Any, index: int) -> Iterator[Capacity]:
    while index < len(items) and isinstance(items[index][1], Capacity):
        yield items[index][1]
        index += 1


def _fault_behind(items: Any, index: int) -> Fault | None:
    """Return the fault of the core that was noted right behind an event."""
    while index < len(items) and isinstance(items[index][1], (Capacity, Fault)):
        item = items[index][1]
        if isinstance(item, Fault) and item.work == CORE:
            return item
        index += 1
    return None
