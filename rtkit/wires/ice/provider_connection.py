"""Connection of a proxy to its owner over Ice."""

from __future__ import annotations

from functools import partial
from math import inf

from rtkit.errors import Unreachable
from rtkit.link import secret
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.ice.address import IceAddress
from rtkit.wires.ice.protocol import runtime
from rtkit.wires.ice.session import IceSession, Outcome
from rtkit.wires.provider_connection import (
    ENDED,
    STATUS,
    Answering,
    EventHandler,
    Keepalive,
    LoopInbox,
    ProviderConnection,
    with_id,
)


class IceConnection(ProviderConnection):
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
        super().__init__(host)
        self._silence = Keepalive()
        runtime()
        self._session = IceSession(address, secret.read(), timeout_s, went=self._went)

    def ask(
        self, target: str, payload: Payload | None, id: str, answer: Answering, until: float = inf
    ) -> None:
        """See `ProviderConnection.ask`."""
        if not self._is_open:
            answer(ENDED)
            return
        number = self._expect(answer)
        self._session.ask(
            with_id(target, id),
            payload,
            lambda outcome: self._host.post(lambda: self._received(number, outcome)),
            until,
        )

    def listen(self, name: str, options: str, on_event: EventHandler, answer: Answering) -> None:
        """See `ProviderConnection.listen`."""
        inbox = LoopInbox(self._host, options, lambda event: self._take(name, key, on_event, event))

        def take(events: list[PropertyEvent]) -> None:
            for event in events:
                inbox.put(event)

        number = self._expect(lambda reply: self._answering(name, key, answer)(reply))
        key = self._session.listen(
            f"{name}?{options}" if options else name,
            take,
            lambda outcome: self._host.post(lambda: self._received(number, outcome)),
        )
        self._subscriptions[name] = key

    def leave(self, name: str) -> None:
        """See `ProviderConnection.leave`."""
        key = self._subscriptions.pop(name, None)
        if key is not None:
            self._session.leave(key)

    def check(self, now: float) -> None:
        """See `ProviderConnection.check`."""
        if self._callers or self._subscriptions:
            probe = partial(self.ask, STATUS, None, "", lambda _: None)
            self._silence.check(now, probe, self._fail)

    # Its own

    def _expect(self, answer: Answering) -> int:
        if not self._callers and not self._subscriptions:
            self._silence.end()
        return super()._expect(answer)

    def _received(self, number: int, outcome: Outcome) -> None:
        self._silence.end()
        if isinstance(outcome, Unreachable):
            outcome = Answer(str(outcome), "no-service")
        self._answer(number, outcome)

    def _take(self, name: str, key: str, on_event: EventHandler, event: PropertyEvent) -> None:
        self._silence.end()
        if self._subscriptions.get(name) == key:
            on_event(event)

    def _went(self, why: str) -> None:
        self._host.post(lambda: self._fail(why))

    def _release(self) -> None:
        self._subscriptions.clear()
        self._session.close()
