"""Pages that are open: what each is still to be sent, as server-sent events.

A page that reads too slowly loses nothing that counts: what waits for it is dropped, and it begins
anew with a whole picture. Of rates it gets the latest.
"""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import AsyncIterator, Callable, Mapping
from itertools import count
from typing import Any

from rtkit.errors import NotFound

PICTURE, CHANGE, RATES, NOTICE = "picture", "change", "rates", "notice"
VALUES = "values"
PROPERTIES = "properties"
"""The event that tells one page values of the live properties that it shows, by name."""
_MOST_WAITING = 256
_ALIVE_S = 4.0
_ALIVE = b": alive\n\n"

Picture = Callable[[], dict[str, Any] | None]
"""Returns everything that is known now; None before the first look at the system."""


def encoded(kind: str, data: Any) -> bytes:
    """Return an event as it goes over the stream."""
    return f"event: {kind}\ndata: {json.dumps(data, allow_nan=False)}\n\n".encode()


class PageStream:
    """One stream to a page.

    Attributes:
        ports: Paths of ports that the page shows values of.
        is_over: Nothing more is sent than what waits.
    """

    def __init__(self) -> None:
        self.is_over = False
        self.ports: frozenset[str] = frozenset()
        self._values: dict[str, Any] = {}
        self._properties: dict[str, Any] = {}
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

    def put_values(self, values: dict[str, Any]) -> None:
        """Have values sent of the ports that the page shows; of each port the latest."""
        shown = {path: values[path] for path in self.ports.intersection(values)}
        if shown:
            self._values |= shown
            self._news.set()

    def put_properties(self, values: Mapping[str, Any]) -> None:
        """Have values of live properties sent; of each name the latest."""
        self._properties |= values
        self._news.set()

    def end(self) -> None:
        """Send what waits, and then nothing more."""
        self.is_over = True
        self._news.set()

    def wake(self) -> None:
        """Have the stream look for a picture."""
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
        values = encoded(VALUES, {"values": self._values}) if self._values else b""
        properties = encoded(PROPERTIES, self._properties) if self._properties else b""
        sent = b"".join((*self._waiting, self._rates, values, properties))
        self._waiting.clear()
        self._rates, self._values, self._properties = b"", {}, {}
        return sent


class Pages:
    """All pages that are open."""

    def __init__(self, most: int) -> None:
        """Have none; there may be `most` at a time."""
        self.most = most
        self._numbers = count(1)
        self._open: dict[str, PageStream] = {}
        self._ended: list[Callable[[PageStream], object]] = []

    @property
    def is_full(self) -> bool:
        """Return whether there are as many as may be."""
        return len(self._open) >= self.most

    def send(self, kind: str, data: Any) -> None:
        """Have an event sent to all pages."""
        if self._open:
            event = encoded(kind, data)
            for page in self._open.values():
                page.put(kind, event)

    def found(self, id: str) -> PageStream:
        """Return the stream of a page.

        Raises:
            NotFound: No page of that id is open.
        """
        if id not in self._open:
            raise NotFound(f"No such page: {id}")
        return self._open[id]

    def when_ended(self, call: Callable[[PageStream], object]) -> None:
        """Have a function called with each stream that ends."""
        self._ended.append(call)

    def end(self) -> None:
        """End all streams."""
        for page in self._open.values():
            page.end()

    def wake(self) -> None:
        """Have all streams look for a picture: the system is known now."""
        for page in self._open.values():
            page.wake()

    def watch(self, id: str, ports: frozenset[str]) -> None:
        """Have a page sent the values of these ports, and of no others.

        Raises:
            NotFound: No page of that id is open.
        """
        self.found(id).ports = ports

    def watched(self) -> frozenset[str]:
        """Return all ports that some page shows values of."""
        return frozenset[str]().union(*(each.ports for each in self._open.values()))

    def send_values(self, values: dict[str, Any]) -> None:
        """Send values of ports, by path, to the pages that show these."""
        for page in self._open.values():
            page.put_values(values)

    async def stream(self, picture: Picture, id: str = "") -> AsyncIterator[bytes]:
        """Yield what is sent to a new page: the whole picture, then what changes.

        Before the system is known there are notices and signs of life only: a page that were
        shown nothing would tell its user that there is nothing.

        Args:
            picture: Returns the whole picture, None while nothing is known.
            id: Of the page, which it has chosen itself; its next stream has the same.
        """
        page = PageStream()
        id = id or f"page {next(self._numbers)}"
        self._open[id] = page
        try:
            is_shown = False
            while not page.is_over:
                if not is_shown and (whole := picture()) is not None:
                    is_shown = True
                    yield encoded(PICTURE, whole)
                news = await page.next()
                if page.take_behind():
                    is_shown = False
                elif news:
                    yield news
        finally:
            if self._open.get(id) is page:
                del self._open[id]
            for call in self._ended:
                call(page)
