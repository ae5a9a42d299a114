"""Subscriber over Ice: one call at a time, with all events since the last one."""

from __future__ import annotations

from typing import Any, Protocol

from rtkit.property.messages import PropertyEvent
from rtkit.property.subscription import Listener
from rtkit.serving.event_loop import IOHandler, PropertyEventLoop
from rtkit.serving.quota import EndpointQuota, SubscribingClient
from rtkit.wires.ice import protocol

STUCK_S = 30.0
"""Time-out of events that wait for delivery, and of half a message or an answer [s]."""
_ROOM_FOR_EVENTS = 1 << 18
_MOST_EVENTS = 1000
_MOST_FAILURES = 3


class SubscribedClient(Protocol):
    """Client of the endpoint as its subscribers know it."""

    identity: str

    @property
    def listening(self) -> int:
        """Return how many listeners all of its subscribers have."""

    def drop(self, subscription: IceSubscriber) -> None:
        """Forget a subscriber that has no listeners, or cannot be called."""

    def cut_off(self) -> None:
        """Close the connection: it takes no events."""


class IceSubscriber(IOHandler, SubscribingClient):
    """Subscriber: events that come during a call wait here, bounded, for the next call.

    Args:
        key: The identity of who is called.
        proxy: Of who is called.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        client: SubscribedClient,
        key: str,
        proxy: Any,
        quota: EndpointQuota,
    ) -> None:
        super().__init__(quota, client.identity)
        self.key = key
        self._host = host
        self._client = client
        bounded = proxy.ice_invocationTimeout(int(STUCK_S * 1000))
        self._proxy = protocol.runtime().slice.ListenerPrx.uncheckedCast(bounded)
        self._is_called = False
        self._failures = 0

    def listen(self, listener: Listener) -> None:
        """See `Requester.listen`."""
        self._quota.check_listeners(self._client.listening)
        self.listeners.append(listener)

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`."""
        if self._is_called:
            return None
        events: list[PropertyEvent] = []
        size = 0

        def take(_: Listener, event: PropertyEvent) -> None:
            nonlocal size
            size += len(event.payload)
            events.append(event)

        due = self.send_due(
            now, lambda: size < _ROOM_FOR_EVENTS and len(events) < _MOST_EVENTS, take
        )
        if events:
            self._call(events)
            return None
        if not self.listeners:
            self._client.drop(self)
        return due

    def _call(self, events: list[PropertyEvent]) -> None:
        self._is_called = True
        try:
            future = self._proxy.hearAsync([protocol.write_event(each) for each in events])
        except protocol.runtime().ice.Exception as error:
            self._on_sent(error)
            return
        future.add_done_callback(lambda done: self._host.post(lambda: self._on_sent(_error(done))))

    def _on_sent(self, error: Exception | None) -> None:
        runtime = protocol.runtime().ice
        self._is_called = False
        self._failures = 0 if error is None else self._failures + 1
        if isinstance(error, runtime.InvocationTimeoutException):
            self._client.cut_off()
        elif isinstance(error, runtime.RequestFailedException) or self._failures >= _MOST_FAILURES:
            self._client.drop(self)
        else:
            self._host.mark(self)


def _error(future: Any) -> Exception | None:
    try:
        future.result()
    except Exception as error:
        return error
    return None
