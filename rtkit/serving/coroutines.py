"""Runs a loop of asyncio on a thread of its own, begun by the first coroutine of a service."""

from __future__ import annotations

import threading
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from rtkit.guard import GuardedResult

if TYPE_CHECKING:
    import asyncio


class Coroutines:
    """Awaits coroutines for threads that wait for their results."""

    def __init__(self) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None
        self._starting = threading.Lock()

    def run(
        self,
        coroutine: Coroutine[Any, Any, object],
        cancellable: Callable[[Callable[[], object]], object],
    ) -> object:
        """Await a coroutine; None if it is cancelled.

        Args:
            coroutine: Coroutine to await.
            cancellable: Is given what cancels it, from any thread.
        """
        import asyncio  # 39 ms, for services that have coroutine functions only
        from concurrent.futures import CancelledError

        loop, cancelled = self._started(), threading.Event()
        tasks: list[asyncio.Task[Any] | None] = []

        async def begun() -> GuardedResult:
            if cancelled.is_set():
                coroutine.close()
                raise asyncio.CancelledError
            tasks.append(asyncio.current_task())
            return await _shielded(coroutine)

        def cancel_all() -> None:
            for task in tasks:
                if task is not None:
                    task.cancel()

        def cancel() -> None:
            cancelled.set()
            # Not the future: its waiters are to wait until the coroutine has ended.
            with suppress(RuntimeError):  # the loop is closed, and all has ended
                loop.call_soon_threadsafe(cancel_all)

        future = asyncio.run_coroutine_threadsafe(begun(), loop)

        cancellable(cancel)
        try:
            outcome = future.result()
        except CancelledError:
            if cancelled.is_set():
                return None
            raise  # it has cancelled itself
        if outcome.error is not None:
            raise outcome.error
        return outcome.result

    def _started(self) -> asyncio.AbstractEventLoop:
        import asyncio

        with self._starting:
            if self._loop is None:
                self._loop = asyncio.new_event_loop()
                threading.Thread(target=self._serve, name="coroutines", daemon=True).start()
            return self._loop

    def _serve(self) -> None:
        assert self._loop is not None
        self._loop.run_forever()
        self._loop.run_until_complete(_end_all())
        self._loop.close()

    def close(self) -> None:
        """Cancel all that is awaited, and await nothing any more."""
        with self._starting:
            if self._loop is not None and self._loop.is_running():
                self._loop.call_soon_threadsafe(self._loop.stop)


async def _end_all() -> None:
    """Cancel all tasks of the loop, and wait for their end."""
    import asyncio

    left = asyncio.all_tasks() - {asyncio.current_task()}
    for task in left:
        task.cancel()
    await asyncio.gather(*left, return_exceptions=True)


async def _shielded(coroutine: Coroutine[Any, Any, object]) -> GuardedResult:
    """Await a coroutine; a SystemExit of it would end the loop that it shares with others."""
    import asyncio

    try:
        return GuardedResult(await coroutine)
    except asyncio.CancelledError:
        raise
    except BaseException as error:
        return GuardedResult(error=error)
