"""Link inside one process: the fake for fast tests."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from rtkit.errors import Malformed, Unreachable
from rtkit.property.exchange import Reply, Request


class InprocLink:
    """Reaches every service that is offered on the same object."""

    def __init__(self) -> None:
        self._services: dict[str, Callable[[Request], object]] = {}
        self._lines: dict[str, list[Callable[[str], object]]] = {}
        self._listened: dict[str, Callable[[bool], object]] = {}

    def call(self, key: str, payload: str | None, timeout_s: float) -> Reply:
        """See `Link.call`."""
        return self.send(key, payload, timeout_s)()

    def send(self, key: str, payload: str | None, timeout_s: float) -> Callable[[], Reply]:
        """See `Link.send`."""
        key, _, id = key.partition("?id=")
        service_key, is_extension, name = _split(key)
        enqueue = self._services.get(service_key)
        if enqueue is None:
            raise Unreachable(f"nobody serves {service_key}")
        answered = threading.Event()
        replies: list[Reply] = []

        def answer(reply: Reply) -> None:
            replies.append(reply)
            answered.set()

        def reply() -> Reply:
            if not answered.wait(timeout_s):
                raise Unreachable(f"no answer within {timeout_s:g} s")
            return replies[0]

        until = time.monotonic() + timeout_s
        enqueue(Request(name, payload, answer, is_extension=is_extension, until=until, id=id))
        return reply

    def serve(self, service_key: str, enqueue: Callable[[Request], object]) -> None:
        """See `Link.serve`."""
        self._services[service_key] = enqueue

    def announce(self, key: str, listened: Callable[[bool], object]) -> Callable[[str], object]:
        """See `Link.announce`."""
        self._listened[key] = listened

        def tell(text: str) -> None:
            for on_text in list(self._lines.get(key, ())):
                on_text(text)

        return tell

    def listen(self, key: str, on_text: Callable[[str], object]) -> Callable[[], object]:
        """See `Link.listen`."""
        listeners = self._lines.setdefault(key, [])
        listeners.append(on_text)
        if len(listeners) == 1 and key in self._listened:
            self._listened[key](True)

        def end() -> None:
            listeners.remove(on_text)
            if not listeners and key in self._listened:
                self._listened[key](False)

        return end

    def notice(self, key: str, found: Callable[[bool], object]) -> Callable[[], object]:
        """See `Link.notice`."""
        return lambda: None

    def close(self) -> None:
        """See `Link.close`."""
        self._services.clear()


def _split(key: str) -> tuple[str, bool, str]:
    for mark, is_extension in (("/@x/", True), ("/@/", False)):
        service_key, found, name = key.partition(mark)
        if found:
            return service_key, is_extension, name
    raise Malformed(f"not a property: {key}")
