"""Addressed lines, for one line that many devices share: ``@7 GET speed``, ``@7: = 0.25``.

One asks, and waits for the reply before the next request; a device speaks only when it is asked by
its address. What is sent to `ALL` is taken by each device and answered by none. What is damaged
is answered by nobody, since anybody may have been meant. The check of a line covers the address.
"""

from __future__ import annotations

import re

from rtkit.property.checked import (
    CHECK,
    HELLO,
    NOTHING,
    CheckedReplies,
    CheckedRequests,
    one_reply,
    one_request,
    unframe,
)
from rtkit.property.codes import PropertyError
from rtkit.property.line import LineRequest
from rtkit.property.messages import Answer, PropertyEvent

ALL = "all"
"""Address of all devices."""
SILENT = "silent"
"""Name by which a line tells which devices do not answer; no address."""
MOST = 1000
"""Devices on a line."""

_WORD = re.compile(r"[A-Za-z0-9_]{1,12}")
_RANGE = re.compile(r"(\d{1,6})-(\d{1,6})")


def read_addresses(text: str) -> tuple[str, ...]:
    """Read ``7``, ``1-20,base``.

    Raises:
        ValueError: It is something else, names one twice, or too many.
    """
    found: list[str] = []
    for each in text.split(","):
        span = _RANGE.fullmatch(each)
        if span is not None and int(span[1]) <= int(span[2]) < int(span[1]) + MOST:
            found += map(str, range(int(span[1]), int(span[2]) + 1))
        elif _WORD.fullmatch(each) and each not in (SILENT, "properties"):
            found.append(each)
        else:
            raise ValueError(f"no address: {each!r} (letters, digits and _, as 7, base, 1-20)")
    if len(set(found)) != len(found) or len(found) > MOST or (ALL in found and len(found) > 1):
        raise ValueError(f"each address once, {ALL} alone, and at most {MOST}: {text}")
    return tuple(found)


def addressed(message: bytes, address: str) -> bytes:
    """Return a request as a device is asked."""
    return b"@%b %b" % (address.encode(), message)


def addressed_reply(message: bytes, address: str) -> bytes:
    """Return a reply as a device sends it."""
    return b"@%b: %b" % (address.encode(), message)


class AddressedRequests(CheckedRequests):
    """Reads lines that are meant for one device; passes over lines for others, or damaged ones.

    Args:
        wanted: Whether there have to be checks; None: if the client makes them.

    Attributes:
        is_for_all: Whether the last request was for all devices, so that nobody answers.
    """

    def __init__(self, address: str, wanted: bool | None = None) -> None:
        super().__init__(wanted)
        self._own = addressed(b"", address), addressed(b"", ALL)
        self.is_for_all = False

    def next(self) -> LineRequest | None:
        """See `CheckedRequests.next`; a line without an end is nothing, too."""
        while (asked := super().next()) is not None and asked.error is not None:
            if asked.error.code != "too-large" or asked.target:
                break
        return asked

    def _request(self, raw: bytes) -> LineRequest | None:
        message = None if self._wanted is False else unframe(raw)
        line = raw if message is None else message
        own = next((each for each in self._own if line.startswith(each)), None)
        if own is None:
            return NOTHING
        line = line[len(own) :]
        if message is None and self._wanted is not False:
            is_hello = line == HELLO and not self._wanted
            if CHECK.fullmatch(raw) or (self.has_checks and not is_hello) or self._wanted:
                return NOTHING
        self.has_checks = message is not None
        self.is_for_all = own is self._own[1]
        return one_request(line)


class AddressedReplies(CheckedReplies):
    """Reads the replies of one device; passes over all other lines.

    Args:
        has_checks: Whether the lines of the device have a check.
    """

    def __init__(self, address: str, *, has_checks: bool) -> None:
        super().__init__()
        self._prefix = addressed_reply(b"", address)
        self._has_checks = has_checks

    def next(self) -> tuple[str, Answer] | PropertyEvent | bytes | None:
        """See `CheckedReplies.next`."""
        while True:
            try:
                line = self._splitter.line()
            except PropertyError:
                continue
            if line is None:
                return None
            message = unframe(line) if self._has_checks else line
            text = line if message is None else message
            if text.startswith(self._prefix):
                text = text[len(self._prefix) :]
                return (None if message is None else one_reply(text)) or text
