"""Connection of a proxy to an owner at the far end of a serial line, which one thread uses."""

from __future__ import annotations

import threading
from collections.abc import Callable
from math import inf
from queue import Empty, SimpleQueue

from rtkit.errors import RtkitError, Unreachable
from rtkit.property.messages import DONE, Answer, Payload
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.property_client import failure
from rtkit.wires.provider_connection import (
    ENDED,
    Answering,
    EventHandler,
    Gone,
    LoopInbox,
    ProviderConnection,
    slot,
)
from rtkit.wires.serial.client import SerialClient
from rtkit.wires.serial.shared_line import SharedLine


class SerialConnection(ProviderConnection):
    """Conversation in which each request waits for the one before it."""

    _key_of = staticmethod(slot)
    _subscriptions: dict[str, LoopInbox]

    def __init__(self, host: PropertyEventLoop, client: SerialClient | SharedLine) -> None:
        super().__init__(host)
        self._client = client
        self._calls: SimpleQueue[Callable[[], None]] = SimpleQueue()

    def start(self, gone: Gone) -> None:
        """See `ProviderConnection.start`."""
        super().start(gone)
        threading.Thread(target=self._work, name="serial line", daemon=True).start()

    def ask(
        self, target: str, payload: Payload | None, id: str, answer: Answering, until: float = inf
    ) -> None:
        """See `ProviderConnection.ask`."""
        self._call(lambda: self._client.ask(target, payload, id, until), answer)

    def listen(self, name: str, options: str, on_event: EventHandler, answer: Answering) -> None:
        """See `ProviderConnection.listen`."""
        key = slot(name)
        inbox = LoopInbox(self._host, options, lambda e: on_event(e) if is_mine() else None)
        self._subscriptions[key] = inbox

        def is_mine() -> bool:
            return self._subscriptions.get(key) is inbox

        def begin() -> Answer:
            self._client.listen(f"{name}?{options}" if options else name)
            return DONE

        self._call(begin, self._answering(name, inbox, answer))

    def leave(self, name: str) -> None:
        """See `ProviderConnection.leave`."""
        if self._take_off(slot(name)) is not None:
            self._call(lambda: self._client.leave(name), lambda reply: None)

    # Its own

    def _release(self) -> None:
        self._client.wake()
        self._subscriptions.clear()

    def _call(self, work: Callable[[], Answer], answer: Answering) -> None:
        """Run a function on the thread of the line; its outcome is passed on the loop."""
        if not self._is_open:
            answer(ENDED)
            return
        number = self._expect(answer)

        def call() -> None:
            try:
                reply = work()
            except RtkitError as error:
                reply = failure(error)
                if isinstance(error, Unreachable) and reply.error != "timeout":
                    self._host.post(lambda: self._fail(str(reply.payload), reply.error))
            self._host.post(lambda: self._answer(number, reply))

        self._calls.put(call)
        self._client.wake()

    def _work(self) -> None:
        """Make the calls one after the other; in between receive events."""
        try:
            while self._is_open:
                try:
                    self._calls.get_nowait()()
                    continue
                except Empty:
                    event = self._client.event()
                inbox = None if event is None else self._subscriptions.get(slot(event.name))
                if event is not None and inbox is not None:
                    inbox.put(event)
        except RtkitError as error:
            why = str(error)
            self._host.post(lambda: self._fail(why))
        finally:
            self._client.close()
