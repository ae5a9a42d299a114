"""Subscribes to one manager: receives its deltas, and if wanted its metrics.

A bounded queue keeps the changes until they are taken. A slow subscriber loses the oldest, learns
how many it lost, and knows all the same what the manager knows now.
"""

from __future__ import annotations

import os
import select
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from threading import Lock
from time import monotonic
from typing import NamedTuple

from rtkit.closing import Closing
from rtkit.deployment.delta import TREE, Delta, FullSnapshot, LiveFacts, delta_between
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.metrics import METRICS, Metrics
from rtkit.deployment.user_events import UserEvent, user_events
from rtkit.errors import Unreachable
from rtkit.link.places import host_name
from rtkit.link.wakeup import Wakeup
from rtkit.rtc.serde import decode_text
from rtkit.tree.client import Tree

QUEUE = 4096
"""How many deltas a subscriber may be behind."""

_FIRST_DELTA_S = 0.5
_TRIES = 20


class TreeChange(NamedTuple):
    """A change of the tree.

    Attributes:
        time: When the manager sent it [s since 1970].
        lost: How many deltas were missed before; their content is found by comparison.
    """

    time: float
    user_events: tuple[UserEvent, ...]
    lost: int = 0


class SubscriptionEnded(NamedTuple):
    """End of a subscription: the manager is gone, and nothing comes after that.

    Attributes:
        is_orderly: The manager said so itself, and what it held has ended with it.
    """

    why: str
    is_orderly: bool = False


ManagerEvent = TreeChange | Metrics | SubscriptionEnded


class ManagerSubscription(Closing):
    """A subscription to one manager; leave it as a context manager.

    Attributes:
        tree: The connection to it.
    """

    def __init__(self, tree: Tree, lines: Iterable[str] = (TREE,)) -> None:
        """Begin to listen.

        Raises:
            Unreachable: The manager does not answer, or what it sends does not arrive.
        """
        self.tree = tree
        self._received: deque[tuple[str, str]] = deque(maxlen=QUEUE)
        self._lock = Lock()
        self._wakeup = Wakeup()
        self._process: int | None = None
        self._is_over = False
        self._was_found = self._is_lost = False
        self._ends: list[Callable[[], object]] = []
        try:
            for line in lines:
                self._ends.append(tree.listen(line, self._take_in(line)))
            snapshot = self._first_snapshot()
            self._run, self._number = snapshot.run, snapshot.number
            self._live = LiveFacts(snapshot.facts)
            if tree.host != host_name():  # there its pid is that of anybody here
                self._ends.append(tree.notice(self._note))
            else:
                with suppress(ProcessLookupError):
                    self._process = os.pidfd_open(self.facts.pid)
        except BaseException:
            self.close()
            raise

    @property
    def facts(self) -> Snapshot:
        """Facts of the manager, as of the change taken last."""
        with self._lock:  # another thread may take what has come
            return self._live.snapshot

    def close(self) -> None:
        """Listen no more."""
        while self._ends:
            self._ends.pop()()
        self._wakeup.close()
        if self._process is not None:
            os.close(self._process)
        self._process = None

    @property
    def sources(self) -> list[int]:
        """Descriptors of which one is readable when there is something to `take`."""
        wakeup = self._wakeup.fileno()
        return [wakeup] if self._process is None else [wakeup, self._process]

    def wait(self, timeout_s: float | None = None) -> list[ManagerEvent]:
        """Wait until something has come, and take it; empty when the time is up."""
        until = None if timeout_s is None else monotonic() + timeout_s
        while not self._is_over:
            left_s = None if until is None else max(0.0, until - monotonic())
            if not select.select(self.sources, [], [], left_s)[0]:
                break
            taken = self.take()
            if taken:
                return taken
        return []

    def take(self) -> list[ManagerEvent]:
        """Return what has come, in order; `facts` are then what they are after all of it."""
        self._wakeup.hush()
        events: list[ManagerEvent] = []
        while self._received and not self._is_over:
            line, text = self._received.popleft()
            if line == METRICS:
                events.append(decode_text(Metrics, text))
            else:
                events += self._delta(decode_text(Delta, text))
        if not self._is_over and self._is_gone():
            events.append(self._end("was killed"))
        elif not self._is_over and self._is_lost:
            events.append(self._end(f"of host {self.tree.host} was killed, or is cut off"))
        return events

    def _note(self, is_found: bool) -> None:
        """Note whether a manager of another host can be asked; at first routers may not know."""
        self._is_lost = self._was_found and not is_found
        self._was_found |= is_found
        self._wakeup.ring()

    def _delta(self, delta: Delta) -> list[ManagerEvent]:
        if delta.run == self._run and delta.number <= self._number:
            return []
        if delta.is_last:
            return [self._end("ends", is_orderly=True)]
        if (delta.run, delta.number) != (self._run, self._number + 1):
            return self._catch_up(delta)
        self._number = delta.number
        changes = tuple(user_events(self._live, delta))
        with self._lock:
            self._live.apply(delta)
        return [TreeChange(delta.time, changes)] if changes else []

    def _catch_up(self, delta: Delta) -> list[ManagerEvent]:
        """Derive the changes of missed deltas from a new snapshot."""
        lost = max(0, delta.number - self._number - 1) if delta.run == self._run else 0
        try:
            snapshot = self.tree.full_snapshot()
        except Unreachable as error:
            return [self._end(str(error))]
        missed = delta_between(self.facts, snapshot.facts, snapshot.run, snapshot.number)
        changes = tuple(user_events(self.facts, missed))
        self._run, self._number = snapshot.run, snapshot.number
        self._live = LiveFacts(snapshot.facts)
        return [TreeChange(delta.time, changes, lost)] if changes or lost else []

    def _end(self, why: str, *, is_orderly: bool = False) -> SubscriptionEnded:
        self._is_over = True
        return SubscriptionEnded(f"manager {self.tree.manager!r} {why}", is_orderly)

    def _is_gone(self) -> bool:
        return self._process is not None and bool(select.select([self._process], [], [], 0)[0])

    def _take_in(self, line: str) -> Callable[[str], object]:
        def take_in(text: str) -> None:
            self._received.append((line, text))
            self._wakeup.ring()

        return take_in

    def _first_snapshot(self) -> FullSnapshot:
        """Take a snapshot, again until deltas of the manager are seen to arrive."""
        for _ in range(_TRIES):
            snapshot = self.tree.full_snapshot()
            until = monotonic() + _FIRST_DELTA_S
            while not any(line == TREE for line, _ in self._received):
                if not select.select([self._wakeup], [], [], max(0.0, until - monotonic()))[0]:
                    break
                self._wakeup.hush()
            else:
                self._wakeup.ring()
                return snapshot
        raise Unreachable(f"what manager {self.tree.manager!r} tells does not arrive")
