"""Follows the properties that pages look at: values as they come, and what is to be drawn anew.

A page looks at one property page at a time. Its values are gathered for a moment, and of each
property the latest is sent, so that no page gets more than it can draw.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable
from concurrent.futures import Executor
from functools import partial
from typing import Any

from rtkit.api.client import Client
from rtkit.api.listening import Listening
from rtkit.api.property_change import PropertyChange
from rtkit.errors import RtkitError
from rtkit.panel.description import Panel, element_of
from rtkit.property.codes import PropertyError
from rtkit.property.writing import write
from rtkit.web.pages import PageStream, encoded
from rtkit.web.properties.description import watched

OUTDATED = "outdated"
"""The event that tells a page to ask anew what it is to draw."""
_EVERY_S = 0.1
_GATHERED_S = 0.05
_LOOK_S = 1.5
_LATE = frozenset({"no-service", "timeout"})

Describe = Callable[[], Panel]
"""Returns what a page is to draw; blocks."""
Shown = dict[str, Any]


class PropertyWatch:
    """One property page that somebody looks at."""

    def __init__(self, page: PageStream, client: Client, threads: Executor) -> None:
        self._page = page
        self._client = client
        self._threads = threads
        self._loop = asyncio.get_running_loop()
        self._gathered: dict[str, Shown] = {}
        self._listened: dict[str, Listening] = {}
        self._refused: set[str] = set()
        self._looking: asyncio.Task[None] | None = None
        self._tasks: set[asyncio.Task[None]] = set()
        self._is_over = False

    async def begin(self, describe: Describe) -> str:
        """Follow what is described; return it as the text of a ``<gui>``.

        Raises:
            PropertyError: It cannot be reached, or is not there.
        """
        panel = await self._run(describe)
        text = write(element_of(panel))
        self._listen(set(watched(panel)))
        self._looking = asyncio.create_task(self._look(describe, text))
        return text

    async def end(self) -> None:
        """Follow it no longer; what is just begun to be listened to is ended when it has begun."""
        self._is_over = True
        if self._looking is not None:
            self._looking.cancel()
        listened, self._listened = list(self._listened.values()), {}
        await self._run(partial(_close, listened))

    def _run(self, call: Callable[[], Any]) -> Awaitable[Any]:
        return self._loop.run_in_executor(self._threads, call)

    def _listen(self, names: Iterable[str]) -> None:
        for each in names:
            task = asyncio.create_task(self._listen_to(each))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _listen_to(self, name: str) -> None:
        listening = await self._run(partial(self._listening, name))
        if listening is not None and self._is_over:
            await self._run(listening.close)
        elif listening is not None:
            self._refused.discard(name)
            self._listened[name] = listening

    def _listening(self, name: str) -> Listening | None:
        came = partial(self._came, name)
        try:
            return self._client.listen_payloads(name, came, every=_EVERY_S)
        except PropertyError as error:
            if error.code == "write-only":
                return None
            code = error.code if error.code in _LATE else ""
            shown = {"text": "", "why": str(error), "code": code, "quality": "bad", "is_raw": True}
            self._loop.call_soon_threadsafe(self._refuse, name, shown)
            return None

    def _refuse(self, name: str, shown: Shown) -> None:
        self._refused.add(name)
        self._gather(name, shown)

    def _came(self, name: str, change: PropertyChange) -> None:
        """Take a change, on the thread of the client."""
        if not self._is_over:
            self._loop.call_soon_threadsafe(self._gather, name, shown_of(change))

    def _gather(self, name: str, shown: Shown) -> None:
        if not self._gathered:
            self._loop.call_later(_GATHERED_S, self._send)
        self._gathered[name] = shown

    def _send(self) -> None:
        gathered, self._gathered = self._gathered, {}
        if not self._is_over:
            self._page.put_properties(gathered)

    async def _look(self, describe: Describe, before: str) -> None:
        """Look now and then: of forms of widgets no event tells; who is stopped ends nothing."""
        is_answered = True
        while True:
            await asyncio.sleep(_LOOK_S)
            try:
                text = write(element_of(await self._run(describe)))
                problem = ""
            except RtkitError as error:
                text, problem = before, str(error)
            if text != before or is_answered != (not problem):
                self._page.put(OUTDATED, encoded(OUTDATED, {"why": problem}))
            before, is_answered = text, not problem
            if not problem and not self._tasks:
                self._listen(tuple(self._refused))


def shown_of(change: PropertyChange) -> Shown:
    """Return a change as pages get it; of bytes they get the number, and ask for them."""
    is_bytes = isinstance(change.value, bytes)
    text = f"{len(change.value)} bytes" if is_bytes else str(change.value)
    code = "" if change.quality == "stale" else change.code
    return {"text": text, "quality": change.quality, "code": code, "is_raw": is_bytes}


def _close(listened: Iterable[Listening]) -> None:
    for each in listened:
        each.close()
