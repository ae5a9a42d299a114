"""Client of the HTTP endpoint: asks over one connection, listens over one more per property."""

from __future__ import annotations

import math
import os
import re
import select
import socket
import ssl
from base64 import b64decode
from collections.abc import Callable, Iterator
from errno import EAGAIN
from http import HTTPStatus
from http.client import HTTPConnection, HTTPException, HTTPResponse
from time import monotonic
from typing import Any
from urllib.parse import quote

from rtkit.closing import Closing
from rtkit.errors import Malformed, Unreachable
from rtkit.link.deadline import deadline_at
from rtkit.link.secret import Secret
from rtkit.property.codes import PropertyError
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.line import read_named
from rtkit.property.messages import Answer, Payload, PropertyEvent, text_or_bytes
from rtkit.property.naming import parse_target
from rtkit.wires.http import digest
from rtkit.wires.property_client import Inbox, bound_in
from rtkit.wires.wire import SERVICES

DEADLINE = "rtkit-deadline"
"""Header of a SET: when it is given up, as `rtkit.link.deadline` writes it."""
SILENT_S = 35.0
"""How long a stream may be silent, heartbeats and all, until its endpoint counts as gone [s]."""
_ADDRESS = re.compile(r"(https?)://([^/:@\s]+)(?::(\d{1,5}))?(?:/ps)?/?")
_PORTS = {"http": 80, "https": 443}
_FREE = "/?&=()!*'$,;:@~%+"
_ROOT = "/ps"
_PIECE = 1 << 16
_MOST_PIECES = 64
"""Pieces of a stream that are taken at once, before an event is returned."""


class BoundedReads(socket.socket):
    """Socket whose reads end at one moment, all together; another one bounds each by itself."""

    until = math.inf

    def recv_into(self, *args: Any) -> int:
        """Receive what is there, or comes in time."""
        if self.until < math.inf:
            left_s = self.until - monotonic()
            if left_s <= 0:
                raise TimeoutError
            self.settimeout(left_s)
        try:
            return super().recv_into(*args)
        except ssl.SSLWantReadError:
            raise BlockingIOError(EAGAIN, "nothing has come") from None


def _connected(host: str, port: int, left_s: float) -> BoundedReads:
    end = socket.create_connection((host, port), left_s)
    end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return BoundedReads(end.family, end.type, end.proto, end.detach())


class _BoundedConnection(HTTPConnection):
    """Connection on which everything until the next bound ends at one moment.

    Attributes:
        end: The socket, which a response that is a stream of events keeps open.
        connected: Makes it, in so long at most [s].
    """

    sock: BoundedReads | None
    end: BoundedReads
    connected: Callable[[str, int, float], BoundedReads] = staticmethod(_connected)
    bound_s = math.inf
    _until = math.inf

    def bound(self, until: float) -> None:
        """Have all that is done from now on end at a moment, by the monotonic clock [s]."""
        self.bound_s, self._until = until - monotonic(), until

    def connect(self) -> None:
        """Connect in the time that is left."""
        left_s = self._until - monotonic()
        if left_s <= 0:
            raise TimeoutError
        self.sock = self.end = self.connected(self.host, self.port, left_s)

    def send(self, data: Any) -> None:
        """Send, and connect before if there is no connection."""
        if self.sock is None:
            self.connect()
        assert self.sock is not None
        self.sock.until = self._until
        self.sock.settimeout(max(1e-3, self._until - monotonic()))
        super().send(data)


class _StreamConnection(_BoundedConnection):
    """Connection of which all that comes behind the head of a response is its content."""

    _http_vsn = 10
    _http_vsn_str = "HTTP/1.0"


class HttpClient(Closing):
    """Client of the services behind an HTTP endpoint.

    Args:
        service: The one that is asked; empty if targets name theirs.
        secret: None where it is not asked for.
        timeout_s: Bound on each request [s].
    """

    def __init__(
        self, host: str, port: int, secret: Secret | None, timeout_s: float, service: str = ""
    ) -> None:
        self._secret = secret
        self._service = service
        self._timeout_s = timeout_s
        self._where = (host, port)
        self._connected: Callable[[str, int, float], BoundedReads] = _connected
        self._http = _BoundedConnection(host, port)
        self._nonce = ""
        self._times = 0
        self._own = os.urandom(8).hex()
        self._streams: list[_Stream] = []
        self._inbox = Inbox()
        self._why: Unreachable | None = None

    def use(self, connected: Callable[[str, int, float], BoundedReads]) -> None:
        """Connect in another way, behind TLS."""
        self._connected = self._http.connected = connected

    def ask(self, target: str, payload: Payload | None = None, until: float = math.inf) -> Answer:
        """GET, or SET, and wait for the reply: to `until`, by the monotonic clock here [s].

        The time-out, and ``timeout=`` in the target, may end it sooner. They bound all of it, the
        login, too. A SET that has not begun by then never does.

        Raises:
            Unreachable: No reply in time, or nobody listens there.
        """
        begin = monotonic()
        until = min(until, begin + bound_in(target, self._timeout_s))
        if until <= begin:
            return Answer(NOT_BEGUN, "timeout")
        self._http.bound(until)
        body, headers = None, {}
        if payload is not None:
            is_bytes = isinstance(payload, bytes)
            body = payload if isinstance(payload, bytes) else _encoded(payload)
            kind = "application/octet-stream" if is_bytes else "text/plain; charset=utf-8"
            headers = {"Content-Type": kind, DEADLINE: deadline_at(until)}
        try:
            uri = _ROOT if target == SERVICES and not self._service else self._uri(target)
            return _answer(*self._answered(self._http, uri, body, headers))
        except PropertyError as error:
            return Answer(str(error), error.code)  # no address can be made of it, or no proof

    def _answered(
        self, http: _BoundedConnection, uri: str, body: bytes | None, headers: dict[str, str]
    ) -> tuple[HTTPResponse, bytes]:
        """Send a request, also with another nonce where one is too old; return what comes.

        Raises:
            PropertyError: ``denied``.
            Unreachable: No response in time, or nobody listens there.
        """
        if body is not None and self._secret is not None and not self._nonce:
            self._exchange(http, _ROOT, None, {})  # only to be told what to prove
        for _ in range(3):
            answered = self._exchange(http, uri, body, headers)
            if answered is not None:
                return answered
        raise PropertyError("denied", "the endpoint does not take the secret of this user")

    def _exchange(
        self, http: _BoundedConnection, uri: str, body: bytes | None, headers: dict[str, str]
    ) -> tuple[HTTPResponse, bytes] | None:
        """Send a request and take its response; None if it asks for another proof.

        It is never sent twice: it may have acted. Of a stream of events nothing is read yet.
        """
        _close_if_hung_up(http)
        method = "GET" if body is None else "PUT"
        try:
            http.request(method, uri, body, headers | self._proof(method, uri))
            response = http.getresponse()
            is_stream = isinstance(http, _StreamConnection) and response.status == HTTPStatus.OK
            received = b"" if is_stream else response.read()
        except TimeoutError:
            http.close()
            raise Unreachable(f"no answer within {http.bound_s:.3g} s") from None
        except (Unreachable, PropertyError):
            http.close()
            raise
        except (OSError, HTTPException) as error:
            http.close()
            meant = _meaning_of(error)
            raise meant or Unreachable(self._gone(error)) from error
        if response.status != HTTPStatus.UNAUTHORIZED:
            return response, received
        given = digest.fields(response.getheader("WWW-Authenticate", ""))
        self._nonce, self._times = given.get("nonce", ""), 0
        return None if self._nonce else (response, received)

    def _gone(self, error: Exception) -> str:
        host, port = self._where
        what = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        scheme = "https" if self._secret is None else "http"
        return f"cannot reach {scheme}://{host}:{port}: {what}"

    def _proof(self, method: str, uri: str) -> dict[str, str]:
        if self._secret is None or not self._nonce:
            return {}
        self._times += 1
        return {"Authorization": digest.authorization(
            self._secret, method, uri, self._nonce, self._times, self._own)}  # fmt: skip

    def _uri(self, target: str) -> str:
        """Return the path of a target.

        Raises:
            PropertyError: As the service would answer.
        """
        parse_target(target)
        service = f"{self._service}/" if self._service else ""
        return f"{_ROOT}/" + quote(service + target, safe=_FREE)

    # Listening

    def listen(self, target: str) -> None:
        """See `PropertyClient.listen`."""
        uri = self._uri(target)
        name, _, tail = target.partition("?")
        self._inbox.expect(name, tail)
        http = _StreamConnection(*self._where)
        http.connected = self._connected
        http.bound(monotonic() + self._timeout_s)
        headers = {"Host": "{}:{}".format(*self._where), "Accept": "text/event-stream"}
        response, received = self._answered(http, uri, None, headers)
        if response.status != HTTPStatus.OK:
            _answer(response, received).value()
            raise Unreachable(f"an odd answer, status {response.status}")
        self._streams.append(_Stream(http.end, response))

    def event(self, timeout_s: float | None = None) -> PropertyEvent | None:
        """See `PropertyClient.event`."""
        deadline = None if timeout_s is None else monotonic() + timeout_s
        pieces = _MOST_PIECES
        while pieces and self._receive(0.0):
            pieces -= 1
        while not len(self._inbox):
            if self._why is not None:
                raise self._why
            left = SILENT_S if deadline is None else max(0.0, deadline - monotonic())
            self._receive(min(left, SILENT_S))
            if not len(self._inbox) and deadline is not None and monotonic() >= deadline:
                break
        return self._inbox.take()

    def _receive(self, wait_s: float) -> bool:
        """Take what comes in time; return whether anything did."""
        poll = select.poll()
        by_number = {each.end.fileno(): each for each in self._streams}
        for number in by_number:
            if number < 0:
                raise Unreachable("the connection was closed")  # by another thread
            poll.register(number, select.POLLIN)
        for each in self._streams:
            if each.has_more:
                wait_s = 0.0
        ready = {number for number, _ in poll.poll(wait_s * 1000)}
        now = monotonic()
        for number, stream in by_number.items():
            if number in ready:
                stream.receive()
            elif now - stream.received_at > SILENT_S:
                self._why = Unreachable("the connection has ended: nothing was heard of it")
            for event in stream.events():
                self._inbox.put(event)
            if stream.has_ended:
                if stream not in self._streams:
                    raise Unreachable("the connection was closed")  # by another thread
                self._streams.remove(stream)
                stream.close()
                if not stream.was_last:
                    self._why = Unreachable("the connection has ended")
        return bool(ready)

    def close(self) -> None:
        """End all connections."""
        self._http.close()
        for stream in self._streams:
            stream.close()
        self._streams.clear()


class _Stream:
    """Connection that carries events, and the part of the next one that has come.

    Attributes:
        received_at: When anything came last [s, monotonic].
        has_ended: Nothing will come any more.
        was_last: Because the property has gone.
    """

    def __init__(self, end: BoundedReads, response: HTTPResponse) -> None:
        self.end = end
        self.received_at = monotonic()
        self.has_ended = False
        self.was_last = False
        self._response = response
        end.until = math.inf
        end.setblocking(False)
        self._data = bytearray(response.fp.read1(_PIECE) or b"")

    @property
    def has_more(self) -> bool:
        """Return whether a whole event is there."""
        return b"\n\n" in self._data

    def receive(self) -> None:
        """Take what has come."""
        try:
            data = self.end.recv(_PIECE)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        self.has_ended = not data
        self.received_at = monotonic()
        self._data += data

    def close(self) -> None:
        """End the connection."""
        self._response.close()
        self.end.close()

    def events(self) -> Iterator[PropertyEvent]:
        """Yield the events that are there."""
        *blocks, rest = bytes(self._data).split(b"\n\n")
        self._data = bytearray(rest)
        for block in blocks:
            event = _read_sse(block)
            if event is not None:
                self.was_last = bool(event.code)
                yield event


def _read_sse(block: bytes) -> PropertyEvent | None:
    """Return an event, None for what is a heartbeat."""
    fields: dict[bytes, list[bytes]] = {}
    for line in block.split(b"\n"):
        key, _, value = line.partition(b":")
        fields.setdefault(key, []).append(value.removeprefix(b" "))
    if b"data" not in fields:
        return None
    kind = fields.get(b"event", [b""])[0]
    raw = b"" if kind == b"end" else b"\n".join(fields[b"data"])
    if kind in (b"base64", b"base64-text"):
        raw = b64decode(raw)
    payload = raw if kind == b"base64" else raw.decode("utf-8", "replace")
    return read_named(payload, fields.get(b"id", [b""])[0].decode())


def _close_if_hung_up(http: _BoundedConnection) -> None:
    """Have a connection made anew that the endpoint has closed since the last answer."""
    if http.sock is None:
        return
    poll = select.poll()
    poll.register(http.sock, select.POLLIN)
    if poll.poll(0):
        http.close()


def _meaning_of(error: Exception) -> PropertyError | None:
    """Return what an endpoint says by ending TLS, None if that is not what it did."""
    if not isinstance(error, ssl.SSLError):
        return None
    from rtkit.wires.secure import meaning_of

    meant = meaning_of(error)
    return meant if isinstance(meant, PropertyError) else None


def _encoded(text: str) -> bytes:
    return text.encode("utf-8", "surrogateescape")


def _answer(response: HTTPResponse, body: bytes) -> Answer:
    if response.status >= HTTPStatus.BAD_REQUEST:
        return _read_error(body)
    if response.getheader("Content-Type", "").startswith(("application/octet-stream", "image/")):
        return Answer(text_or_bytes(body))
    return Answer(body.decode("utf-8", "surrogateescape"))


def _read_error(body: bytes) -> Answer:
    code, _, text = body.decode("utf-8", "replace").strip().partition(" ")
    return Answer(text, code or "internal")


def parse_address(text: str, scheme: str = "http") -> tuple[str, int] | None:
    """Return host and port of ``http://HOST:PORT``, None if it is no such thing."""
    found = _ADDRESS.fullmatch(text)
    is_one = found is not None and found[1] == scheme
    return (found[2], int(found[3] or _PORTS[scheme])) if found is not None and is_one else None


def connect_http(address: str, timeout_s: float, service: str = "") -> HttpClient:
    """Return a client of an HTTP endpoint, with the user's secret; it connects when it asks.

    Raises:
        Malformed: It is no address.
        Unreachable: There is no secret.
    """
    from rtkit.link import secret

    where = parse_address(address)
    if where is None:
        raise Malformed(f"not http://HOST:PORT[/ps/SERVICE]: {address}")
    return HttpClient(*where, secret.read(), timeout_s, service)
