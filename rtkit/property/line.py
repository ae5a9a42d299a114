"""Line protocol: requests, replies and events as bytes, read piece by piece, memory bounded.

::

    request  = [ "#" id " " ] ( "GET " target | "SET " target " " payload ) LF
    reply    = [ "#" id " " ] ( "=" [ " " payload ] | "!" " " code [ " " text ] ) LF
    event    = "*" " " target [ ";" attrs ] " " payload LF
    payload  = value without raw LF | "{" length "}" LF bytes

Source: `property-service` reference, section 10.
"""

from __future__ import annotations

import re
from collections import deque
from functools import lru_cache
from typing import NamedTuple

from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, Payload, PropertyEvent, text_or_bytes

LONGEST_LINE = (1 << 20) + 1024
"""Bytes of a line; a value and its target fit in."""
LONGEST_ID = 64
_SHORT = 1 << 12
"""Length of a payload that is worth remembering."""

_BLOCK = re.compile(rb"\{(\d{1,18})\}")
_LOOKS_LIKE_BLOCK = re.compile(r"\{\d*\}")


class LineRequest(NamedTuple):
    """Request, or the error of a line that cannot be one.

    Attributes:
        payload: None of a GET.
        error: Why it is none; then `payload` is empty.
        is_last: Nothing can be read after it.
    """

    id: str
    target: str
    payload: Payload | None
    error: PropertyError | None = None
    is_last: bool = False


class _Block(NamedTuple):
    """Request whose bytes are still to come."""

    asked: LineRequest
    length: int


class Splitter:
    """Splits bytes into lines, and into blocks of bytes where a line announces one."""

    def __init__(self, longest: int = LONGEST_LINE) -> None:
        self._longest = longest
        self._buffer = bytearray()
        self._whole: deque[bytes] = deque()
        self._is_skipping = False
        self._searched = 0

    def feed(self, data: bytes) -> None:
        """Take what came."""
        if self._buffer or self._whole or self._is_skipping or data[-1:] != b"\n":
            self._buffer += data
        elif len(data) <= self._longest:
            # Nearly always whole lines arrive: they need not pass the buffer.
            self._whole.extend(data[:-1].split(b"\n"))
        else:
            self._buffer += data

    @property
    def waits(self) -> bool:
        """Return whether something has begun and is not complete."""
        return bool(self._buffer) or bool(self._whole) or self._is_skipping

    def line(self) -> bytes | None:
        """Return the next line without its end, None if there is none yet.

        Raises:
            PropertyError: ``too-large``: raised once, then the rest of the line is skipped.
        """
        if self._whole:
            line = self._whole.popleft()
            return line[:-1] if line.endswith(b"\r") else line
        while True:
            end = self._buffer.find(b"\n", self._searched)
            self._searched = 0
            if end < 0:
                self._searched = len(self._buffer)
                if len(self._buffer) <= self._longest and not self._is_skipping:
                    return None
                self._buffer.clear()
                self._searched = 0
                if self._is_skipping:
                    return None
                self._is_skipping = True
                raise PropertyError("too-large", f"line is longer than {self._longest} bytes")
            line = bytes(self._buffer[:end])
            del self._buffer[: end + 1]
            if self._is_skipping:
                self._is_skipping = False
                continue
            if len(line) > self._longest:
                raise PropertyError("too-large", f"line is longer than {self._longest} bytes")
            return line[:-1] if line.endswith(b"\r") else line

    def block(self, length: int) -> bytes | None:
        """Return so many bytes and eat the line end after them, None while they are incomplete.

        Raises:
            PropertyError: ``syntax``: no line end follows.
        """
        if self._whole:
            # They were bytes after all.
            self._buffer[:0] = b"\n".join(self._whole) + b"\n"
            self._whole.clear()
            self._searched = 0
        if len(self._buffer) <= length:
            return None
        end = length + 1
        if self._buffer[length : length + 1] == b"\r":
            if len(self._buffer) <= length + 1:
                return None
            end = length + 2
        if self._buffer[end - 1 : end] != b"\n":
            raise PropertyError("syntax", f"{length} expected a line end after the bytes")
        data = bytes(self._buffer[:length])
        del self._buffer[:end]
        return data


class Requests:
    """Reads requests from the bytes of a client."""

    def __init__(self, longest: int = LONGEST_LINE) -> None:
        self._longest = longest
        self._splitter = Splitter(longest)
        self._block: _Block | None = None

    def feed(self, data: bytes) -> None:
        """Take what came."""
        self._splitter.feed(data)

    @property
    def waits(self) -> bool:
        """Return whether something has begun and is not complete."""
        return self._splitter.waits or self._block is not None

    def next(self) -> LineRequest | None:
        """Return the next request, None if there is none yet."""
        try:
            if self._block is not None:
                return self._filled(self._block)
            line = self._splitter.line()
            return None if line is None else self._request(line)
        except PropertyError as error:
            return LineRequest("", "", "", error, error.code == "syntax")

    def _filled(self, block: _Block) -> LineRequest | None:
        data = self._splitter.block(block.length)
        if data is None:
            return None
        self._block = None
        return block.asked._replace(payload=data)

    def _request(self, raw: bytes) -> LineRequest | None:
        try:
            line = raw.decode("utf-8")
        except UnicodeDecodeError as error:
            return LineRequest("", "", "", PropertyError("syntax", f"{error.start} expected UTF-8"))
        id = ""
        if line.startswith("#"):
            id, _, line = line[1:].partition(" ")
            if not id or len(id) > LONGEST_ID or not id.isprintable():
                return LineRequest("", "", "", PropertyError("syntax", "1 expected an id"))
        if line.startswith("GET "):
            return LineRequest(id, line[4:].strip(" "), None)
        if not line.startswith("SET "):
            return LineRequest(id, "", "", PropertyError("syntax", "0 expected GET or SET"))
        target, _, payload = line[4:].partition(" ")
        announced = _BLOCK.fullmatch(payload.encode()) if payload.startswith("{") else None
        if announced is None:
            return LineRequest(id, target, payload)
        length = int(announced[1])
        if length > self._longest:
            refused = PropertyError("too-large", f"longer than {self._longest} bytes")
            return LineRequest(id, target, "", refused, True)
        self._block = _Block(LineRequest(id, target, ""), length)
        return self._filled(self._block)


def write_request(target: str, payload: Payload | None, id: str = "") -> bytes:
    """Return a request as it is sent."""
    if isinstance(payload, str) and payload[:1] != "{" and payload.isprintable() and not id:
        return f"SET {target} {payload}\n".encode("utf-8", "surrogatepass")  # as most are
    head = f"#{id} " if id else ""
    if payload is None:
        return f"{head}GET {target}\n".encode("utf-8", "surrogatepass")
    return f"{head}SET {target}".encode("utf-8", "surrogatepass") + _tail(payload)


def write_answer(answer: Answer, id: str = "") -> bytes:
    """Return a reply as it is sent."""
    head = f"#{id} " if id else ""
    if answer.error:
        return f"{head}! {answer.error} {answer.payload!s}".encode("utf-8", "replace") + b"\n"
    if not answer.payload:
        return f"{head}=\n".encode()
    return f"{head}=".encode() + _tail(answer.payload)


def write_event(event: PropertyEvent) -> bytes:
    """Return an event as it is sent; one that goes to many is written once."""
    return _known_event(event) if len(event.payload) < _SHORT else _written_event(event)


def _written_event(event: PropertyEvent) -> bytes:
    return f"* {event.name};{write_attributes(event)}".encode() + _tail(event.payload)


_known_event = lru_cache(maxsize=64)(_written_event)


def write_attributes(event: PropertyEvent) -> str:
    """Return what an event carries beside the value: ``rev=3;time=…``."""
    attributes = [f"rev={event.revision}", f"time={event.time!r}"]
    if event.quality != "good":
        attributes.append(f"quality={event.quality}")
    if event.dropped:
        attributes.append(f"dropped={event.dropped}")
    if event.code:
        attributes.append(f"code={event.code}")
    return ";".join(attributes)


def write_named(event: PropertyEvent) -> str:
    """Return what an event carries beside the value, and the name behind it."""
    return f"{write_attributes(event)};name={event.name}"


def read_named(payload: Payload, attributes: str) -> PropertyEvent:
    """Return the event that arrived with what `write_named` returns.

    Raises:
        PropertyError: ``syntax``.
    """
    head, _, name = attributes.partition(";name=")
    return read_event(name, payload, head)


def read_event(name: str, payload: Payload, attributes: str) -> PropertyEvent:
    """Return the event that arrived.

    Raises:
        PropertyError: ``syntax``.
    """
    given = dict(each.partition("=")[::2] for each in attributes.split(";"))
    try:
        return PropertyEvent(
            name,
            payload,
            float(given.get("time", "0")),
            int(given.get("rev", "0")),
            given.get("quality", "good"),
            int(given.get("dropped", "0")),
            given.get("code", ""),
        )
    except ValueError as error:
        raise PropertyError("syntax", f"0 expected an event: {error}") from None


def _tail(payload: Payload) -> bytes:
    """Return a payload with the blank before it and the line end after it."""
    if isinstance(payload, bytes):
        return b" {%d}\n%b\n" % (len(payload), payload)
    raw = payload.encode("utf-8", "surrogateescape")
    is_odd = payload[:1] == "{" and _LOOKS_LIKE_BLOCK.fullmatch(payload)
    if is_odd or "\n" in payload or "\r" in payload:
        return b" {%d}\n%b\n" % (len(raw), raw)
    return b" %b\n" % raw


class Replies:
    """Reads replies and events from the bytes of a service.

    Attributes:
        is_idle: Nothing has begun that was not given.
    """

    def __init__(self, longest: int = 1 << 26) -> None:
        self._splitter = Splitter(longest)
        self._head: tuple[str, str] | None = None
        self._length = 0
        self.is_idle = True

    def feed(self, data: bytes) -> None:
        """Take what came."""
        self.is_idle = False
        self._splitter.feed(data)

    def next(self) -> tuple[str, Answer] | PropertyEvent | None:
        """Return the next reply with its id, or the next event; None if there is none yet.

        Raises:
            PropertyError: ``syntax``: it speaks no line protocol; ``too-large``.
        """
        received = self._next()
        self.is_idle = self._head is None and not self._splitter.waits
        return received

    def _next(self) -> tuple[str, Answer] | PropertyEvent | None:
        if self._head is None:
            raw = self._splitter.line()
            if raw is None:
                return None
            head, payload = self._read(raw.decode("utf-8", "replace"))
            is_block = payload[:1] == "{"  # most are none
            announced = _BLOCK.fullmatch(payload.encode("utf-8", "replace")) if is_block else None
            if head[1].startswith("!") or announced is None:
                return _made(head, payload)
            self._head, self._length = head, int(announced[1])
        data = self._splitter.block(self._length)
        if data is None:
            return None
        head, self._head = self._head, None
        return _made(head, text_or_bytes(data))

    @staticmethod
    def _read(line: str) -> tuple[tuple[str, str], str]:
        id = ""
        if line.startswith("#"):
            id, _, line = line[1:].partition(" ")
        mark, _, rest = line.partition(" ")
        if mark == "=":
            return (id, "="), rest
        if mark == "!":
            code, _, text = rest.partition(" ")
            return (id, f"!{code}"), text
        if mark == "*":
            name, _, payload = rest.partition(" ")
            return (id, f"*{name}"), payload
        raise PropertyError("syntax", f"0 expected a reply: {line[:60]!r}")


def _made(head: tuple[str, str], payload: Payload) -> tuple[str, Answer] | PropertyEvent:
    id, what = head
    if what == "=":
        return id, Answer(payload)
    if what.startswith("!"):
        return id, Answer(payload, what[1:])
    name, _, attributes = what[1:].partition(";")
    return read_event(name, payload, attributes)
