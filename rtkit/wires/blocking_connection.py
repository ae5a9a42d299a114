"""Connection of a proxy to an owner whose calls block: threads make them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from math import inf
from queue import SimpleQueue
from time import monotonic

from rtkit.errors import RtkitError, Unreachable
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.messages import DONE, Answer, Payload
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.property_client import BoundedClient, failure
from rtkit.wires.provider_connection import (
    ENDED,
    Answering,
    ConnectionMaker,
    EventHandler,
    LoopInbox,
    ProviderConnection,
    with_id,
)
from rtkit.wires.request_scheduler import RequestScheduler, ScheduledRequest

_LATE = Answer(NOT_BEGUN, "timeout")
_LOOK_S = 1.0
"""How long an event is waited for, until is looked whether it is still wanted [s]."""

_Call = Callable[[BoundedClient | None], BoundedClient | None]
"""Made over a connection, which is made before if there is none; returns it."""
_MOST_AT_ONCE = 8
"""Connections for requests."""


class BlockingConnection(ProviderConnection):
    """Pool of connections, each of which waits for one answer.

    Args:
        end: For requests.
        another: Makes one more, for requests that need not wait for others, or for listening.
    """

    _subscriptions: dict[str, threading.Event]

    def __init__(
        self, host: PropertyEventLoop, end: BoundedClient, another: Callable[[], BoundedClient]
    ) -> None:
        super().__init__(host)
        self._first: BoundedClient | None = end
        self._another = another
        self._calls: SimpleQueue[_Call | None] = SimpleQueue()
        self._turns = RequestScheduler(_MOST_AT_ONCE)
        self._workers = 0
        self._idle = 0

    def ask(
        self, target: str, payload: Payload | None, id: str, answer: Answering, until: float = inf
    ) -> None:
        """See `ProviderConnection.ask`."""
        if not self._is_open:
            answer(ENDED)
            return
        number = self._expect(answer)

        def work() -> None:
            self._calls.put(call)

        def call(end: BoundedClient | None) -> BoundedClient | None:
            if monotonic() > until:
                self._host.post(lambda: self._answered(number, turn, _LATE))
                return end
            try:
                end = self._another() if end is None else end
                reply = end.ask(with_id(target, id), payload, until)
            except RtkitError as error:
                reply, why = failure(error), str(error)
                if isinstance(error, Unreachable) and reply.error != "timeout":
                    self._host.post(lambda: self._fail(why))
            self._host.post(lambda: self._answered(number, turn, reply))
            return end

        turn = ScheduledRequest(target, payload is not None, work)
        self._turns.add(turn)
        self._begin()

    def _begin(self) -> None:
        """Begin the requests that the scheduler releases, on a thread each."""
        for turn in self._turns.begin():
            turn.work()
            if self._idle:
                self._idle -= 1
                continue
            self._workers += 1
            end, self._first = self._first, None
            self._begin_thread(self._work, end, name="calls")

    def listen(self, name: str, options: str, on_event: EventHandler, answer: Answering) -> None:
        """See `ProviderConnection.listen`."""
        is_over = self._subscriptions[name] = threading.Event()
        target = f"{name}?{options}" if options else name
        inbox = LoopInbox(
            self._host, options, lambda event: None if is_over.is_set() else on_event(event)
        )

        answered = self._answering(name, is_over, answer)

        def work() -> None:
            try:
                end = self._another()
            except RtkitError as error:
                reply = failure(error)
                self._host.post(lambda: answered(reply))
                return
            try:
                self._receive(end, target, is_over, inbox, answered)
            finally:
                end.close()

        self._begin_thread(work, name="listening")

    def _receive(
        self,
        end: BoundedClient,
        target: str,
        is_over: threading.Event,
        inbox: LoopInbox,
        answered: Answering,
    ) -> None:
        try:
            end.listen(target)
        except RtkitError as error:
            reply = failure(error)
            self._host.post(lambda: answered(reply))
            return
        self._host.post(lambda: answered(DONE))
        try:
            while not is_over.is_set():
                event = end.event(_LOOK_S)
                if event is not None:
                    inbox.put(event)
        except RtkitError as error:
            why = str(error)
            if not is_over.is_set():
                self._host.post(lambda: self._fail(why))

    def leave(self, name: str) -> None:
        """See `ProviderConnection.leave`."""
        is_over = self._take_off(name)
        if is_over is not None:
            is_over.set()

    def _release(self) -> None:
        for _ in range(self._workers):
            self._calls.put(None)
        if self._first is not None:
            self._first.close()
        for is_over in self._subscriptions.values():
            is_over.set()
        self._subscriptions.clear()

    def _work(self, end: BoundedClient | None) -> None:
        """Make calls, one after the other, over one connection, made when it is needed."""
        while (call := self._calls.get()) is not None:
            end = call(end)
        if end is not None:
            end.close()

    def _answered(self, number: int, turn: ScheduledRequest, reply: Answer) -> None:
        self._idle += 1
        self._turns.end(turn)
        self._answer(number, reply)
        if self._is_open:
            self._begin()


def blocking_calls(
    host: PropertyEventLoop, another: Callable[[], BoundedClient]
) -> ConnectionMaker:
    """Return what connects to a provider by clients whose calls block."""
    return lambda: BlockingConnection(host, another(), another)
