"""Pages that are open: what each is still to be sent, as server-sent events.

A page that reads too slowly loses nothing that counts: what waits for it is dropped, and it begins
anew with a whole picture. Of rates it gets the latest.
"""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import AsyncIterator, Callable
from typing import Any

PICTURE, CHANGE, RATES, NOTICE = "picture", "change", "rates", "notice"
_MOST_WAITING = 256
_ALIVE_S = 4.0
_ALIVE = b": alive\n\n"

Picture = Callable[[], dict[str, Any]]
"""Returns everything that is known now."""


def encoded(kind: str, data: Any) -> bytes:
    """Return an event as it goes over the stream."""
    return f"event: {kind}\ndata: {json.dumps(data, allow_nan=False)}\n\n".encode()


class PageStream:
    """One stream to a page."""

    def __init__(self) -> None:
        self._waiting: deque[bytes] = deque()
        self._rates = b""
        self._is_behind = False
        self._news = asyncio.Event()

    def take_behind(self) -> bool:
        """Return whether the page is to begin anew; it is told so once."""
        is_behind, self._is_behind = self._is_behind, False
        return is_behind

    def put(self, kind: str, event: bytes) -> None:
        """Have an event sent."""
        if kind == RATES:
            self._rates = event
        elif len(self._waiting) < _MOST_WAITING:
            self._waiting.append(event)
        else:
            self._waiting.clear()
            self._is_behind = True
        self._news.set()

    async def next(self) -> bytes:
        """Return what waits, or a sign of life when nothing has come for a while.

        Empty when the page is to begin anew.
        """
        try:
            async with asyncio.timeout(_ALIVE_S):
                await self._news.wait()
        except TimeoutError:
            return _ALIVE
        self._news.clear()
        sent = b"".join((*self._waiting, self._rates))
        self._waiting.clear()
        self._rates = b""
        return sent


class Pages:
    """All pages that are open."""

    def __init__(self, most: int) -> None:
        """Have none; there may be `most` at a time."""
        self.most = most
        self._open: set[PageStream] = set()

    @property
    def is_full(self) -> bool:
        """Return whether there are as many as may be."""
        return len(self._open) >= self.most

    def send(self, kind: str, data: Any) -> None:
        """Have an event sent to all pages."""
        if self._open:
            event = encoded(kind, data)
            for page in self._open:
                page.put(kind, event)

    async def stream(self, picture: Picture) -> AsyncIterator[bytes]:
        """Yield what is sent to a new page: the whole picture, then what changes."""
        page = PageStream()
        self._open.add(page)
        try:
            yield encoded(PICTURE, picture())
            while True:
                news = await page.next()
                yield encoded(PICTURE, picture()) if page.take_behind() else news
        finally:
            self._open.discard(page)
