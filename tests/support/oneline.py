"""Serial endpoint of the conformance suite: one client for all requests and events."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager

from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.wires.serial.client import SerialClient

BOUND_S = 30.0


class OneLine:
    """The door behind one client, since there is one line."""

    def __init__(self, client: SerialClient) -> None:
        self._client = client
        self._kept: dict[str, deque[PropertyEvent]] = {}
        self.close = client.close

    def ask(self, target: str, payload: Payload | None = None) -> Answer:
        """GET, or SET."""
        return self._client.ask(target, payload)

    @contextmanager
    def listen(self, target: str) -> Iterator[Iterator[PropertyEvent]]:
        """Listen; events of others are kept for them."""
        name = target.partition("?")[0]
        kept = self._kept[name] = deque()
        self._client.listen(target)

        def events() -> Iterator[PropertyEvent]:
            while True:
                while not kept:
                    event = self._client.event(BOUND_S)
                    assert event is not None, f"no event of {name}"
                    self._kept[event.name].append(event)
                yield kept.popleft()

        yield events()
        self.ask(f"{name}.listen?remove", "self")
