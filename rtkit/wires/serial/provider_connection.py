"""Connection of a proxy to an owner at the far end of a serial line, which one thread uses."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from queue import Empty, SimpleQueue

from rtkit.errors import RtkitError, Unreachable
from rtkit.property.codes import code_of
from rtkit.property.messages import DONE, Answer, Payload
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.provider_connection import Answering, Gone, Hearing, LoopInbox, slot
from rtkit.wires.serial.client import SerialClient

_ENDED = Answer("the connection has ended", "no-service")


class SerialConnection:
    """Conversation in which each request waits for the one before it."""

    def __init__(self, host: PropertyEventLoop, client: SerialClient) -> None:
        self._host = host
        self._client = client
        self._calls: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._waiting: dict[int, Answering] = {}
        self._number = 0
        self._mail: dict[str, LoopInbox] = {}
        self._is_open = True
        self._gone: Gone = lambda why: None

    def start(self, gone: Gone) -> None:
        """See `ProviderConnection.start`."""
        self._gone = gone
        threading.Thread(target=self._work, name="serial line", daemon=True).start()

    def ask(
        self,
        target: str,
        payload: Payload | None,
        id: str,
        answer: Answering,
        until: float = math.inf,
    ) -> None:
        """See `ProviderConnection.ask`."""
        self._call(lambda: self._client.ask(target, payload, id, until), answer)

    def has_room(self, name: str) -> bool:
        """See `ProviderConnection.has_room`: there is one listener of a property on each line."""
        return slot(name) not in self._mail

    def listen(self, name: str, options: str, hear: Hearing, answer: Answering) -> None:
        """See `ProviderConnection.listen`."""
        key = slot(name)
        inbox = LoopInbox(self._host, options, lambda e: hear(e) if is_mine() else None)
        self._mail[key] = inbox

        def is_mine() -> bool:
            return self._mail.get(key) is inbox

        def begin() -> Answer:
            self._client.listen(f"{name}?{options}" if options else name)
            return DONE

        def answered(reply: Answer) -> None:
            if reply.error and is_mine():
                del self._mail[key]
            answer(reply)

        self._call(begin, answered)

    def leave(self, name: str) -> None:
        """See `ProviderConnection.leave`."""
        if self._mail.pop(slot(name), None) is not None:
            self._call(lambda: self._client.leave(name), lambda reply: None)

    def check(self, now: float) -> None:
        """See `ProviderConnection.check`: renew leases; each request has a time-out of its own."""

    def close(self) -> None:
        """See `ProviderConnection.close`."""
        if self._is_open:
            self._is_open = False
            self._client.wake()
            self._mail.clear()
            waiting, self._waiting = self._waiting, {}
            for answer in waiting.values():
                answer(_ENDED)

    # Its own

    def _call(self, work: Callable[[], Answer], answer: Answering) -> None:
        """Run a function on the thread of the line; its outcome is passed on the loop."""
        if not self._is_open:
            answer(_ENDED)
            return
        self._number += 1
        number = self._number
        self._waiting[number] = answer

        def call() -> None:
            try:
                reply = work()
            except RtkitError as error:
                is_late = isinstance(error, Unreachable) and "no answer" in str(error)
                reply = Answer(str(error), "timeout" if is_late else code_of(error))
                if isinstance(error, Unreachable) and not is_late:
                    self._host.post(lambda: self._fail(reply))
            self._host.post(lambda: self._answered(number, reply))

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
                inbox = None if event is None else self._mail.get(slot(event.name))
                if event is not None and inbox is not None:
                    inbox.put(event)
        except RtkitError as error:
            reply = Answer(str(error), "no-service")
            self._host.post(lambda: self._fail(reply))
        finally:
            self._client.close()

    def _answered(self, number: int, reply: Answer) -> None:
        answer = self._waiting.pop(number, None)
        if answer is not None:
            answer(reply)

    def _fail(self, reply: Answer) -> None:
        if self._is_open:
            waiting, self._waiting = self._waiting, {}
            for answer in waiting.values():
                answer(reply)
            self.close()
            self._gone(str(reply.payload))
