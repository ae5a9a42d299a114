"""Ring buffers of connectors: bounded queues, written by one thread and read by another.

`Ring` drops the oldest and never waits: its write is one append to a bounded deque. `AwaitedRing`
does so too, and wakes a reader that waits. `GuardedRing` takes a lock, for the policies that refuse
values or let their writer wait.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from threading import Condition, Lock
from typing import Generic, Protocol, TypeAlias, TypeVar

from rtkit.component.contexts.waiting import wait_for, waiting
from rtkit.component.ports.options import (
    BufferOptions,
    EmptyPolicy,
    FullPolicy,
    PortStatus,
    PushPolicy,
)

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)
Sink = Callable[[T], PortStatus | None]
"""Takes one value; returns None on success, else the status that tells the reason."""
Source = Callable[[], T | None]
"""Gives the next value, or None when there is none."""


class Receiving(Protocol):
    """Receives values in place of the thread that does so else (see `BufferFeed`)."""

    def receive(self, timeout_s: float) -> bool:
        """Have the next value written to the buffer; False when none comes in time [s]."""

    def leave(self) -> None:
        """Let the other thread receive again."""


class BufferFeed(Protocol):
    """The stream that fills a buffer from another process.

    A reader that waits receives by itself: a thread in between would have to be woken first.
    """

    def borrow(self) -> Receiving | None:
        """Return what receives on the calling thread; None when that is not possible now."""

    def sip(self) -> None:
        """Have what has come written to the buffer, if a reader had borrowed this and has gone."""


class Buffer(Protocol[T_co]):
    """The reading side of a connector's buffer."""

    def take(self) -> T_co | None:
        """Remove and return the oldest value, None when empty; never wait."""

    def wait(self) -> T_co | None:
        """Do the same, and wait for a value if the policy says so."""

    def close(self) -> None:
        """Accept no more values and wake whoever waits."""

    def __len__(self) -> int: ...


class Ring(Generic[T]):
    """A ring buffer that drops the oldest value when it is full.

    Attributes:
        write: Take one value; a bound `deque.append`, so as cheap as can be.
    """

    __slots__ = ("_items", "write")

    def __init__(self, length: int) -> None:
        self._items: deque[T] = deque(maxlen=length)
        self.write: Sink[T] = self._items.append

    def __len__(self) -> int:
        return len(self._items)

    @property
    def length(self) -> int:
        """Return the number of values that fit."""
        return self._items.maxlen or 0

    def take(self) -> T | None:
        """Remove and return the oldest value, None when empty."""
        try:
            return self._items.popleft()
        except IndexError:
            return None

    def wait(self) -> T | None:
        """Remove and return the oldest value, None when empty; this kind never waits."""
        return self.take()

    def close(self) -> None:
        """Do nothing: no reader waits here."""


class AwaitedRing(Generic[T]):
    """A ring buffer that drops the oldest value when it is full, and lets its reader wait.

    A condition would take about as long as all else that is done for a small value. No lock guards
    the buffer: each step is an atomic operation of a deque. A reader looks for a value once more
    after it has queued its wakeup, so it misses none.

    Attributes:
        length: The number of values that fit.
        lost: Values that were dropped.
        feed: What fills it, where its reader may receive by itself.
    """

    def __init__(self, options: BufferOptions) -> None:
        self.feed: BufferFeed | None = None
        self._items: deque[T] = deque(maxlen=options.length)
        self._wakeups: deque[Lock] = deque()
        self._timeout_s = options.read_timeout
        self._is_closed = False
        self.length = options.length
        self.lost = 0

    def __len__(self) -> int:
        if not self._items and self.feed is not None:
            self.feed.sip()
        return len(self._items)

    def write(self, value: T) -> PortStatus | None:
        """Take one value; return CONNECTION_LOST when it is closed, else None."""
        if self._is_closed:
            return PortStatus.CONNECTION_LOST
        items = self._items
        if len(items) == items.maxlen:
            self.lost += 1
        items.append(value)
        if self._wakeups:
            self._wake_readers()
        return None

    def take(self) -> T | None:
        """Remove and return the oldest value, None when empty."""
        if not self._items and self.feed is not None:
            self.feed.sip()
        return self._pop()

    def wait(self) -> T | None:
        """Remove and return the oldest value, after waiting for one if there is none."""
        value = self._pop() if self._items else None
        left_s = self._timeout_s
        while value is None and left_s > 0 and not self._is_closed:
            receiving = self.feed.borrow() if self.feed is not None else None
            if receiving is None:
                left_s, value = self._await_writer(left_s)
                continue
            try:
                left_s = wait_for(receiving.receive, left_s)
            finally:
                receiving.leave()
            value = self._pop()
        return value

    def _await_writer(self, left_s: float) -> tuple[float, T | None]:
        """Wait for another thread to write; return the rest of the time [s], and the value."""
        wakeup = Lock()
        wakeup.acquire()
        self._wakeups.append(wakeup)
        value = self._pop()  # a write before the append released no wakeup
        if value is None and not self._is_closed:
            left_s = wait_for(partial(_acquire, wakeup), left_s)
            value = self._pop()
        if self._wakeups:  # a release removes the wakeup from the queue
            with suppress(ValueError):
                self._wakeups.remove(wakeup)
        return left_s, value

    def _pop(self) -> T | None:
        try:
            return self._items.popleft() if self._items else None
        except IndexError:  # another thread took the last one
            return None

    def close(self) -> None:
        """Accept no more values and wake whoever waits."""
        self._is_closed = True
        self._wake_readers()

    def _wake_readers(self) -> None:
        try:
            while self._wakeups:
                self._wakeups.popleft().release()
        except IndexError:  # the last reader has left meanwhile
            return


def _acquire(lock: Lock, timeout_s: float) -> bool:
    return lock.acquire(timeout=timeout_s)


class GuardedRing(Generic[T]):
    """A ring buffer that may refuse values, or make writer or reader wait.

    Attributes:
        length: The number of values that fit.
        lost: Values that were dropped or refused.
    """

    def __init__(self, options: BufferOptions) -> None:
        self._options = options
        self._items: deque[T] = deque()
        self._changed = Condition()
        self._is_closed = False
        self.length = options.length
        self.lost = 0

    def __len__(self) -> int:
        return len(self._items)

    def write(self, value: T) -> PortStatus | None:
        """Take one value if the policy allows; return the status that refuses it otherwise."""
        with self._changed:
            if len(self._items) >= self._options.length:
                refused = self._make_room()
                if refused is not None:
                    self.lost += 1
                    return refused
            if self._is_closed:
                return PortStatus.CONNECTION_LOST
            self._items.append(value)
            self._changed.notify_all()
            return None

    def take(self) -> T | None:
        """Remove and return the oldest value, None when empty."""
        with self._changed:
            return self._pop()

    def wait(self) -> T | None:
        """Remove and return the oldest value, after waiting for one if the policy is block."""
        with self._changed:
            if self._options.empty_policy is EmptyPolicy.BLOCK and not self._items:
                with waiting(self._options.read_timeout):
                    self._changed.wait_for(
                        lambda: self._items or self._is_closed, self._options.read_timeout
                    )
            return self._pop()

    def close(self) -> None:
        """Accept no more values and wake whoever waits."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()

    def _pop(self) -> T | None:
        if not self._items:
            return None
        value = self._items.popleft()
        self._changed.notify_all()
        return value

    def _make_room(self) -> PortStatus | None:
        policy = self._options.full_policy
        if policy is FullPolicy.OVERWRITE:
            self._items.popleft()
            self.lost += 1
            return None
        if policy is FullPolicy.DO_NOTHING:
            return PortStatus.FULL
        with waiting(self._options.write_timeout):
            has_room = self._changed.wait_for(
                lambda: len(self._items) < self._options.length or self._is_closed,
                self._options.write_timeout,
            )
        return None if has_room else PortStatus.TIMEOUT


class Pulled(Generic[T]):
    """Represents the buffer at the other end of a pull connector: asks for values when read."""

    def __init__(self, source: Source[T]) -> None:
        self._source = source
        self._fetched: T | None = None

    def __len__(self) -> int:
        if self._fetched is None:
            self._fetched = self._source()
        return 0 if self._fetched is None else 1

    def take(self) -> T | None:
        """Return the next value that the other end gives, None when it has none."""
        value, self._fetched = self._fetched, None
        return self._source() if value is None else value

    def wait(self) -> T | None:
        """Do the same: any waiting is done at the other end."""
        return None

    def close(self) -> None:
        """Forget a value that was fetched."""
        self._fetched = None


AnyRing: TypeAlias = Ring[T] | AwaitedRing[T] | GuardedRing[T]


def make_ring(options: BufferOptions) -> AnyRing[T]:
    """Return the cheapest buffer that fulfils the options."""
    if options.full_policy is not FullPolicy.OVERWRITE:
        return GuardedRing(options)
    if options.empty_policy is EmptyPolicy.BLOCK:
        return AwaitedRing(options)
    return Ring(options.length)


def select(policy: PushPolicy, buffer: Buffer[T], skip_count: int = 0) -> list[T]:
    """Take from `buffer` the values to send now, in order.

    ``new`` takes all and sends the newest, ``all`` sends everything, ``fifo`` the oldest one,
    ``skip`` the last of each complete group of `skip_count` + 1; an incomplete one stays queued.
    """
    queued = len(buffer)
    if policy is PushPolicy.FIFO:
        return _take(buffer, min(queued, 1))
    if policy is PushPolicy.SKIP:
        group = skip_count + 1
        return _take(buffer, queued - queued % group)[skip_count::group]
    values = _take(buffer, queued)
    return values[-1:] if policy is PushPolicy.NEW else values


def _take(buffer: Buffer[T], count: int) -> list[T]:
    taken = (buffer.take() for _ in range(count))
    return [value for value in taken if value is not None]
