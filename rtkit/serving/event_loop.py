"""Event loop that owns the properties of a process: its sockets, calls of other threads, time.

A thread that touches a service holds the lock of the host; user code runs on workers. Who changes
a value sends its events as well: to wake the loop for that takes longer than to send them.
"""

from __future__ import annotations

import select
import socket
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

from rtkit.guard import GuardedResult, guarded
from rtkit.link.wakeup import Wakeup
from rtkit.property.access import AccessPolicy
from rtkit.property.codes import PropertyError
from rtkit.serving.dedicated_worker import DedicatedWorker, DedicatedWorkers, WorkerExit
from rtkit.serving.provider import PropertyProvider
from rtkit.serving.workers import Workers

POLL_S = 0.02
"""How often a computed value is read anew while it has listeners."""
_HOUSEKEEPING_S = 0.25
_LONGEST_WAIT_S = 3600.0


class ByteStream(Protocol):
    """Socket or device that the loop can wait for, read and write."""

    def fileno(self) -> int:
        """Return its descriptor."""

    def setblocking(self, flag: bool, /) -> None:
        """Wait in `recv` and `send`, or raise BlockingIOError."""

    def recv(self, size: int, /) -> bytes:
        """Return what has come, nothing at its end."""

    def send(self, data: bytes | bytearray | memoryview, /) -> int:
        """Send as much as the receiver takes; return how much that was."""

    def close(self) -> None:
        """Be open no longer."""


class IOHandler(ABC):
    """Handler that the loop serves: of a socket, or of none, which is flushed when it is marked."""

    _host: PropertyEventLoop

    def wake(self) -> None:
        """Have the loop flush it."""
        self._host.mark(self)

    def ready(self, mask: int) -> bool | None:  # noqa: B027  not all have a socket
        """Read or write the ready socket; return True if nothing is left to do."""

    @abstractmethod
    def flush(self, now: float) -> float | None:
        """Send what is due; return when something will be, None if nothing is to come."""

    def check(self, now: float) -> None:  # noqa: B027  not all wait for somebody
        """Look whether the far side takes too long."""


class PropertyEventLoop:
    """Services of one process, and the one thread that owns them.

    Attributes:
        services: By name.
        lock: To be held by who touches a service.
        policy: Access rules of each endpoint.
        user_code: Calls what is not ours.
    """

    def __init__(self, policy: AccessPolicy | None = None) -> None:
        self.policy = policy or AccessPolicy()
        self.services: dict[str, PropertyProvider] = {}
        self.lock = threading.Lock()
        self.user_code = Workers(self.lock, self.post)
        self._workers = DedicatedWorkers(self.lock)
        self._epoll = select.epoll()
        self._wakeup = Wakeup()
        self._epoll.register(self._wakeup, select.EPOLLIN)
        self._posted: deque[Callable[[], object]] = deque()
        self._dirty: set[IOHandler] = set()
        self._handlers: dict[int, IOHandler] = {}
        self._sockets: dict[int, ByteStream] = {}
        self._attended: dict[int, int] = {}
        self._is_woken = self._is_changing = False
        self._is_ended = threading.Event()
        self._housekeeping_at = 0.0
        self._poll_at = 0.0
        self._thread = threading.Thread(target=self.run, name="properties", daemon=True)
        self._closers: list[Callable[[], object]] = []

    def start(self) -> None:
        """Begin to serve, on a thread of its own."""
        self._thread.start()

    def add(self, service: PropertyProvider) -> None:
        """Serve a service.

        Raises:
            PropertyError: ``conflict``: there is one of that name.
        """
        if service.name in self.services:
            raise PropertyError("conflict", f"exists: service {service.name}")
        self.services[service.name] = service

    def at_end(self, closer: Callable[[], object]) -> None:
        """Register a function to call when the host closes; the last one first."""
        self._closers.append(closer)

    def post(self, work: Callable[[], object]) -> None:
        """Run a function on the loop, soon; from any thread."""
        self._posted.append(work)
        self.wake()

    def call(self, work: Callable[[], Any]) -> Any:
        """Run a function on the loop, and wait for it; return what it does, raise what it does."""
        done = threading.Event()
        outcomes: list[GuardedResult] = []

        def run() -> None:
            outcomes.append(guarded(work))
            done.set()

        self.post(run)
        done.wait()
        if outcomes[0].error is not None:
            raise outcomes[0].error
        return outcomes[0].result

    @property
    def has_posted(self) -> bool:
        """Return whether something waits for the loop that was posted earlier."""
        return bool(self._posted)

    def wake(self) -> None:
        """Wake the loop to check for work; from any thread."""
        if not self._is_woken:
            self._is_woken = True
            self._wakeup.ring()

    # Sockets

    def register(self, end: ByteStream, handler: IOHandler) -> None:
        """Serve a socket; on the loop's thread, or before it runs."""
        number = end.fileno()
        self._handlers[number] = handler
        self._sockets[number] = end
        self._epoll.register(number, select.EPOLLIN)

    def await_room(self, end: ByteStream, *, reads: bool, writes: bool) -> None:
        """Wait until a socket can be read, or be written to, or for neither of them."""
        mask = (select.EPOLLIN if reads else 0) | (select.EPOLLOUT if writes else 0)
        number = end.fileno()
        if number in self._attended:
            self._attended[number] = mask
        else:
            self._epoll.modify(number, mask)

    def unregister(self, end: ByteStream, handler: IOHandler) -> None:
        """Serve a socket no longer."""
        number = end.fileno()
        if self._handlers.pop(number, None) is not None:
            del self._sockets[number]
            if self._attended.pop(number, None) is None:
                self._epoll.unregister(number)
        self._dirty.discard(handler)

    def attend(
        self,
        end: ByteStream,
        data: bytes,
        answer: Callable[[bytes], bytes | None],
        back: Callable[[WorkerExit], object],
    ) -> bool:
        """Hand a client to a dedicated worker; return whether one is free. On the loop's thread.

        Args:
            end: Its socket.
            data: What came and is not answered.
            answer: Returns what is to be sent for what came, None to have the client back; it is
                called with the lock, and lets go of it while code of users runs.
            back: Takes the client back; on the loop's thread.
        """
        if not (isinstance(end, socket.socket) and self._workers.is_any_free):
            return False

        def take_back(left: WorkerExit) -> None:
            number = end.fileno()
            if number < 0:
                return  # it was closed meanwhile
            end.setblocking(False)
            self._epoll.register(number, self._attended.pop(number))
            back(left)

        worker = DedicatedWorker(end, answer, lambda left: self.post(lambda: take_back(left)))

        def take_from_it() -> None:
            worker.dismiss()
            take_back(WorkerExit())

        def run() -> None:
            with self.user_code.called_here(take_from_it):
                worker.attend(self.lock, data)

        self._epoll.unregister(end.fileno())
        self._attended[end.fileno()] = select.EPOLLIN
        self._workers.begin(worker, end, run)
        return True

    def mark(self, handler: IOHandler) -> None:
        """Note that a handler has something to send; called under the lock."""
        self._dirty.add(handler)
        if not self._is_changing:
            self.wake()

    def change(self, work: Callable[[], object]) -> None:
        """Change a service, and send the events of that, all on this thread, which is any.

        Args:
            work: It lets nobody else in, as a call of user code by the service would.
        """
        with self.lock:
            self._is_changing = True
            try:
                work()
            finally:
                self._is_changing = False
                if self._dirty:
                    self._flush(time.monotonic())
                if self._dirty:
                    self.wake()  # what is due later, or waits until its receiver takes it

    # The loop

    def run(self) -> None:
        """Serve until the host is closed."""
        wait_s: float | None = 0.0
        tidy_at = 0.0
        own = self._wakeup.fileno()
        poll, handlers, lock = self._epoll.poll, self._handlers, self.lock
        while not self._is_ended.is_set():
            ready = poll(wait_s)
            with lock:
                is_quiet = bool(ready)
                for number, mask in ready:
                    handler = handlers.get(number)
                    if handler is not None:
                        is_quiet = bool(handler.ready(mask)) and is_quiet
                    elif number == own:
                        is_quiet = False
                        self._wakeup.hush()
                        # Only now: an earlier wake-up is lost, but its work has been posted.
                        self._is_woken = False
                now = time.monotonic()
                if is_quiet and not (self._dirty or self._posted) and now < tidy_at:
                    # Requests that were answered at once, as most are: all else is as it was.
                    wait_s = tidy_at - now
                    continue
                while self._posted:
                    self._posted.popleft()()
                wait_s = self._tidy(now)
                tidy_at = now if wait_s is None else now + wait_s

    def _tidy(self, now: float) -> float | None:
        """Send, poll, end leases; return how long there is nothing to do [s]."""
        times = []
        if self._poll(now):
            times.append(self._poll_at)
        look_at = self.user_code.check(now)
        if look_at is not None:
            times.append(look_at)
        if self._dirty:
            times += self._flush(now)
        if self._handlers or self.services:
            if now >= self._housekeeping_at:
                self._keep_house(now)
            times.append(self._housekeeping_at)
        return max(0.0, min(min(times) - now, _LONGEST_WAIT_S)) if times else None

    def _flush(self, now: float) -> list[float]:
        """Flush the handlers that have something due; return when something will be."""
        times: list[float] = []
        waiting, self._dirty = self._dirty, set()
        for handler in waiting:
            due = handler.flush(now)
            if due is not None:
                self._dirty.add(handler)
                times.append(due)
        return times

    def _keep_house(self, now: float) -> None:
        self._housekeeping_at = now + _HOUSEKEEPING_S
        for handler in list(self._handlers.values()):
            handler.check(now)
        for service in self.services.values():
            service.tick()

    def _poll(self, now: float) -> bool:
        """Read anew what is computed, when it is time to; return whether there is any."""
        polled = [each for each in self.services.values() if each.is_polled]
        if polled and now >= self._poll_at:
            self._poll_at = now + POLL_S
            for service in polled:
                service.poll()
        return bool(polled)

    def close(self) -> None:
        """Serve nothing any more, and forget all connections."""
        if self._is_ended.is_set():
            return
        # The loop goes first: it must not meet what has been closed.
        self._is_ended.set()
        self._is_woken = False
        self.wake()
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join()
        self.user_code.close()
        while self._closers:
            self._closers.pop()()
        self._workers.close()
        for end in self._sockets.values():
            end.close()
        self._wakeup.close()
        self._epoll.close()
