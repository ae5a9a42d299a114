"""Events of the connectors of a data port, for whoever listens to them.

A port without listeners has no part in this: its ways from and into buffers are the bare ones. See
decision 97.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import partial
from typing import Any, Generic, TypeVar, cast

from rtkit.component.contexts import callbacks
from rtkit.component.current import current
from rtkit.component.ports.buffer import AwaitedRing, Buffer, Pulled, Ring, Sink
from rtkit.component.ports.options import PortStatus, parse_options
from rtkit.rtc.profiles import ConnectorProfile

T = TypeVar("T")


class ConnectorEvent(StrEnum):
    """Something that happens at one end of a connector.

    An out port has a buffer where a connector is pulled, periodic or skips values; the one of
    subscription type ``new`` counts as one that is emptied at once.
    """

    CONNECTED = "connected"
    DISCONNECTED = "disconnected"
    SENT = "sent"
    """The out port sends a value: a listener may replace it."""
    RECEIVED = "received"
    """A value came to the in port: a listener may replace it. At the out port: it was taken."""
    RECEIVER_FULL = "receiver full"
    RECEIVER_TIMEOUT = "receiver time-out"
    RECEIVER_ERROR = "receiver error"
    """The value did not come into the in port, because its buffer was full, remained full, or is
    not there any more."""
    WRITTEN = "written"
    """A value is in the buffer."""
    OVERWRITTEN = "overwritten"
    """A value is in the buffer, and the oldest one is lost."""
    FULL = "full"
    WRITE_TIMEOUT = "write time-out"
    """The buffer took no value: it was full, or remained full."""
    READ = "read"
    """A value left the buffer: a listener at the in port may replace it."""
    EMPTY = "empty"
    READ_TIMEOUT = "read time-out"
    """The buffer had no value, or remained empty."""
    SENDER_EMPTY = "sender empty"
    SENDER_TIMEOUT = "sender time-out"
    """Somebody who pulls got no value, because none was there, or none came."""


ConnectorListener = Callable[[ConnectorProfile, Any], Any]
"""Is given the connector, and the value that an event is of, else None.

It runs on the thread that causes the event, and returns None, or a value to go on with.
"""
_E = ConnectorEvent
_TAKEN = (_E.WRITTEN,)
_NOT_TAKEN: Mapping[PortStatus, tuple[ConnectorEvent, ...]] = {
    PortStatus.FULL: (_E.FULL,),
    PortStatus.TIMEOUT: (_E.WRITE_TIMEOUT,),
}
_NOT_RECEIVED: Mapping[PortStatus, ConnectorEvent] = {
    PortStatus.FULL: _E.RECEIVER_FULL,
    PortStatus.TIMEOUT: _E.RECEIVER_TIMEOUT,
}


class ConnectorListeners:
    """Those who listen to the connectors of one port.

    Args:
        port: Name of the port.
        end: Which end of its connectors it is, 0 the out port.
        fit: Returns the value that readers get for one of a listener; raises where none fits.
    """

    def __init__(self, port: str, end: int, fit: Callable[[ConnectorProfile, Any], Any]) -> None:
        self._port = port
        self._end = end
        self._fit = fit
        self._by_event: dict[ConnectorEvent, tuple[ConnectorListener, ...]] = {}
        self._failures: dict[ConnectorEvent, str] = {}

    def __len__(self) -> int:
        return sum(map(len, self._by_event.values()))

    def add(self, event: ConnectorEvent, listener: ConnectorListener) -> None:
        """Have a listener called, after the others of this event."""
        self._by_event[event] = (*self._by_event.get(event, ()), listener)

    def remove(self, event: ConnectorEvent, listener: ConnectorListener) -> None:
        """Call a listener no more; ignore one that is none."""
        there = self._by_event.get(event, ())
        self._by_event[event] = tuple(each for each in there if each != listener)

    def notify(self, event: ConnectorEvent, connector: ConnectorProfile, value: Any = None) -> Any:
        """Call the listeners of an event; return the value to go on with.

        What a listener raises ends nothing but its own part in this, and is logged when it is new.
        """
        listeners = self._by_event.get(event)
        if not listeners:
            return value
        before = current.set(self.owner(connector))
        try:
            for listener in listeners:
                value = self._call(listener, event, connector, value)
        finally:
            current.reset(before)
        return value

    def _call(
        self,
        listener: ConnectorListener,
        event: ConnectorEvent,
        connector: ConnectorProfile,
        value: Any,
    ) -> Any:
        try:
            given = listener(connector, value)
            if value is not None and given is not None and given is not value:
                return self._fit(connector, given)
        except callbacks.escaping:
            raise
        except BaseException as error:
            self._report(event, connector, listener, error)
        return value

    def _report(
        self,
        event: ConnectorEvent,
        connector: ConnectorProfile,
        listener: ConnectorListener,
        error: BaseException,
    ) -> None:
        import logging  # rarely needed, and large

        why = callbacks.describe_failure(error, listener)
        if why != self._failures.get(event):
            self._failures[event] = why
            owner = self.owner(connector) or __name__
            text = "port %s: listener of %s failed: %s"
            logging.getLogger(owner).error(text, self._port, event, why, exc_info=error)

    def owner(self, connector: ConnectorProfile) -> str:
        """Return the name of the component at this end of a connector; empty where none is."""
        return connector.ports[self._end].instance if connector.ports else ""


def receiving(
    listeners: ConnectorListeners, connector: ConnectorProfile, buffer: object, write: Sink[T]
) -> Sink[T]:
    """Return a sink that tells what becomes of the values that come to an in port."""
    keep = buffering(listeners, connector, buffer, write)
    notify = listeners.notify

    def receive(value: T) -> PortStatus | None:
        value = notify(_E.RECEIVED, connector, value)
        refused = keep(value)
        if refused is not None:
            notify(_NOT_RECEIVED.get(refused, _E.RECEIVER_ERROR), connector, value)
        return refused

    return receive


def buffering(
    listeners: ConnectorListeners, connector: ConnectorProfile, buffer: object, write: Sink[T]
) -> Sink[T]:
    """Return a sink that tells what becomes of the values for a buffer."""
    overwriting = buffer if isinstance(buffer, Ring | AwaitedRing) else None
    notify = listeners.notify

    def keep(value: T) -> PortStatus | None:
        is_full = overwriting is not None and len(overwriting) >= overwriting.length
        refused = write(value)
        for event in _TAKEN if refused is None else _NOT_TAKEN.get(refused, ()):
            if is_full:
                notify(_E.OVERWRITTEN, connector, value)
            notify(event, connector, value)
        return refused

    return keep


def sending(listeners: ConnectorListeners, connector: ConnectorProfile, sink: Sink[T]) -> Sink[T]:
    """Return a sink that tells what becomes of the values that an out port sends at once."""
    is_buffered = parse_options(connector.properties).subscription == "new"
    before = (_E.WRITTEN, _E.READ, _E.SENT) if is_buffered else (_E.SENT,)

    def send(value: T) -> PortStatus | None:
        for event in before:
            value = listeners.notify(event, connector, value)
        return report_outcome(listeners, connector, value, sink(value))

    return send


def send_buffered(
    listeners: ConnectorListeners, connector: ConnectorProfile, sink: Sink[T], value: T
) -> PortStatus | None:
    """Send a value that was in the buffer of an out port, and tell what becomes of it."""
    value = listeners.notify(_E.READ, connector, value)
    value = listeners.notify(_E.SENT, connector, value)
    return report_outcome(listeners, connector, value, sink(value))


def report_outcome(
    listeners: ConnectorListeners,
    connector: ConnectorProfile,
    value: object,
    refused: PortStatus | None,
) -> PortStatus | None:
    """Tell, and return, whether the receiver has taken a value."""
    missed = _NOT_RECEIVED.get(refused, _E.RECEIVER_ERROR) if refused is not None else None
    listeners.notify(missed or _E.RECEIVED, connector, value)
    return refused


def give(
    listeners: ConnectorListeners, connector: ConnectorProfile, value: T | None, *, has_waited: bool
) -> T | None:
    """Tell what somebody pulls from the buffer of an out port; return the value to give."""
    notify = listeners.notify
    if value is not None:
        return cast(T, notify(_E.SENT, connector, notify(_E.READ, connector, value)))
    for event in (
        (_E.READ_TIMEOUT, _E.SENDER_TIMEOUT) if has_waited else (_E.EMPTY, _E.SENDER_EMPTY)
    ):
        notify(event, connector)
    return None


class NotifyingBuffer(Generic[T]):
    """The buffer of an in port, which tells what leaves it."""

    def __init__(
        self,
        listeners: ConnectorListeners,
        connector: ConnectorProfile,
        buffer: Buffer[T],
        *,
        waits: bool,
    ) -> None:
        self._notify = partial(listeners.notify, connector=connector)
        self._buffer = buffer
        self._is_pulled = isinstance(buffer, Pulled)
        self._awaited = _E.READ_TIMEOUT if waits else _E.EMPTY

    def __len__(self) -> int:
        return len(self._buffer)

    def take(self) -> T | None:
        """Remove and return the oldest value, None when empty; never wait."""
        return self._taken(self._buffer.take(), _E.EMPTY)

    def wait(self) -> T | None:
        """Do the same, and wait for a value if the policy says so."""
        return self._taken(self._buffer.wait(), self._awaited)

    def close(self) -> None:
        """Accept no more values and wake whoever waits."""
        self._buffer.close()

    def _taken(self, value: T | None, otherwise: ConnectorEvent) -> T | None:
        if value is None:
            for event in (_E.SENDER_EMPTY, otherwise) if self._is_pulled else (otherwise,):
                self._notify(event)
            return None
        for event in (_E.RECEIVED, _E.WRITTEN, _E.READ) if self._is_pulled else (_E.READ,):
            value = self._notify(event, value=value)
        return value
