"""Exchange of requests and replies over a serial line, which may lose and damage what it carries.

Requests bear an id, so one that may not have arrived is asked again: repeated with its id it acts
once. A service that answers without checks, or without ids, gets requests without them; without
ids only requests without effect are repeated.

See decision 24.
"""

from __future__ import annotations

import math
import os
import select
from hashlib import blake2b
from time import monotonic

from rtkit.closing import Closing
from rtkit.errors import Unreachable
from rtkit.link.deadline import with_deadline
from rtkit.link.wakeup import Wakeup
from rtkit.property.checked import HELLO, CheckedReplies, frame
from rtkit.property.codes import PropertyError
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.line import Replies, write_request
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.property.naming import without_parameter
from rtkit.wires.property_client import bound_in
from rtkit.wires.serial.address import HELLO_TARGET, KNOWS_DEADLINES, SerialAddress, SerialEnd

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
Received = tuple[str, Answer] | PropertyEvent | bytes
"""A reply with its id, an event, or a line without a check that holds."""


class Silence(Unreachable):
    """The far side has not answered in time."""


class SerialExchange(Closing):
    """One request at a time over a serial line, and its reply.

    Args:
        timeout_s: Bound on each request, beside the time that its bytes take [s].

    Attributes:
        has_checks: Whether lines carry a check, in both directions.
    """

    _first_patience_s = 0.3

    def __init__(
        self, end: SerialEnd, settings: SerialAddress, timeout_s: float, wakeup: Wakeup
    ) -> None:
        self._end = end
        self._settings = settings
        self._timeout_s = timeout_s
        self._wakeup = wakeup
        self._has_ids = True
        self._has_deadlines = False
        self._replies: CheckedReplies | Replies
        self._talk(has_checks=True)
        self._last_id = int.from_bytes(os.urandom(4), "big")
        self._usual_s = self._first_patience_s / _TIMES_USUAL

    # How the far side talks

    def begin(self, within_s: float = math.inf) -> None:
        """Find out how the far side talks, before the time-out, or sooner [s].

        Raises:
            Silence: It says nothing.
        """
        within_s = min(within_s, self._timeout_s)
        self._has_ids = True
        self._talk(has_checks=True)
        if self._settings.has_checks is not False and self._knows_checks(within_s):
            return
        self._talk(has_checks=False)
        self._has_ids = False
        deadline = monotonic() + within_s
        self._exchange(self._encoded(HELLO + b"\n"), "", deadline, may_repeat=True)
        id = self._next_id()
        hello = self._encoded(write_request(HELLO_TARGET, None, id))
        received = self._exchange(hello, id, deadline, may_repeat=True)
        self._has_ids, self._has_deadlines = received.error != "syntax", received == _KNOWS
        self._drain(_QUIET_S)

    def _talk(self, *, has_checks: bool) -> None:
        """Send and expect lines with a check, or without, from now on."""
        self.has_checks = has_checks
        self._replies = CheckedReplies() if has_checks else Replies()

    def _knows_checks(self, within_s: float) -> bool:
        """Ask something that has no effect until a line with a check comes."""
        deadline = monotonic() + within_s
        patience, plain = self.usual_wait_s, 0
        while monotonic() < deadline:
            id = self._next_id()
            hello = self._encoded(write_request(HELLO_TARGET, None, id))
            self._send(hello, deadline)
            until = min(deadline, monotonic() + patience + self._duration_s(hello))
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
            if plain == _ALIKE and self._settings.has_checks is None:
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
            Silence: No reply in time.
            Unreachable: The device is gone.
        """
        id = "" if not self._has_ids else _short(same_as) if same_as else self._next_id()
        if monotonic() > until:
            return Answer(NOT_BEGUN, "timeout")
        bound_s = bound_in(target, self._timeout_s)
        if not self._has_deadlines:  # of proxies: a small device knows no such parameter
            target = without_parameter(target, "timeout")
        data = self._encoded(write_request(target, payload, id))
        deadline = min(until, monotonic() + bound_s + self._duration_s(data))
        if payload is not None and self._has_deadlines:
            data = self._encoded(write_request(with_deadline(target, deadline), payload, id))
        return self._exchange(data, id, deadline, may_repeat=bool(id) or payload is None)

    @property
    def usual_wait_s(self) -> float:
        """Return how long an answer is waited for until it is asked again [s]."""
        return max(_LEAST_PATIENCE_S, min(_TIMES_USUAL * self._usual_s, _LONGEST_PATIENCE_S))

    def _duration_s(self, data: bytes) -> float:
        """Return how long a request, and a reply as long, take on the line [s]."""
        return 2 * len(data) * _BITS_OF_BYTE / self._settings.baud

    def _exchange(self, data: bytes, id: str, deadline: float, *, may_repeat: bool) -> Answer:
        patience = self.usual_wait_s + self._duration_s(data)
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

    def _silence(self) -> Silence:
        return Silence(f"no answer within {self._timeout_s:g} s: {self._settings}")

    # The line

    def _keep(self, event: PropertyEvent) -> None:
        """Take an event that came."""

    def _drain(self, quiet_s: float = 0.0) -> None:
        """Take what has come, until nothing has for some time [s]."""
        for _ in range(_MOST_DRAINED):
            received = self._receive(monotonic() + quiet_s)
            if received is None:
                return
            if isinstance(received, PropertyEvent):
                self._keep(received)

    def _receive(self, until: float | None, *, may_wake: bool = False) -> Received | None:
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
        return Unreachable(f"the connection has ended: {self._settings} is unplugged or closed")

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
