"""Checked lines, for wires that damage what they carry: ``line ~XXXX``.

The check is CRC-16/CCITT-FALSE over the bytes before the blank, four hexadecimal digits. A message
with bytes behind its line (``{n}``) is one line here, too: each byte in it that would end the line,
or that drivers swallow, goes as DLE and the byte with bit 6 turned. So what is damaged takes
nothing else along, and what stands in a value is never taken for a request.

Who begins with a checked line is answered with checked lines, until ``GET properties`` without a
check begins anew. Source: `property-service` reference, section 10.
"""

from __future__ import annotations

import binascii
import re
from collections.abc import Callable
from time import monotonic

from rtkit.property.codes import PropertyError
from rtkit.property.line import LONGEST_LINE, LineRequest, Replies, Requests, Splitter
from rtkit.property.messages import Answer, PropertyEvent

HELLO = b"GET properties"
"""First request of a conversation without checks."""
QUIET_S = 0.5
"""After how long a silence a line begins anew, where nobody knows where one begins [s]."""

CHECK = re.compile(rb"(.*) ~([0-9A-Fa-f]{4})", re.DOTALL)
"""Pattern of a line with a check."""
_CHECK_SIZE = len(" ~XXXX")
_SPECIAL = re.compile(rb"[\n\r\x10\x11\x13]")
_STUFFED = re.compile(rb"\x10(.)", re.DOTALL)
NOTHING = LineRequest("", "", None)
"""Placeholder of a line that is no request."""


def frame(message: bytes) -> bytes:
    """Return a message, with the end of its line, as it travels."""
    body = _SPECIAL.sub(_stuff, message.removesuffix(b"\n"))
    return b"%b ~%04X\n" % (body, binascii.crc_hqx(body, 0xFFFF))


def unframe(line: bytes) -> bytes | None:
    """Return the message that travelled as a line, without its end; None if it was damaged."""
    found = CHECK.fullmatch(line)
    if found is None or binascii.crc_hqx(found[1], 0xFFFF) != int(found[2], 16):
        return None
    return _STUFFED.sub(_unstuff, found[1])


def one_request(message: bytes, longest: int = LONGEST_LINE) -> LineRequest:
    """Return the request that a message is."""
    inner = Requests(longest)
    inner.feed(message + b"\n")
    asked = inner.next()
    if asked is None or (inner.waits and asked.error is None):
        refused = PropertyError("syntax", f"{len(message)} expected one request")
        return LineRequest("" if asked is None else asked.id, "", "", refused)
    return asked._replace(is_last=False)


def one_reply(message: bytes) -> tuple[str, Answer] | PropertyEvent | None:
    """Return the reply or event that a message is, None if it is neither."""
    replies = Replies()
    replies.feed(message + b"\n")
    try:
        return replies.next()
    except PropertyError:
        return None


def _stuff(found: re.Match[bytes]) -> bytes:
    return bytes((0x10, found[0][0] ^ 0x40))


def _unstuff(found: re.Match[bytes]) -> bytes:
    return bytes((found[1][0] ^ 0x40,))


class CheckedRequests(Requests):
    """Reads requests from a line that may damage them; damage never ends the conversation.

    Args:
        wanted: Whether there have to be checks; None: if the client makes them.
        clock: Tells the time [s].

    Attributes:
        has_checks: Whether the client checks, and is to be answered so.
    """

    def __init__(
        self,
        wanted: bool | None = None,
        longest: int = LONGEST_LINE,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        super().__init__(longest)
        self.has_checks = wanted is True
        self._wanted = wanted
        self._splitter = self._new_splitter()
        self._clock = clock
        self._fed_at = 0.0
        self._is_lost = False

    def feed(self, data: bytes) -> None:
        """Take what came; nothing, while it is not known where a line begins."""
        now, before = self._clock(), self._fed_at
        self._fed_at = now
        self._is_lost = self._is_lost and now - before < QUIET_S
        if not self._is_lost:
            super().feed(data)

    def next(self) -> LineRequest | None:
        """Return the next request, None if there is none yet; empty lines are none."""
        while (asked := super().next()) is NOTHING:
            pass
        if asked is None or not asked.is_last:
            return asked
        # The next bytes may belong to a value: they are not to be taken for requests.
        self._splitter, self._block = self._new_splitter(), None
        self._is_lost = True
        return asked._replace(is_last=False)

    def _new_splitter(self) -> Splitter:
        """Return what takes a line with a check whose every byte is stuffed."""
        return Splitter(self._longest if self._wanted is False else 2 * self._longest + _CHECK_SIZE)

    def _plain(self, raw: bytes) -> LineRequest | None:
        """Return the request that a line without a check is."""
        if len(raw) > self._longest:
            why = f"line is longer than {self._longest} bytes"
            return LineRequest("", "", "", PropertyError("too-large", why))
        return super()._request(raw)

    def _request(self, raw: bytes) -> LineRequest | None:
        if not raw.strip():
            return NOTHING
        if self._wanted is False:
            return self._plain(raw)
        message = unframe(raw)
        if message is None:
            is_hello = raw == HELLO and not self._wanted
            if CHECK.fullmatch(raw) or (self.has_checks and not is_hello):
                return LineRequest("", "", "", PropertyError("checksum", "the line is damaged"))
            self.has_checks = False
            return self._plain(raw)
        self.has_checks = True
        return one_request(message, self._longest)


class CheckedReplies:
    """Reads replies, events and damaged lines that a service sends over such a line."""

    def __init__(self, longest: int = 1 << 26) -> None:
        self._splitter = Splitter(longest)

    def feed(self, data: bytes) -> None:
        """Take what came."""
        self._splitter.feed(data)

    def next(self) -> tuple[str, Answer] | PropertyEvent | bytes | None:
        """Return the next reply with its id, or event, or line without a check that holds.

        None if there is none yet.
        """
        try:
            line = self._splitter.line()
        except PropertyError:
            return b""  # endless, which nothing that was sent is
        message = None if line is None else unframe(line)
        return line if message is None else one_reply(message) or line
