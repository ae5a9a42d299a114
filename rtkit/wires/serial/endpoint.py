"""Serial endpoint of a service: the line protocol over a device that may damage lines, or be gone.

The peer of a serial line has no identity: the properties that it may set are listed by name. Its
end is not noticed either: listeners have a lease. On a line that devices share, a service takes
what is sent to its address, and says nothing unasked.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from logging import getLogger
from time import monotonic

from rtkit.errors import Malformed, Unreachable
from rtkit.property.access import NOBODY, AccessRule
from rtkit.property.addressed import ALL, AddressedRequests, addressed_reply
from rtkit.property.checked import CheckedRequests, frame
from rtkit.property.line import LineRequest
from rtkit.property.messages import Answer, PropertyEvent
from rtkit.property.subscription import Listener, leased
from rtkit.serving.event_loop import IOHandler, PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.serving.quota import EndpointQuota
from rtkit.wires.line.server_connection import Connection
from rtkit.wires.serial.address import (
    HELLO_TARGET,
    KNOWS_DEADLINES,
    SCHEME,
    SerialAddress,
    SerialEnd,
    read_address,
)
from rtkit.wires.wire import WireSettings

_FIRST_RETRY_S = 0.05
_LAST_RETRY_S = 1.0


class SerialEndpoint(IOHandler):
    """Opens a device, waits for it while it is not there, and opens it again.

    Args:
        service: The one that is meant where no other is named.
        settable: Patterns of names that may be set.

    Raises:
        Refused: It is no serial line, or pyserial is missing.
    """

    def __init__(
        self, host: PropertyEventLoop, address: SerialAddress, service: str, settable: Sequence[str]
    ) -> None:
        self._host = host
        self._address = address
        self._service = service
        self._clients: list[_SerialConnection] = []
        own = [AccessRule(True, "serial", NOBODY, "SET", each) for each in settable]
        self._quota = EndpointQuota(host.policy, "serial", lambda: self._clients, own)
        self._wait_s = 0.0
        self._try_at = 0.0
        self._is_open = False
        self._is_missed = False
        self._open()
        host.mark(self)

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`: try again, if it is time to."""
        if self._is_open or (now >= self._try_at and self._open()):
            return None
        if now >= self._try_at:
            self._wait_s = min(max(self._wait_s * 2, _FIRST_RETRY_S), _LAST_RETRY_S)
            self._try_at = now + self._wait_s
        return self._try_at

    def _open(self) -> bool:
        try:
            end = SerialEnd(self._address)
        except Unreachable as error:
            self._miss(str(error))
            return False
        if self._is_missed:
            getLogger("rtkit.properties").warning("%s is back", self._address)
        self._is_open, self._is_missed, self._wait_s, self._try_at = True, False, 0.0, 0.0
        self._clients = [
            _SerialConnection(self._host, end, self._service, self._address, self, self._quota)
        ]
        return True

    def _miss(self, why: str) -> None:
        if not self._is_missed:
            self._is_missed = True
            getLogger("rtkit.properties").warning("%s; waiting for it", why)

    def lost(self) -> None:
        """Handle the loss of the device."""
        self._is_open = False
        self._try_at = monotonic() + _FIRST_RETRY_S
        self._host.mark(self)


class _SerialConnection(Connection):
    """Client at the other end, as long as the device is there."""

    _requests: CheckedRequests

    def __init__(
        self,
        host: PropertyEventLoop,
        end: SerialEnd,
        service: str,
        address: SerialAddress,
        endpoint: SerialEndpoint,
        quota: EndpointQuota,
    ) -> None:
        super().__init__(host, end, service, "", None, quota)
        self.origin = endpoint
        self._endpoint = endpoint
        self._own = address.devices[0] if address.devices else ""
        self._requests = (
            AddressedRequests(self._own, address.has_checks)
            if self._own
            else CheckedRequests(address.has_checks)
        )
        self._sent_events: dict[Listener, PropertyEvent] = {}

    def _is_answered(self, data: bytes) -> bool:
        return False

    def _take(self, asked: LineRequest) -> None:
        if isinstance(self._requests, AddressedRequests) and self._requests.is_for_all:
            if asked.payload is not None and asked.error is None:
                self._dispatch(asked, lambda reply: None)
        else:
            super()._take(asked)

    def _write(self, message: bytes) -> None:
        if self._own:
            message = addressed_reply(message, self._own)
        super()._write(frame(message) if self._requests.has_checks else message)

    def _send_event(self, listener: Listener, event: PropertyEvent) -> None:
        if event.code:
            self._sent_events.pop(listener, None)
        else:
            self._sent_events[listener] = event
        super()._send_event(listener, event)

    def unlisten(self, listener: Listener) -> None:
        """See `Requester.unlisten`."""
        super().unlisten(listener)
        self._sent_events.pop(listener, None)

    def _dispatch(self, asked: LineRequest, answer: Callable[[Answer], None]) -> None:
        if asked.target == HELLO_TARGET and asked.payload is None:
            answer(Answer(KNOWS_DEADLINES))
            return
        name = asked.target.partition("?")[0]
        if self._own and name.endswith(".listen"):
            answer(Answer("on a shared line nobody speaks unasked", "denied"))
            return
        if asked.payload != "self" or not name.endswith(".listen"):
            super()._dispatch(asked, answer)
            return
        super()._dispatch(asked._replace(target=leased(asked.target)), answer)
        # Who goes on listening may have missed the last event.
        property_name = name.rpartition("/")[2].removesuffix(".listen")
        for listener, event in list(self._sent_events.items()):
            if listener.name == property_name and not listener.pending:
                super()._send_event(listener, event)

    def close(self) -> None:
        """See `Connection.close`."""
        if self.is_open:
            super().close()
            self._endpoint.lost()


def open_serial(device: str, provider: PropertyProvider, settings: WireSettings) -> str:
    """Open the serial endpoint of a service, now or when the device is there.

    Raises:
        Malformed: The address of the line, or that of the service on it, is none.
        Refused: It is no serial line, or pyserial is missing.
    """
    address = read_address(device)
    if len(address.devices) > 1 or ALL in address.devices:
        raise Malformed(f"a service has one address of its own: {device}")
    SerialEndpoint(settings.host, address, provider.name, settings.settable)
    return f"{SCHEME}{device.removeprefix(SCHEME)}"
