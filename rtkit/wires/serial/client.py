"""Client of the line protocol over a serial line, which may lose and damage what it carries.

Requests bear an id, so one that may not have arrived is asked again: repeated with its id it acts
once. A service that answers without checks, or without ids, gets requests without them; without
ids only requests without effect are repeated. A service does not notice that a client has left, so
the client listens with a lease.

See decision 24.
"""

from __future__ import annotations

import math
import os
import select
import time
from hashlib import blake2b
from time import monotonic

from rtkit.closing import Closing
from rtkit.errors import Unreachable
from rtkit.link.deadline import with_deadline
from rtkit.link.wakeup import Wakeup
from rtkit.property.checked import HELLO, CheckedReplies, frame
from rtkit.property.codes import PASSING, PropertyError
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.line import Replies, write_request
from rtkit.property.messages import Answer, Mark, Payload, PropertyEvent
from rtkit.property.subscription import LEASE_S, leased
from rtkit.wires.property_client import Inbox, bound_in
from rtkit.wires.serial.address import (
    HELLO_TARGET,
    KNOWS_DEADLINES,
    SerialAddress,
    SerialEnd,
    read_address,
)

_PATIENCE_S = 0.3
_LEAST_PATIENCE_S = 0.05
_TIMES_USUAL = 8
_LONGEST_PATIENCE_S = 3.0
_QUIET_S = 0.1
_PIECE = 1 << 16
_MOST_DRAINED = 10_000
_BITS_OF_BYTE = 10
_ALIKE = 3
"""How many answers without a check mean that the far side knows of none."""
_BELIEVED = 2
"""How many refusals that name no request are received until one counts as the answer."""

_KNOWS = Answer(KNOWS_DEADLINES)
_Received = tuple[str, Answer] | PropertyEvent | bytes
"""A reply with its id, an event, or a line without a check that holds."""


class SerialClient(Closing):
    """Conversation over a serial line; `connect_serial` makes it.

    Args:
        timeout_s: Bound on each request, beside the time that its bytes take [s].
    """

    def __init__(self, end: SerialEnd, address: SerialAddress, timeout_s: float) -> None:
        self._end = end
        self._address = address
        self._timeout_s = timeout_s
        self._has_ids = True
        self._has_deadlines = False
        self._replies: CheckedReplies | Replies = CheckedReplies()
        self._last_id = int.from_bytes(os.urandom(4), "big")
        self._inbox = Inbox()
        self._usual_s = _PATIENCE_S / _TIMES_USUAL
        self._seen: dict[str, Mark] = {}
        self._leases: dict[str, float] = {}
        self._wakeup = Wakeup()

    @property
    def has_checks(self) -> bool:
        """Return whether lines carry a check, in both directions."""
        return isinstance(self._replies, CheckedReplies)

    # How the far side talks

    def begin(self) -> None:
        """Find out how the far side talks.

        Raises:
            Unreachable: It says nothing.
        """
        if self._address.has_checks is not False and self._knows_checks():
            return
        self._replies = Replies()
        self._has_ids = False
        deadline = monotonic() + self._timeout_s
        self._exchange(HELLO + b"\n", "", deadline, may_repeat=True)
        id = self._next_id()
        hello = write_request(HELLO_TARGET, None, id)
        received = self._exchange(hello, id, deadline, may_repeat=True)
        self._has_ids, self._has_deadlines = received.error != "syntax", received == _KNOWS
        self._drain(_QUIET_S)

    def _knows_checks(self) -> bool:
        """Ask something that has no effect until a line with a check comes."""
        deadline = monotonic() + self._timeout_s
        patience, plain = _PATIENCE_S, 0
        while monotonic() < deadline:
            id = self._next_id()
            self._send(self._encoded(write_request(HELLO_TARGET, None, id)), deadline)
            until = min(deadline, monotonic() + patience)
            while (received := self._receive(until)) is not None:
                if not isinstance(received, bytes):
                    self._has_deadlines |= (
                        not isinstance(received, PropertyEvent) and received[1] == _KNOWS
                    )
                    return True
                is_plain = received.startswith((b"! ", f"#{id} ".encode()))
                if is_plain and not received.startswith(b"! checksum"):
                    plain += 1
                    break
            if plain == _ALIKE and self._address.has_checks is None:
                return False
            patience = min(patience * 2, _LONGEST_PATIENCE_S)
        raise self._silence()

    def _encoded(self, message: bytes) -> bytes:
        # A line of noise that has no end is ended before.
        return b"\n" + frame(message) if self.has_checks else message

    def _next_id(self) -> str:
        self._last_id = (self._last_id + 1) & 0xFFFFFFFF
        return f"{self._last_id:08x}"

    # Requests

    def ask(
        self,
        target: str,
        payload: Payload | None = None,
        same_as: str = "",
        until: float = math.inf,
    ) -> Answer:
        """GET, or SET, and wait for the reply.

        Args:
            target: Name and parameters.
            payload: None of a GET.
            same_as: What was asked with the same text is the same request, however long ago.
            until: When it is given up, by the monotonic clock here, if not before [s]. A far side
                that says that it knows deadlines does not begin it later.

        Raises:
            Unreachable: No reply in time, or the device is gone.
        """
        id = "" if not self._has_ids else _short(same_as) if same_as else self._next_id()
        if monotonic() > until:
            return Answer(NOT_BEGUN, "timeout")
        data = self._encoded(write_request(target, payload, id))
        bound_s = bound_in(target, self._timeout_s)
        deadline = min(until, monotonic() + bound_s + self._duration_s(data))
        if payload is not None and self._has_deadlines:
            data = self._encoded(write_request(with_deadline(target, deadline), payload, id))
        return self._exchange(data, id, deadline, may_repeat=bool(id) or payload is None)

    def _duration_s(self, data: bytes) -> float:
        """Return how long a request, and a reply as long, take on the line [s]."""
        return 2 * len(data) * _BITS_OF_BYTE / self._address.baud

    def _exchange(self, data: bytes, id: str, deadline: float, *, may_repeat: bool) -> Answer:
        usual = max(_LEAST_PATIENCE_S, min(_TIMES_USUAL * self._usual_s, _LONGEST_PATIENCE_S))
        patience = usual + self._duration_s(data)
        refused: list[Answer] = []
        while True:
            if not id:
                self._drain()  # whatever comes now is no answer to what is still to be asked
            self._send(data, deadline)
            begin = monotonic()
            until = min(deadline, begin + patience) if may_repeat else deadline
            received = self._next_reply(id, until)
            if received is not None:
                answer = received[1]
                if received[0] == id and (answer.error != "checksum" or not may_repeat):
                    self._usual_s += (monotonic() - begin - self._usual_s) / _TIMES_USUAL
                    return answer
                refused.append(answer)
                again = [each.error for each in refused].count(answer.error)
                if answer.error != "checksum" and again >= _BELIEVED:
                    return answer
            patience = min(patience * 2, max(patience, _LONGEST_PATIENCE_S))
            if monotonic() >= deadline:
                if refused:
                    return refused[-1]
                raise self._silence()

    def _next_reply(self, id: str, until: float) -> tuple[str, Answer] | None:
        """Return the reply to a request, or a refusal without a request; None in silence."""
        while (received := self._receive(until)) is not None:
            if isinstance(received, PropertyEvent):
                self._keep(received)
            elif isinstance(received, bytes):
                if received.strip() and self.has_checks:
                    return "", Answer("the line is damaged", "checksum")
            elif received[0] == id or (not received[0] and received[1].error):
                return received
        return None

    def _silence(self) -> Unreachable:
        return Unreachable(f"no answer within {self._timeout_s:g} s: {self._address}")

    # Events

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

    # The line

    def _drain(self, quiet_s: float = 0.0) -> None:
        """Take what has come, until nothing has for some time [s]."""
        for _ in range(_MOST_DRAINED):
            received = self._receive(monotonic() + quiet_s)
            if received is None:
                return
            if isinstance(received, PropertyEvent):
                self._keep(received)

    def _receive(self, until: float | None, *, may_wake: bool = False) -> _Received | None:
        while True:
            try:
                received = self._replies.next()
            except PropertyError:
                return b""  # no reply at all
            if received is not None:
                return received
            left = None if until is None else max(0.0, until - monotonic())
            if not self._is_ready(select.POLLIN, left, may_wake=may_wake):
                return None
            self._read()

    def _read(self) -> None:
        try:
            data = self._end.recv(_PIECE)
        except BlockingIOError:
            return
        except OSError as error:
            raise self._gone() from error
        if not data:
            raise self._gone()
        self._replies.feed(data)

    def _send(self, data: bytes, deadline: float) -> None:
        rest = memoryview(data)
        while rest:
            try:
                rest = rest[self._end.send(rest) :]
            except BlockingIOError:
                left = deadline - monotonic()
                if left <= 0:
                    raise self._silence() from None
                # The far side may wait until what it says is read.
                if self._is_ready(select.POLLIN | select.POLLOUT, left):
                    self._read()
            except OSError as error:
                raise self._gone() from error

    def _gone(self) -> Unreachable:
        return Unreachable(f"the connection has ended: {self._address} is unplugged or closed")

    def _is_ready(self, mask: int, wait_s: float | None, *, may_wake: bool = False) -> bool:
        poll = select.poll()
        try:
            poll.register(self._end, mask)
            if may_wake:
                poll.register(self._wakeup, select.POLLIN)
        except (ValueError, OSError):  # another thread has closed it
            raise self._gone() from None
        ready = poll.poll(None if wait_s is None else wait_s * 1000)
        return any(number != self._wakeup.fileno() for number, _ in ready)

    def close(self) -> None:
        """End the conversation."""
        self._end.close()
        self._wakeup.close()


def _short(id: str) -> str:
    """Return an id as long as a small device takes it."""
    return blake2b(id.encode(), digest_size=4).hexdigest()


def connect_serial(address: str, timeout_s: float) -> SerialClient:
    """Begin a conversation over ``serial:DEVICE[?baud=N&check=auto|1|0]``.

    Raises:
        Malformed: It is no such address.
        Unreachable: There is no such device, or nobody answers.
        Refused: It is no serial line, or pyserial is missing.
    """
    known = read_address(address)
    client = SerialClient(SerialEnd(known), known, timeout_s)
    try:
        client.begin()
    except BaseException:
        client.close()
        raise
    return client
