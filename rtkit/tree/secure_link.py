"""Link to a manager of another host over mutual TLS, with the certificate of this user.

Its other end is `rtkit.manager.gateway`. Requests go through one connection, each with an id; a
thread of its own reads what comes.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from functools import partial
from queue import Empty, SimpleQueue
from time import monotonic
from urllib.parse import quote

from rtkit.closing import Closing
from rtkit.errors import Denied, Malformed, NotFound, Refused, Unreachable
from rtkit.link import zenoh_keys
from rtkit.link.deadline import with_deadline
from rtkit.link.transport import Link
from rtkit.property.codes import PropertyError
from rtkit.property.exchange import Reply
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.line.client import LineClient
from rtkit.wires.line.provider_connection import LineConnection
from rtkit.wires.secure import connected

IDENTITY = "~identity"
_TAP = "@x/tap/"
_GRACE_S, _LISTEN_S = 0.5, 10.0
_QUEUE = "queue=256&mode=all"
_KINDS = {
    "denied": Denied.kind,
    **dict.fromkeys(("timeout", "no-service", "busy"), Unreachable.kind),
}
_OWN_KINDS = ("malformed", "refused", "invalid", "not-found", "unreachable", "impossible", "limit")


class SecureLink(Link, Closing):
    """Link through a connection whose other end knows who this is.

    Args:
        client: Connected; nothing is under way.
        host: Name of the manager's host.
        manager: Its name there.
    """

    def __init__(self, client: LineClient, host: str, manager: str) -> None:
        self._prefix = f"{zenoh_keys.service(host, manager)}/"
        self._ids = itertools.count(1)
        self._why = ""
        self._noticing: list[Callable[[bool], object]] = []
        self._loop = PropertyEventLoop()
        self._connection = LineConnection(self._loop, client.detach())
        self._connection.start(self._end)
        self._loop.start()

    def send(self, key: str, payload: str | None, timeout_s: float) -> Callable[[], Reply]:
        """See `Link.send`."""
        answer = self._ask(self._target(key), payload, timeout_s)
        return lambda: _reply(answer())

    def _ask(self, target: str, payload: Payload | None, timeout_s: float) -> Callable[[], Answer]:
        until = monotonic() + timeout_s
        answers: SimpleQueue[Answer] = SimpleQueue()

        def ask() -> None:
            if self._why:
                answers.put(Answer(self._why, "no-service"))
                return
            about = target if payload is not None else with_deadline(target, until)
            self._connection.ask(about, payload, str(next(self._ids)), answers.put, until)

        self._loop.post(ask)
        # The other end answers in time, or says that nobody did.
        return lambda: _next(answers, max(0.0, until - monotonic()) + _GRACE_S, timeout_s)

    def ask_tap(self, word: str, body: bytes, timeout_s: float) -> Callable[[], bytes]:
        """Send a request to the tap of this connection (`rtkit.link.tap_messages`).

        What is returned awaits the answer, once; it raises what went wrong.
        """
        answer = self._ask(quote(f"{_TAP}{word}", safe=""), body, timeout_s)

        def awaited() -> bytes:
            given = answer()
            if given.error:
                _reply(given).value()
            text = given.payload
            return text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text

        return awaited

    def listen(self, key: str, on_text: Callable[[str], object]) -> Callable[[], object]:
        """See `Link.listen`.

        Raises:
            Refused: It may not.
            Unreachable: The connection has ended.
        """
        target = self._target(key)
        answers: SimpleQueue[Answer] = SimpleQueue()

        def take(event: PropertyEvent) -> None:
            on_text(event.payload if isinstance(event.payload, str) else event.payload.decode())

        self._loop.post(partial(self._connection.listen, target, _QUEUE, take, answers.put))
        _reply(_next(answers, _LISTEN_S, _LISTEN_S)).value()
        return lambda: self._loop.post(partial(self._connection.leave, target))

    def notice(self, key: str, found: Callable[[bool], object]) -> Callable[[], object]:
        """See `Link.notice`: a requester there is served until the connection ends."""
        self._noticing.append(found)
        found(not self._why)
        return lambda: self._noticing.remove(found)

    def close(self) -> None:
        """See `Link.close`."""
        self._noticing.clear()
        self._loop.close()

    def _target(self, key: str) -> str:
        if not key.startswith(self._prefix):
            raise Unreachable(f"nobody answers for {key} over TLS")
        return quote(key.removeprefix(self._prefix), safe="")

    def _end(self, why: str) -> None:
        self._why = why
        for found in list(self._noticing):
            found(False)


def _next(answers: SimpleQueue[Answer], most_s: float, shown_s: float) -> Answer:
    try:
        return answers.get(timeout=most_s)
    except Empty:
        raise Unreachable(f"no answer within {shown_s:g} s") from None


def _reply(answer: Answer) -> Reply:
    text, code = str(answer.payload), answer.error
    if not code or code in _OWN_KINDS:
        return Reply(text, code)
    kind = _KINDS.get(code, Refused.kind)
    return Reply(text if kind == Unreachable.kind else f"{code}: {text}", kind)


def connect_secure(host: str, port: int, timeout_s: float) -> tuple[SecureLink, str, str, str]:
    """Connect to the manager at a port for certificates; return its host, name and id, too.

    Raises:
        Unreachable: Nobody answers there, or only a manager of another realm.
        Refused: It is not who it should be, or does not let this user in.
        NotFound: This user has no keys.
    """
    try:
        client = LineClient(connected(host, port, timeout_s), timeout_s)  # type: ignore[arg-type]
        try:
            realm, *identity = map(str, json.loads(client.ask(IDENTITY).value()))
            far, manager, id = identity
        except BaseException:
            client.close()
            raise
    except NotFound as error:
        raise NotFound(f"{host}:{port} is on another host: {error}") from None
    except PropertyError as error:
        raise Refused(f"{host}:{port}: {error.code}: {error}") from None
    except ValueError as error:
        raise Malformed(f"no manager at {host}:{port}: {error}") from None
    if realm != zenoh_keys.realm():
        client.close()
        raise Unreachable(f"no manager of this realm answers at {host}:{port}")
    return SecureLink(client, far, manager), far, manager, id
