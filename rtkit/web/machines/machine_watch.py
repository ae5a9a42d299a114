"""Follows one state machine for one page: its text, how it stands, and all that happens in it."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit import PropertyError
from rtkit.api.asked import Ask
from rtkit.api.live_records import Record
from rtkit.services.statemachine.rdf import bare, read_machine
from rtkit.web.machines.drafts import record_of
from rtkit.web.pages import encoded

if TYPE_CHECKING:
    from rtkit.api.client import Client
    from rtkit.api.listening import Listening

_PROPERTIES = ("state", "run", "status", "edits", "source")
_LISTENED = ("state", "run", "edits")
_LOOK_S = 1.0
"""Between two looks when nothing is received: variables and the log are not listened to [s]."""
_REST_S = 0.04
"""After each look, so that a machine that races costs no more than 25 of them [s]."""
_BOUND_S = 2.0
_FIRST, _AT_ONCE = 200, 1000
"""Entries of the log that are sent first, and that one page of it has."""
_ALIVE = b": alive\n\n"


class MachineNews(NamedTuple):
    """An event for the page: ``machine``, ``now`` or ``gone``."""

    kind: str
    data: Record


class MachineWatch:
    """Looks at one machine, again whenever it has changed; `look` is for one thread at a time."""

    def __init__(self, client: Client, machine: str, notify: Callable[[], object]) -> None:
        """Have seen nothing yet.

        Args:
            client: Asks.
            machine: Path of the service.
            notify: Called on any thread when there is something new to look at.
        """
        self._client = client
        self._machine = machine
        self._notify = notify
        self._listenings: list[Listening] = []
        self._forget()

    def look(self) -> list[MachineNews]:
        """Return what the page has not been sent yet."""
        try:
            return self._looked()
        except PropertyError as error:
            self.close()
            self._forget()
            return [MachineNews("gone", {"text": str(error)})]

    def close(self) -> None:
        """Hear no more."""
        listenings, self._listenings = self._listenings, []
        for each in listenings:
            each.close()

    def _forget(self) -> None:
        self._edits, self._entry = -1, -1
        self._variables: tuple[str, ...] = ()
        self._now: Record = {}
        self._is_lost = False

    def _looked(self) -> list[MachineNews]:
        if self._is_lost:
            self._forget()
        while len(self._listenings) < len(_LISTENED):
            target = f"{self._machine}.{_LISTENED[len(self._listenings)]}"
            self._listenings.append(self._client.listen(target, self._take, initial=False))
        news: list[MachineNews] = []
        now = self._standing()
        if now["edits"] < self._edits:  # the service is another one by now
            self._forget()
        if now["edits"] != self._edits:
            news.append(self._text())
            now = self._standing()
        is_first = self._entry < 0
        log = self._entries()
        if log or is_first or now != self._now:
            self._now = now
            news.append(MachineNews("now", {**now, "log": log, "is_first": is_first}))
        return news

    def _take(self, change: Any) -> None:
        self._is_lost = self._is_lost or bool(change.code)
        self._notify()

    def _standing(self) -> Record:
        names = [*_PROPERTIES, *(f"variables.{each}" for each in self._variables)]
        values = self._ask(*(Ask(f"{self._machine}.{each}") for each in names))
        found = dict(zip(names, values, strict=True))
        variables = {each: bare(found.pop(f"variables.{each}")) for each in self._variables}
        return {**found, "variables": variables}

    def _ask(self, *asks: Ask) -> list[Any]:
        answers = self._client.ask_all(asks, _BOUND_S)
        for each in answers:
            if isinstance(each, PropertyError):
                raise each
        return answers

    def _text(self) -> MachineNews:
        """Return the text with the number of edits that it is the outcome of."""
        target, before = f"{self._machine}.machine", -1
        edits = self._client.get(f"{self._machine}.edits")
        text = ""
        while edits != before:
            before = edits
            text = self._client.get_bytes(target).decode()
            edits = self._client.get(f"{self._machine}.edits")
        machine = read_machine(text)
        self._edits, self._variables = edits, tuple(machine.variables)
        return MachineNews("machine", {"edits": edits, "text": text, "machine": record_of(machine)})

    def _entries(self) -> list[list[Any]]:
        """Return the entries of the log behind the last one that was sent."""
        found: list[list[Any]] = []
        while True:
            given = {"n": _FIRST} if self._entry < 0 else {"n": _AT_ONCE, "since": self._entry}
            (page,) = self._ask(Ask(f"{self._machine}.log", parameters=given))
            found += [list(each) for each in page]
            self._entry = page[-1][0] if page else max(self._entry, 0)
            if len(page) < given["n"] or "since" not in given:
                return found


async def news_of(client: Client, machine: str) -> AsyncIterator[bytes]:
    """Yield the news of a machine as server-sent events, while the page reads them."""
    loop, news = asyncio.get_running_loop(), asyncio.Event()
    watch = MachineWatch(client, machine, lambda: loop.call_soon_threadsafe(news.set))
    last_gone = None
    try:
        while True:
            news.clear()
            for each in await asyncio.to_thread(watch.look):
                if each != last_gone:
                    yield encoded(each.kind, each.data)
                last_gone = each if each.kind == "gone" else None
            yield _ALIVE
            await asyncio.sleep(_REST_S)
            try:
                async with asyncio.timeout(_LOOK_S):
                    await news.wait()
            except TimeoutError:
                continue
    finally:
        await asyncio.to_thread(watch.close)
