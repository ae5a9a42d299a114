"""Connection of a proxy to its owner over Ice."""

from __future__ import annotations

import math
from functools import partial

from rtkit.errors import Unreachable
from rtkit.link import secret
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.ice.address import IceAddress
from rtkit.wires.ice.protocol import runtime
from rtkit.wires.ice.session import IceSession, Outcome
from rtkit.wires.provider_connection import (
    STATUS,
    Answering,
    Gone,
    Hearing,
    Keepalive,
    LoopInbox,
    Waiting,
    with_id,
)


class IceConnection:
    """Session with an Ice endpoint, used by nobody else.

    Args:
        address: Of the service.
        timeout_s: Bound on connecting [s].

    Raises:
        Refused: Ice is not there.
        Unreachable: Nobody answers there.
        PropertyError: ``denied``: the endpoint knows another secret.
    """

    def __init__(self, host: PropertyEventLoop, address: IceAddress, timeout_s: float) -> None:
        self._host = host
        self._waiting = Waiting()
        self._subscriptions: dict[str, str] = {}
        self._silence = Keepalive()
        self._is_open = True
        self._gone: Gone = lambda why: None
        runtime()
        self._session = IceSession(address, secret.read(), timeout_s, went=self._went)

    def start(self, gone: Gone) -> None:
        """See `ProviderConnection.start`."""
        self._gone = gone

    def ask(
        self,
        target: str,
        payload: Payload | None,
        id: str,
        answer: Answering,
        until: float = math.inf,
    ) -> None:
        """See `ProviderConnection.ask`."""
        if not self._is_open:
            answer(Answer("the connection has ended", "no-service"))
            return
        number = self._expect(answer)
        self._session.ask(
            with_id(target, id),
            payload,
            lambda told: self._host.post(lambda: self._answered(number, told)),
            until,
        )

    def has_room(self, name: str) -> bool:
        """See `ProviderConnection.has_room`: each listening has an object of its own."""
        return name not in self._subscriptions

    def listen(self, name: str, options: str, hear: Hearing, answer: Answering) -> None:
        """See `ProviderConnection.listen`."""
        inbox = LoopInbox(self._host, options, lambda event: self._take(name, key, hear, event))

        def take(events: list[PropertyEvent]) -> None:
            for event in events:
                inbox.put(event)

        def answered(reply: Answer) -> None:
            if reply.error and self._subscriptions.get(name) == key:
                del self._subscriptions[name]
            answer(reply)

        number = self._expect(answered)
        key = self._session.listen(
            f"{name}?{options}" if options else name,
            take,
            lambda told: self._host.post(lambda: self._answered(number, told)),
        )
        self._subscriptions[name] = key

    def leave(self, name: str) -> None:
        """See `ProviderConnection.leave`."""
        key = self._subscriptions.pop(name, None)
        if key is not None:
            self._session.leave(key)

    def check(self, now: float) -> None:
        """See `ProviderConnection.check`."""
        if self._waiting or self._subscriptions:
            probe = partial(self.ask, STATUS, None, "", lambda _: None)
            self._silence.check(now, probe, self._fail)

    def close(self) -> None:
        """See `ProviderConnection.close`."""
        self._close(Answer("the connection has ended", "no-service"))

    # Its own

    def _expect(self, answer: Answering) -> int:
        if not self._waiting and not self._subscriptions:
            self._silence.end()
        return self._waiting.expect(answer)

    def _answered(self, number: int, told: Outcome) -> None:
        self._silence.end()
        reply = Answer(str(told), "no-service") if isinstance(told, Unreachable) else told
        self._waiting.answer(number, reply)

    def _take(self, name: str, key: str, hear: Hearing, event: PropertyEvent) -> None:
        self._silence.end()
        if self._subscriptions.get(name) == key:
            hear(event)

    def _went(self, why: str) -> None:
        self._host.post(lambda: self._fail(why, "no-service"))

    def _fail(self, why: str, code: str) -> None:
        if self._is_open:
            self._close(Answer(why, code))
            self._gone(why)

    def _close(self, reply: Answer) -> None:
        if not self._is_open:
            return
        self._is_open = False
        self._subscriptions.clear()
        self._waiting.end(reply)
        self._session.close()
