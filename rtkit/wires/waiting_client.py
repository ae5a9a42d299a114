"""Client of commands over a connection of a proxy: whoever asks waits for the answer."""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from queue import Empty, SimpleQueue
from time import monotonic

from rtkit.closing import Closing
from rtkit.errors import Unreachable
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.property_client import Inbox, bound_in
from rtkit.wires.provider_connection import ProviderConnection

_CHECK_S = 1.0
"""How often the connection is looked after while an event is waited for [s]."""


class WaitingClient(Closing):
    """Client with a loop and a connection of its own.

    Args:
        connect: Makes the connection.
        timeout_s: Bound on each request [s].
    """

    def __init__(
        self, connect: Callable[[PropertyEventLoop], ProviderConnection], timeout_s: float
    ) -> None:
        self._timeout_s = timeout_s
        self._inbox = Inbox()
        self._wakes: SimpleQueue[str] = SimpleQueue()
        self._host = PropertyEventLoop()
        try:
            self._connection = connect(self._host)
        except BaseException:
            self._host.close()
            raise
        with self._host.lock:
            self._connection.start(self._wakes.put)
        self._host.start()

    def ask(self, target: str, payload: Payload | None = None) -> Answer:
        """See `PropertyClient.ask`."""
        bound_s = bound_in(target, self._timeout_s)
        until, answers = monotonic() + bound_s, SimpleQueue[Answer]()
        with self._host.lock:
            self._connection.ask(target, payload, "", answers.put, until)
        return _answer(answers, bound_s)

    def listen(self, target: str) -> None:
        """See `PropertyClient.listen`."""
        name, _, options = target.partition("?")
        self._inbox.expect(name, options)
        answers = SimpleQueue[Answer]()
        with self._host.lock:
            self._connection.listen(name, options, self._received, answers.put)
        _answer(answers, self._timeout_s).value()

    def _received(self, event: PropertyEvent) -> None:
        self._inbox.put(event)
        self._wakes.put("")

    def event(self, timeout_s: float | None = None) -> PropertyEvent | None:
        """See `PropertyClient.event`."""
        until = inf if timeout_s is None else monotonic() + timeout_s
        while True:
            with self._host.lock:
                self._connection.check(monotonic())
                event = self._inbox.take()
            if event is not None or (now := monotonic()) >= until:
                return event
            try:
                why = self._wakes.get(timeout=min(_CHECK_S, until - now))
            except Empty:
                continue
            if why:
                self._wakes.put(why)
                raise Unreachable(why)

    def close(self) -> None:
        """End the connection."""
        with self._host.lock:
            self._connection.close()
        self._host.close()
        self._connection.join(monotonic() + self._timeout_s)


def _answer(answers: SimpleQueue[Answer], bound_s: float) -> Answer:
    try:
        return answers.get(timeout=bound_s)
    except Empty:
        raise Unreachable(f"no answer within {bound_s:g} s") from None
