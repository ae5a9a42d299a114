"""Stops what another thread waits for, as an interruption does in the main thread."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock


class Stopped(KeyboardInterrupt):
    """Another thread had this one stopped; handled as an interruption is."""


class StopRequest:
    """One request to stop, from any thread; each wait within `heeding` ends."""

    def __init__(self) -> None:
        from rtkit.link.wakeup import Wakeup  # commands check, but request no stop

        self._wakeup = Wakeup()
        self._lock = Lock()
        self._is_rung = self._is_taken = False
        self._calls: list[Callable[[], object]] = []

    def fileno(self) -> int:
        """Return a descriptor that turns readable when it is rung."""
        return self._wakeup.fileno()

    def ring(self) -> None:
        """Have whoever waits stop; only the first time has an effect."""
        with self._lock:
            self._is_rung = True
            calls = [*self._calls]
        self._wakeup.ring()
        for call in calls:
            call()

    def take(self) -> bool:
        """Return whether it was rung, once: an orderly end that follows is left to end."""
        if self._is_rung and not self._is_taken:
            self._is_taken = self._wakeup.hush()
            return True
        return False

    def close(self) -> None:
        """Free the descriptor."""
        self._wakeup.close()

    @contextmanager
    def calling(self, wake: Callable[[], object]) -> Iterator[None]:
        """Have a function called when it is rung, as long as the context lasts."""
        with self._lock:
            self._calls.append(wake)
            is_late = self._is_rung and not self._is_taken
        if is_late:
            wake()
        try:
            yield
        finally:
            with self._lock:
                self._calls.remove(wake)


_STOP: ContextVar[StopRequest | None] = ContextVar("rtkit.stop", default=None)


def heed(stop: StopRequest | None) -> None:
    """Have calls in this context heed a request to stop."""
    _STOP.set(stop)


def check() -> None:
    """Raise if a stop was requested since.

    Raises:
        Stopped: It was.
    """
    stop = _STOP.get()
    if stop is not None and stop.take():
        raise Stopped


def descriptors() -> list[int]:
    """Return what turns readable when a stop is requested, for whoever polls."""
    stop = _STOP.get()
    return [stop.fileno()] if stop is not None else []


@contextmanager
def waking(wake: Callable[[], object]) -> Iterator[None]:
    """Have a waiting woken when a stop is requested; it has to `check` then."""
    stop = _STOP.get()
    if stop is None:
        yield
        return
    with stop.calling(wake):
        yield
