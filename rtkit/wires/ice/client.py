"""Client of an Ice endpoint: asks and listens over one connection, and waits for what comes."""

from __future__ import annotations

import threading
from queue import Empty, SimpleQueue
from typing import Any

from rtkit.closing import Closing
from rtkit.errors import Unreachable
from rtkit.link.secret import Secret
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.wires.ice import protocol
from rtkit.wires.ice.address import IceAddress, read_address
from rtkit.wires.ice.session import IceSession, Outcome
from rtkit.wires.property_client import Inbox, bound_in

_MOST_EVENTS = 10_000
"""Events that nobody has taken, above which the endpoint is to send no more."""


class IceClient(Closing):
    """Client of the services behind an Ice endpoint.

    Args:
        address: Its service is asked where a target names none.
        timeout_s: Bound on connecting and on each request [s].

    Raises:
        Refused: Ice is not there.
        Unreachable: Nobody answers there.
        PropertyError: ``denied``: the endpoint knows another secret.
    """

    def __init__(self, address: IceAddress, secret: Secret, timeout_s: float) -> None:
        self._inbox = Inbox()
        self._arrived = threading.Condition()
        self._held: list[Any] = []
        self._why = ""
        self._timeout_s = timeout_s
        self._session = IceSession(address, secret, timeout_s, request_s=timeout_s, went=self._went)

    def ask(self, target: str, payload: Payload | None = None) -> Answer:
        """See `PropertyClient.ask`."""
        outcomes: SimpleQueue[Outcome] = SimpleQueue()
        bound_s = bound_in(target, self._timeout_s)
        self._session.ask(target, payload, outcomes.put)
        try:
            return _answer(outcomes.get(timeout=bound_s if bound_s < self._timeout_s else None))
        except Empty:
            raise Unreachable(f"no answer within {bound_s:g} s") from None

    def listen(self, target: str) -> None:
        """See `PropertyClient.listen`."""
        path, _, tail = target.partition("?")
        with self._arrived:
            self._inbox.expect(path, tail)
        outcomes: SimpleQueue[Outcome] = SimpleQueue()
        self._session.listen(target, self._take, outcomes.put)
        _answer(outcomes.get()).value()

    def event(self, timeout_s: float | None = None) -> PropertyEvent | None:
        """See `PropertyClient.event`."""
        with self._arrived:
            self._arrived.wait_for(lambda: len(self._inbox) or self._why, timeout_s)
            event = self._inbox.take()
            if event is None and self._why:
                raise Unreachable(self._why)
            held, self._held = self._held, []
        for each in held:
            each.set_result(None)
        return event

    def close(self) -> None:
        """End the connection."""
        self._session.close()

    # On threads of Ice

    def _take(self, events: list[PropertyEvent]) -> object:
        with self._arrived:
            for event in events:
                self._inbox.put(event)
            self._arrived.notify()
            if len(self._inbox) < _MOST_EVENTS:
                return None
            self._held.append(protocol.runtime().ice.Future())
            return self._held[-1]

    def _went(self, why: str) -> None:
        with self._arrived:
            self._why = why
            self._arrived.notify()


def _answer(outcome: Outcome) -> Answer:
    if isinstance(outcome, Unreachable):
        raise outcome
    return outcome


def connect_ice(address: str, timeout_s: float) -> IceClient:
    """Connect to the Ice endpoint at ``ice://HOST:PORT[/SERVICE]``, with the user's secret.

    Raises:
        Malformed: It is no address.
        Refused: Ice is not there.
        Unreachable: There is no secret, or nobody answers there.
        PropertyError: ``denied``: the endpoint knows another secret.
    """
    from rtkit.link import secret

    where = read_address(address)
    protocol.runtime()
    return IceClient(where, secret.read(), timeout_s)
