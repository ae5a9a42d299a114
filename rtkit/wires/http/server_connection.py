"""Server side of one HTTP client: requests one after the other, or one event stream; bounded.

h11 implements HTTP; this module adds time-outs, limits and the call of the service.

See decision 26.
"""

from __future__ import annotations

import select
import socket
from collections.abc import Callable, Container, Iterable
from functools import partial
from http import HTTPStatus
from time import monotonic
from typing import TYPE_CHECKING, Any

import h11

from rtkit.link.deadline import deadline_from_text
from rtkit.property.codes import PropertyError
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.messages import Answer, PropertyEvent
from rtkit.property.requests import PropertyRequest
from rtkit.property.subscription import Listener, listen_target
from rtkit.serving.event_loop import ByteStream
from rtkit.serving.quota import too_fast
from rtkit.serving.socket_client import SocketClient
from rtkit.wires.http import request as http_request
from rtkit.wires.http.client import DEADLINE
from rtkit.wires.http.events import SseProgress, write_refused, write_sse
from rtkit.wires.http.guard import HERE, Guard, Verdict, stranger
from rtkit.wires.http.pages import POLICY, framed, page
from rtkit.wires.http.parts import PARTS, PartWriter, as_parts
from rtkit.wires.http.request import EVENTS, METHODS, HttpRequest, Response, failure
from rtkit.wires.line.login import PATIENCE_S

if TYPE_CHECKING:
    from rtkit.serving.event_loop import PropertyEventLoop
    from rtkit.serving.quota import EndpointQuota

REQUEST_S = 10.0
"""How long a request may take to come, from its first byte to its last [s]."""
IDLE_S = 60.0
"""How long a connection stays open for the next one [s]; `PATIENCE_S` of who is not known."""
STUCK_S = 30.0
"""How long what is sent may lie unread [s]."""
HEARTBEAT_S = 10.0
"""How long a stream of events is silent at most [s]."""
_LINGER_S = 2.0
_PIECE = 1 << 16
_LONGEST_HEAD = 1 << 14
_ROOM_FOR_EVENTS = 1 << 15
_POLICY = "Content-Security-Policy"
_ALWAYS = (
    ("Cache-Control", "no-store"),
    ("X-Content-Type-Options", "nosniff"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Referrer-Policy", "no-referrer"),
    ("X-DNS-Prefetch-Control", "off"),
)


class HttpConnection(SocketClient):
    """Client behind a socket.

    Attributes:
        is_stream: It gets events, and asks nothing any more.
    """

    _scheme = "http"

    def __init__(
        self,
        host: PropertyEventLoop,
        end: ByteStream,
        guard: Guard | None,
        quota: EndpointQuota,
        names: Container[str] = HERE,
    ) -> None:
        super().__init__(host, end, quota)
        self.is_stream = False
        self._socket: Any = end
        self._guard = guard
        self._names = names
        self._http = h11.Connection(h11.SERVER, _LONGEST_HEAD)
        self._request: h11.Request | None = None
        self._refused: Response | None = None
        self._headers: dict[str, str] = {}
        self._body = bytearray()
        self._is_asked = False
        self._wants_events = False
        self._to_come = 0
        self._began_at: float | None = None
        self._linger_until: float | None = None
        self._progress: SseProgress | None = None
        self._written: Callable[[PropertyEvent], bytes] = write_sse

    # Caller

    def listen(self, listener: Listener) -> None:
        """See `Requester.listen`; only what asks for a stream of events can listen."""
        if not self._wants_events:
            raise PropertyError("denied", f"events are for a GET that accepts {EVENTS}")
        super().listen(listener)

    # IOHandler

    def ready(self, mask: int) -> None:
        """See `IOHandler.ready`."""
        if mask & select.EPOLLOUT:
            self._send()
        if mask & ~select.EPOLLOUT and self.is_open:
            data = self._receive(_PIECE)
            if not data or self.is_stream or self._linger_until is not None:
                return  # of a stream, and of a connection that ends, nothing more is wanted
            self._moved_at = monotonic()
            if self._began_at is None:
                self._began_at = self._moved_at
            self._http.receive_data(data)
        if self.is_open:
            self._work()

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`."""
        due = self.send_due(now, lambda: len(self._out) < _ROOM_FOR_EVENTS, self._send_event)
        if self.is_stream and not (self.listeners or self._to_come or self._is_closing):
            self._finish()
        self._work()
        return due if self.is_open else None

    def _send_event(self, listener: Listener, event: PropertyEvent) -> None:
        if self._progress is None or self._progress.is_new(event):
            self._stream(self._written(event))

    def check(self, now: float) -> None:
        """See `IOHandler.check`."""
        if self._out and now - self._moved_at > STUCK_S:
            self.close()
        elif self._linger_until is not None:
            if now > self._linger_until:
                self.close()
        elif self.is_stream:
            is_quiet = not self._out and now - self._moved_at > HEARTBEAT_S
            if is_quiet and not isinstance(
                self._written, PartWriter
            ):  # between parts nothing can be said
                self._stream(b":\n\n")
                self._send()
        elif self._is_asked or self._out:
            return
        elif self._began_at is None:
            if now - self._moved_at > (IDLE_S if self.identity else PATIENCE_S):
                self.close()
        elif now - self._began_at > REQUEST_S:
            late = f"the request did not come within {REQUEST_S:g} s"
            self._respond(failure("timeout", late, HTTPStatus.REQUEST_TIMEOUT), closes=True)
            self._send()

    # Requests

    def _work(self) -> None:
        self._is_working = True
        try:
            while self.is_open and not (self._is_asked or self._is_closing or self._out):
                event = self._http.next_event()
                if event is h11.NEED_DATA or event is h11.PAUSED:
                    break
                self._take(event)
        except h11.RemoteProtocolError as error:
            self._refuse(error)
        self._is_working = False
        self._send()

    def _take(self, event: object) -> None:
        if isinstance(event, h11.Request):
            self._begin(event)
        elif isinstance(event, h11.Data):
            self._body += event.data
            if len(self._body) > self._longest:
                self._refuse_body()
        elif isinstance(event, h11.EndOfMessage):
            self._ask()
        else:
            self._is_closing = True

    def _refuse(self, error: h11.RemoteProtocolError) -> None:
        """Answer what is no HTTP; nothing can be read after it."""
        if self._http.our_state not in (h11.IDLE, h11.SEND_RESPONSE):
            self._is_closing = True
            return
        code = "too-large" if error.error_status_hint == 431 else "syntax"
        self._respond(failure(code, f"HTTP: {error}", error.error_status_hint), closes=True)

    def _refuse_body(self) -> None:
        self._respond(failure("too-large", f"longer than {self._longest} bytes"), closes=True)

    def _begin(self, request: h11.Request) -> None:
        """Look at the head of a request: what is refused by it needs no body."""
        self._request = request
        self._body.clear()
        names = [name.decode("ascii") for name, _ in request.headers]
        self._headers = {name.decode("ascii"): value.decode("latin-1")
                         for name, value in request.headers}  # fmt: skip
        self._refused = self._refusal(request, names)
        if self._refused is not None:
            if self._has_body():
                self._respond(self._refused, closes=True)
        elif int(self._headers.get("content-length", "0")) > self._longest:
            self._refuse_body()
        elif self._http.they_are_waiting_for_100_continue:
            go_on = h11.InformationalResponse(status_code=100, headers=[])
            self._out += self._http.send(go_on) or b""

    def _has_body(self) -> bool:
        return (
            "transfer-encoding" in self._headers or self._headers.get("content-length", "0") != "0"
        )

    def _refusal(self, request: h11.Request, names: Iterable[str]) -> Response | None:
        headers, method = self._headers, request.method.decode("ascii")
        listed = list(names)
        if "transfer-encoding" in headers and "content-length" in headers:
            return failure("syntax", "HTTP: two lengths of one body", HTTPStatus.BAD_REQUEST)
        if any(listed.count(each) > 1 for each in ("authorization", "origin", "if-match")):
            return failure("syntax", "HTTP: a header that is there twice", HTTPStatus.BAD_REQUEST)
        if not request.target.startswith(b"/"):
            return failure("syntax", "HTTP: expected a path", HTTPStatus.BAD_REQUEST)
        foreign = stranger(headers, self._names, self._scheme)
        if foreign:
            return failure("denied", foreign)
        uri = request.target.decode("ascii")
        verdict = self._verdict(method, uri)
        self.identity = verdict.identity
        if not verdict.identity:
            text = "user and password are those of door.secret (Digest; rtkit help security)"
            refused = failure("denied", text, HTTPStatus.UNAUTHORIZED)
            return refused._replace(more=(("WWW-Authenticate", verdict.challenge),))
        if self._pace is not None and not self._pace.takes(monotonic()):
            text = too_fast(self._quota.limits.rate)
            return failure("busy", text, HTTPStatus.TOO_MANY_REQUESTS)
        if method not in METHODS:
            return failure("read-only", f"no method {method[:20]}", HTTPStatus.METHOD_NOT_ALLOWED)
        return None

    def _verdict(self, method: str, uri: str) -> Verdict:
        """Return who sends the request that has begun."""
        assert self._guard is not None
        return self._guard.check(method, uri, self._headers.get("authorization"), monotonic())

    def _ask(self) -> None:
        """Put a request that is whole to its service."""
        request = self._request
        if request is None or self._http.our_state is not h11.SEND_RESPONSE:
            return  # it was answered before its end came
        if self._refused is not None:
            self._respond(self._refused)
            return
        method, uri = request.method.decode("ascii"), request.target.decode("ascii")
        is_get = method in ("GET", "HEAD")
        shown = page(uri, self._headers, self._host.services) if is_get else None
        if shown is not None:
            self._respond(shown)
            return
        try:
            asked = http_request.wanted(uri, self._host.services)
            if not asked.service:
                names = f"({' '.join(self._host.services)})"
                self._respond(http_request.response(Answer(names), uri, is_get=True,
                              accepts=self._headers.get("accept", ""), revision=None))  # fmt: skip
            elif is_get and EVENTS in self._headers.get("accept", ""):
                self._open_stream(asked)
            elif is_get and (parts := as_parts(asked, self._headers.get("accept", ""))):
                self._open_stream(parts, PartWriter())
            else:
                self._ask_service(asked, uri, is_get=is_get)
        except PropertyError as error:
            self._respond(failure(error.code, str(error)))

    def _ask_service(self, asked: HttpRequest, uri: str, *, is_get: bool) -> None:
        service = self._host.services[asked.service]
        name = asked.target.partition("?")[0]
        target, payload = asked.target, None
        if not is_get:
            kind = self._headers.get("content-type", "")
            is_text = service.is_text(name)
            payload = http_request.payload_of(bytes(self._body), kind, is_text)
            target = http_request.with_revision(target, self._headers.get("if-match"))
        accepts = self._headers.get("accept", "")
        self._is_asked = True

        def answer(reply: Answer) -> None:
            self._is_asked = False
            if self.is_open:
                revision = service.revision(name)
                made = http_request.response(
                    reply, uri, is_get=is_get, accepts=accepts, revision=revision)  # fmt: skip
                self._respond(framed(made, uri, self._headers))
                if not self._is_working:
                    self._host.mark(self)

        until = deadline_from_text(self._headers.get(DEADLINE, ""))
        if is_get or monotonic() <= until:
            ask = PropertyRequest(target, payload, answer, self, until=until)
            service.handle(self.audited(ask, asked.service))
        else:
            answer(Answer(NOT_BEGUN, "timeout"))

    def _open_stream(
        self, asked: HttpRequest, written: Callable[[PropertyEvent], bytes] = write_sse
    ) -> None:
        self._written = written
        several = http_request.several(asked.target)
        if several is not None and written is write_sse:
            self._open_stream_of_several(asked.service, *several)
            return
        self._progress = SseProgress(self._headers.get("last-event-id", ""))
        self._is_asked = self._wants_events = True
        listening = PropertyRequest(
            http_request.to_listen(asked.target), "self", self._listened, self
        )
        self._host.services[asked.service].handle(listening)

    def _open_stream_of_several(self, name: str, listing: str, options: str) -> None:
        """Listen to all names of a listing, and to which there are, in one stream."""
        service = self._host.services[name]
        self._is_asked = self._wants_events = True
        self._written = partial(write_sse, has_bytes=False)

        def listed(reply: Answer) -> None:
            self._listened(reply)
            if not self.is_stream:
                return
            place = listing.partition("?")[0]
            prefix = place.removesuffix("properties")
            names = [place, *(prefix + each for each in http_request.names(reply.payload))]
            self._to_come = len(names)
            for each in names:
                target = listen_target(each, options)
                answer = partial(self._listened_to_one, each)
                service.handle(PropertyRequest(target, "self", answer, self))

        service.handle(PropertyRequest(listing, None, listed, self))

    def _listened_to_one(self, name: str, reply: Answer) -> None:
        """Tell of a property that cannot be listened to; the others go on."""
        self._to_come -= 1
        if reply.error and reply.error != "write-only" and self.is_open:
            self._stream(write_refused(name, f"{reply.error} {reply.payload!s}"))
            self._host.mark(self)

    def _listened(self, reply: Answer) -> None:
        """Begin to send events, if the service agrees."""
        self._is_asked = False
        if not self.is_open:
            return
        if reply.error:
            self._wants_events = False
            self._respond(failure(reply.error, str(reply.payload)))
        else:
            self.is_stream = True
            is_parts = isinstance(self._written, PartWriter)
            media, begin = (PARTS, b"") if is_parts else (EVENTS, b"retry: 1000\n\n")
            kind = [("Content-Type", media), ("Connection", "close"), *_ALWAYS]
            self._out += self._http.send(h11.Response(status_code=200, headers=kind)) or b""
            self._stream(begin)
        self._host.mark(self)

    # Responses

    def _respond(self, response: Response, *, closes: bool = False) -> None:
        assert self._http.our_state in (h11.IDLE, h11.SEND_RESPONSE)
        headers = [("Content-Length", str(len(response.body))), *response.more, *_ALWAYS]
        if not any(name == _POLICY for name, _ in response.more):
            headers.append((_POLICY, POLICY))
        if response.status == HTTPStatus.NO_CONTENT:
            headers.pop(0)
        if response.content_type:
            headers.append(("Content-Type", response.content_type))
        if closes:
            headers.append(("Connection", "close"))
        send = self._http.send
        self._out += send(h11.Response(status_code=response.status, headers=headers)) or b""
        if response.body and not (self._request and self._request.method == b"HEAD"):
            self._out += send(h11.Data(data=response.body)) or b""
        self._finish()

    def _stream(self, data: bytes) -> None:
        self._out += self._http.send(h11.Data(data=data)) or b""

    def _finish(self) -> None:
        """End a response, and be ready for the next request if there can be one."""
        self._out += self._http.send(h11.EndOfMessage()) or b""
        self._request = None
        if self._http.our_state is h11.DONE and self._http.their_state is h11.DONE:
            self._http.start_next_cycle()
            self._began_at = monotonic() if self._http.trailing_data[0] else None
        else:
            self._is_closing = True

    def _send(self) -> None:
        if not self._send_out():
            return
        out = self._out
        if self._is_closing and not out and self._linger_until is None:
            self._linger()
        self._await(reads=not (self._is_asked or (out and not self.is_stream)))
        if not out and (self._http.trailing_data[0] or self.has_pending):
            self._host.mark(self)

    def _linger(self) -> None:
        """End our side, but read on for a moment: who still sends would not see the answer."""
        self._linger_until = monotonic() + _LINGER_S
        try:
            self._socket.shutdown(socket.SHUT_WR)
        except OSError:
            self.close()
