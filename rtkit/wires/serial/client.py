"""Client of the line protocol over a serial line: requests and events of the one service there.

A service does not notice that a client has left, so the client listens with a lease.

See decision 24.
"""

from __future__ import annotations

import time
from time import monotonic

from rtkit.link.wakeup import Wakeup
from rtkit.property.codes import PASSING, PropertyError
from rtkit.property.messages import Answer, Mark, PropertyEvent
from rtkit.property.subscription import LEASE_S, leased
from rtkit.wires.property_client import Inbox
from rtkit.wires.serial.address import SerialAddress, SerialEnd, read_address
from rtkit.wires.serial.exchange import SerialExchange
from rtkit.wires.serial.shared_line import SharedLine


class SerialClient(SerialExchange):
    """Conversation over a serial line; `connect_serial` makes it.

    Args:
        timeout_s: Bound on each request, beside the time that its bytes take [s].
    """

    def __init__(self, end: SerialEnd, settings: SerialAddress, timeout_s: float) -> None:
        super().__init__(end, settings, timeout_s, Wakeup())
        self._inbox = Inbox()
        self._seen: dict[str, Mark] = {}
        self._leases: dict[str, float] = {}

    def listen(self, target: str) -> None:
        """See `PropertyClient.listen`."""
        name, mark, tail = target.partition("?")
        self._inbox.expect(name, tail)
        asked = f"{name}.listen{mark}{tail}"
        request = leased(asked, LEASE_S)
        if request != asked:
            self._leases[request] = monotonic() + LEASE_S / 3
        try:
            self.ask(request, "self").value()
        except PropertyError:
            self._leases.pop(request, None)
            raise

    def leave(self, name: str) -> Answer:
        """Listen to a property no longer."""
        self._forget(name)
        return self.ask(f"{name}.listen?remove", "self")

    def _forget(self, name: str) -> None:
        ended = f"{name}.listen"
        for request in [each for each in self._leases if each.partition("?")[0] == ended]:
            del self._leases[request]

    def wake(self) -> None:
        """Make `event` return None at once, or as soon as it is called; from any thread."""
        self._wakeup.ring()

    def event(self, timeout_s: float | None = None) -> PropertyEvent | None:
        """See `PropertyClient.event`."""
        deadline = None if timeout_s is None else monotonic() + timeout_s
        while True:
            self._drain()
            known = self._inbox.take()
            if known is not None:
                return known
            now = monotonic()
            if self._wakeup.hush() or (deadline is not None and now >= deadline):
                return None
            times = [each for each in (deadline, *self._leases.values()) if each is not None]
            received = self._receive(min(times, default=None), may_wake=True)
            if isinstance(received, PropertyEvent):
                self._keep(received)
            self._renew()

    def _renew(self) -> None:
        """Go on listening; the far side then repeats its last event, in case it was lost."""
        now = monotonic()
        for request in [each for each, at in self._leases.items() if at <= now]:
            self._leases[request] = now + LEASE_S / 3
            answer = self.ask(request, "self")
            if answer.error and answer.error not in PASSING:
                name = request.partition("?")[0].removesuffix(".listen")
                self._keep(PropertyEvent(name, "", time.time(), 0, "bad", 0, answer.error))

    def _keep(self, event: PropertyEvent) -> None:
        if (event.revision or event.time) and self._seen.get(event.name) == event.mark:
            return
        self._seen[event.name] = event.mark
        if event.code:
            self._forget(event.name)
        self._inbox.put(event)


def connect_serial(address: str, timeout_s: float) -> SerialClient | SharedLine:
    """Begin a conversation over ``serial:DEVICE[?baud=N&check=auto|1|0&address=LIST]``.

    Raises:
        Malformed: It is no such address.
        Unreachable: There is no such device, or nobody answers.
        Refused: It is no serial line, or pyserial is missing.
    """
    known = read_address(address)
    end = SerialEnd(known)
    if known.devices:
        return SharedLine(end, known, timeout_s)
    client = SerialClient(end, known, timeout_s)
    try:
        client.begin()
    except BaseException:
        client.close()
        raise
    return client
