"""Threads that components start by the classes of OpenRTM-aist, and a lock for these."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any


class Task:
    """Base of tasks: `svc` runs on a thread of its own from `activate` on."""

    def __init__(self) -> None:
        self._thread: threading.Thread | None = None

    def open(self, *_: Any) -> int:
        """Prepare."""
        return 0

    def close(self, flags: int = 0) -> int:
        """Clean up."""
        return 0

    def svc(self) -> int:
        """Do the work."""
        return 0

    def activate(self) -> None:
        """Begin, if it does not run."""
        if self._thread is None or not self._thread.is_alive():
            self._thread = threading.Thread(target=self.svc, daemon=True)
            self._thread.start()

    def wait(self) -> None:
        """Wait for its end."""
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()

    def finalize(self) -> None:
        """Forget its thread."""
        self._thread = None


class Async_t(Task):
    """Calls a function, with an object first, on a thread of its own."""

    def __init__(self, obj: Any, func: Callable[..., Any], *args: Any) -> None:
        super().__init__()
        self._call = (func, (obj, *args))
        self._is_finished = False

    def invoke(self) -> None:
        """Begin."""
        self.activate()

    def finished(self) -> bool:
        """Return whether the function has come back."""
        return self._is_finished

    def svc(self) -> int:
        """Call the function."""
        function, arguments = self._call
        try:
            function(*arguments)
        finally:
            self._is_finished = True
        return 0


Async_ref_t = Async_t


def Async_tInvoker(obj: Any, func: Callable[..., Any], *args: Any) -> Async_t:
    """Return what calls a function on a thread of its own."""
    return Async_t(obj, func, *args)


Async_ref_tInvoker = Async_tInvoker


class PeriodicTask(Task):
    """Calls a function again and again."""

    def __init__(self) -> None:
        super().__init__()
        self._call: Callable[[], Any] | None = None
        self._period_s = 0.0
        self._ended = threading.Event()
        self._goes_on = threading.Event()
        self._goes_on.set()

    def setTask(self, func: Any, *_: Any) -> bool:
        """Have a function called; return whether it can be."""
        self._call = func
        return callable(func)

    def setPeriod(self, period: float) -> None:
        """Set the time between two calls [s]."""
        self._period_s = float(period)

    def svc(self) -> int:
        """Call the function until `finalize`."""
        while not self._ended.wait(self._period_s):
            self._goes_on.wait()
            if self._call is not None:
                self._call()
        return 0

    def suspend(self) -> int:
        """Call it no more for a while."""
        self._goes_on.clear()
        return 0

    def resume(self) -> int:
        """Call it again."""
        self._goes_on.set()
        return 0

    def finalize(self) -> None:
        """End."""
        self._ended.set()
        self._goes_on.set()


class ScopedLock:
    """Holds a lock until it is deleted, or until the end of a `with` block."""

    def __init__(self, mutex: Any) -> None:
        self._mutex = mutex
        mutex.acquire()

    def __del__(self) -> None:
        if self._mutex is not None:
            self._mutex.release()

    def __enter__(self) -> ScopedLock:
        return self

    def __exit__(self, *_: object) -> None:
        mutex, self._mutex = self._mutex, None
        mutex.release()
