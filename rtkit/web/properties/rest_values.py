"""Values that hold only as long as a page keeps them, as that of a joystick: the dead man's handle.

A page renews such a value while somebody holds it. When it does so no longer, or the stream of the
page ends, the value at rest is set, whatever has become of the page.
"""

from __future__ import annotations

import asyncio
from collections import defaultdict
from collections.abc import Awaitable, Callable, Hashable
from typing import NamedTuple

from rtkit.errors import RtkitError

SetValue = Callable[[str, str, bool], Awaitable[object]]
"""Sets a property, given its target, a text, and whether it returns the value in force then."""


class Rest(NamedTuple):
    """Value to set once another one is held no longer, and the silence that counts as that [s]."""

    text: str
    after_s: float


class _Held(NamedTuple):
    rest: Rest
    timer: asyncio.TimerHandle


class ResettingValues:
    """All that pages hold."""

    def __init__(self, set_value: SetValue, fail: Callable[[str], object]) -> None:
        """Hold nothing yet; `fail` is told which value could not be set to its rest, and why."""
        self._set = set_value
        self._fail = fail
        self._held: dict[tuple[Hashable, str], _Held] = {}
        self._turns: defaultdict[str, asyncio.Lock] = defaultdict(asyncio.Lock)
        self._tasks: set[asyncio.Task[None]] = set()

    async def set(
        self, page: Hashable, target: str, text: str, rest: Rest | None, *, is_echoed: bool = False
    ) -> object:
        """Set a value: one that is held if it has a rest, else what was held is let go.

        Returns:
            The value in force then, if it `is_echoed`.

        Raises:
            RtkitError: It cannot be set.
        """
        async with self._turns[target]:  # in the order of arrival, and the rest behind them
            self._forget((page, target))
            if rest is not None:
                loop = asyncio.get_running_loop()
                timer = loop.call_later(rest.after_s, self._let_go, page, target)
                self._held[page, target] = _Held(rest, timer)
            return await self._set(target, text, is_echoed)

    def page_ended(self, page: Hashable) -> None:
        """Let go what a page holds."""
        for owner, target in tuple(self._held):
            if owner == page:
                self._let_go(page, target)

    async def close(self) -> None:
        """Let go everything, and return when that is done."""
        for page, target in tuple(self._held):
            self._let_go(page, target)
        await asyncio.gather(*self._tasks)

    def _forget(self, key: tuple[Hashable, str]) -> _Held | None:
        held = self._held.pop(key, None)
        if held is not None:
            held.timer.cancel()
        return held

    def _let_go(self, page: Hashable, target: str) -> None:
        held = self._forget((page, target))
        if held is not None:
            task = asyncio.create_task(self._rest(target, held.rest.text))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _rest(self, target: str, text: str) -> None:
        async with self._turns[target]:
            try:
                await self._set(target, text, False)
            except RtkitError as error:
                self._fail(str(error))
