"""Zenoh link: sessions, queries and replies. No other file of the control path knows zenoh.

Rules kept here, each a hang or a loss that was measured otherwise: explicit endpoints and no
scouting; bounded channels with consolidation off for every get; direct callbacks that only
enqueue; queries dropped after their reply; sessions closed explicitly; nothing opened before a
fork; no shared memory, because a session leaves a segment of it behind; a lease that outlasts any
stand-still, because all links are of one host, where the kernel closes the sockets of the dead at
once.
"""

from __future__ import annotations

import math
import os
import re
import threading
from collections.abc import Callable, Iterable, Mapping

import zenoh

from rtkit.errors import Malformed, Unreachable
from rtkit.link import places
from rtkit.link.deadline import deadline_from_bytes, deadline_to_bytes
from rtkit.link.threads import start_thread
from rtkit.property.exchange import Reply, Request, failure

_RETRY = "{period_init_ms: 50, period_max_ms: 200, period_increase_factor: 1.5}"
LEASE_S = 600.0
"""How long a peer may be silent until it is given up: what stands still is not dead (decision 18)
[s]."""

_MOST_BETWEEN = 128 << 20
"""How much a message between hosts may hold [bytes]: it is kept here until it is whole."""

_ID = "id="
NOTHING: Mapping[str, str] = {}
_NOBODY = "nobody answers for it"
_ERROR_ENCODING = zenoh.Encoding("text/plain;rtkit.error")


def _config(mode: str, settings: dict[str, str]) -> zenoh.Config:
    config = zenoh.Config()
    common = {
        # Decision 3: each endpoint is known, so nothing waits for scouting, or is found by it.
        "mode": f'"{mode}"',
        "scouting/multicast/enabled": "false",
        "scouting/gossip/enabled": "false",
        "scouting/delay": "0",
        "open/return_conditions/connect_scouted": "false",
        "connect/retry": _RETRY,
        "transport/link/tx/lease": str(int(LEASE_S * 1000)),
        "transport/shared_memory/enabled": "false",
    }
    for key, value in {**common, **settings}.items():
        config.insert_json5(key, value)
    return config


def unix_endpoint(path: str) -> str:
    """Return the endpoint of a unix socket; it cannot be seen from it who listens there.

    Raises:
        Refused: Another user can have laid the socket into its folder.
    """
    places.check_trusted(os.path.dirname(path))
    return f"unixsock-stream/{path}"


def open_client(
    endpoint: str,
    timeout_s: float,
    *,
    more: Mapping[str, str] = NOTHING,
) -> zenoh.Session:
    """Open a client session to one endpoint, or fail within `timeout_s` [s].

    Raises:
        Unreachable: Nobody listens there, or it does not answer.
    """
    timeout_ms = str(max(1, int(timeout_s * 1000)))
    settings = {
        "connect/endpoints": f'["{endpoint}"]',
        "connect/timeout_ms": "0",
        "connect/exit_on_failure": "true",
        "transport/unicast/open_timeout": timeout_ms,
        **more,
    }
    config = _config("client", settings)
    opened = _in_background(lambda: zenoh.open(config))
    if isinstance(opened, zenoh.ZError):
        cause = f": {_bare(opened)}" if opened.__cause__ is not None else ""
        raise Unreachable(f"cannot reach {endpoint}{cause}") from opened
    return opened


def open_to_service(service: str, timeout_s: float) -> zenoh.Session:
    """Open a client session to a property service of this host.

    One that had no zenoh until now (decision 92) hangs up when it has it, and is tried once more.

    Raises:
        Unreachable: There is none, or it does not answer.
    """
    endpoint = unix_endpoint(places.service_key_socket(service))
    try:
        return open_client(endpoint, timeout_s)
    except Unreachable:
        return open_client(endpoint, timeout_s)


def _in_background(work: Callable[[], zenoh.Session]) -> zenoh.Session | zenoh.ZError:
    # zenoh.open is not interrupted by Ctrl-C before it is done, a wait for a thread is.
    outcome: list[zenoh.Session | zenoh.ZError] = []

    def run() -> None:
        try:
            outcome.append(_without_panic(work))
        except zenoh.ZError as error:
            outcome.append(error)

    start_thread(run, "open").join()
    return outcome[0]


def _without_panic(work: Callable[[], zenoh.Session]) -> zenoh.Session:
    """Open a session; a panic of zenoh, for lack of threads, is an error too."""
    try:
        return work()
    except Exception:
        raise
    except BaseException as panic:  # its class has no name that could be imported
        if type(panic).__name__ != "PanicException":
            raise
        raise zenoh.ZError(str(panic)) from panic


def open_listener(
    endpoint: str,
    mode: str = "router",
    *,
    more: Mapping[str, str] = NOTHING,
) -> zenoh.Session:
    """Open a session that listens on one endpoint.

    Raises:
        Unreachable: The endpoint is taken or cannot be made.
    """
    settings = {"listen/endpoints": f'["{endpoint}"]', **more}
    try:
        return _without_panic(lambda: zenoh.open(_config(mode, settings)))
    except zenoh.ZError as error:
        raise Unreachable(f"cannot listen on {endpoint}: {_bare(error)}") from error


def open_between(endpoints: Iterable[str], rules: str, lease_ms: int) -> zenoh.Session:
    """Open a router that joins others and listens nowhere; `rules` say what passes.

    Args:
        endpoints: Of those others; each is to answer.
        rules: Access rules of zenoh, as JSON.
        lease_ms: How long those others bear its silence [ms].

    Raises:
        Unreachable: One does not answer.
    """
    import json

    settings = {
        "connect/endpoints": json.dumps([*endpoints]),
        "connect/timeout_ms": "0",
        "connect/exit_on_failure": "true",
        "listen/endpoints": "[]",
        "access_control": rules,
        "transport/link/tx/lease": str(lease_ms),
        "transport/link/rx/max_message_size": str(_MOST_BETWEEN),
    }
    try:
        return _without_panic(lambda: zenoh.open(_config("router", settings)))
    except zenoh.ZError as error:
        raise Unreachable(f"the routers cannot be joined: {_bare(error)}") from error


def await_answerer(endpoint: str, key: str, timeout_s: float) -> None:
    """Wait until a query of this key, sent to the router at an endpoint, reaches somebody.

    Raises:
        Unreachable: It does not in time [s], or there is no router.
    """
    session = open_client(endpoint, timeout_s)
    try:
        querier = session.declare_querier(key)
        known = threading.Event()
        querier.declare_matching_listener(lambda status: known.set() if status.matching else None)
        status = querier.matching_status
        is_known: bool = status.matching  # type: ignore[attr-defined]  # its stub is wrong
        if not is_known and not known.wait(timeout_s):
            raise Unreachable(f"nobody answers for {key}")
    finally:
        session.close()  # type: ignore[no-untyped-call]


def ask_router_id(endpoint: str) -> str:
    """Return the id of the router at an endpoint.

    Raises:
        Unreachable: None answers.
    """
    session = open_client(endpoint, 5.0)
    try:
        return str(next(iter(session.info.routers_zid())))
    except StopIteration:
        raise Unreachable(f"no router at {endpoint}") from None
    finally:
        session.close()  # type: ignore[no-untyped-call]


def _bare(error: zenoh.ZError) -> str:
    """Return the message of an error of zenoh, without the line of its source."""
    return re.sub(r" at /\S+\.rs:\d+\.?", "", str(error)).rstrip(".")


def ask(
    session: zenoh.Session,
    key: str,
    timeout_s: float,
    payload: str | bytes | None = None,
    attachment: bytes | None = None,
) -> Iterable[zenoh.Reply]:
    """Send a query; return its replies, as they come.

    Raises:
        zenoh.ZError: The session is closed, or it is no key.
    """
    return session.get(
        key,
        payload=payload,
        attachment=attachment,
        timeout=timeout_s,
        handler=zenoh.handlers.FifoChannel(16),
        consolidation=zenoh.ConsolidationMode.NONE,
    )


class ZenohLink:
    """A `Link` over one zenoh session."""

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self._declared: list[zenoh.Queryable[None] | zenoh.Publisher] = []

    def call(self, key: str, payload: str | None, timeout_s: float) -> Reply:
        """See `Link.call`."""
        return self.send(key, payload, timeout_s)()

    def send(self, key: str, payload: str | None, timeout_s: float) -> Callable[[], Reply]:
        """See `Link.send`."""
        try:
            replies = ask(self._session, key, timeout_s, payload, deadline_to_bytes(timeout_s))
        except zenoh.ZError as error:
            if self._session.is_closed():
                raise Unreachable("the connection is closed") from error
            raise Malformed(f"not a property: {key}") from error
        return lambda: _first(replies, timeout_s)

    def ask_later(
        self, key: str, payload: str | None, timeout_s: float, answer: Callable[[Reply], object]
    ) -> None:
        """Send a GET or SET; `answer` is called once, on a thread of zenoh, and must only enqueue.

        Raises:
            Unreachable: The connection is closed.
        """
        waiting = [answer]

        def take(reply: zenoh.Reply) -> None:
            if waiting:
                waiting.pop()(_reply_of(reply, timeout_s))

        def end() -> None:
            if waiting:
                waiting.pop()(Reply(_NOBODY, Unreachable.kind))  # else it is told of the time-out

        try:
            self._session.get(
                key,
                payload=payload,
                attachment=deadline_to_bytes(timeout_s),
                timeout=timeout_s,
                handler=zenoh.handlers.Callback(take, end, indirect=False),
                consolidation=zenoh.ConsolidationMode.NONE,
            )
        except zenoh.ZError as error:
            raise Unreachable("the connection is closed") from error

    def serve(self, service_key: str, enqueue: Callable[[Request], object]) -> None:
        """See `Link.serve`."""
        for mark, is_extension in (("@", False), ("@x", True)):
            prefix = f"{service_key}/{mark}/"
            handler = zenoh.handlers.Callback(
                _receiver(prefix, is_extension, enqueue), indirect=False
            )
            self._declared.append(self._session.declare_queryable(prefix + "**", handler))

    def announce(self, key: str, listened: Callable[[bool], object]) -> Callable[[str], object]:
        """See `Link.announce`."""
        publisher = self._session.declare_publisher(
            key, congestion_control=zenoh.CongestionControl.DROP
        )
        publisher.declare_matching_listener(lambda status: listened(status.matching))
        self._declared.append(publisher)
        return publisher.put

    def listen(self, key: str, on_text: Callable[[str], object]) -> Callable[[], object]:
        """See `Link.listen`."""

        def take(sample: zenoh.Sample) -> None:
            on_text(sample.payload.to_string())

        handler = zenoh.handlers.Callback(take, indirect=False)
        return self._session.declare_subscriber(key, handler).undeclare

    def answer(self, key: str, enqueue: Callable[[Request], object]) -> Callable[[], object]:
        """Have requests of one key enqueued, from now until what it returns is called."""
        handler = zenoh.handlers.Callback(_receiver(key, True, enqueue), indirect=False)
        return self._session.declare_queryable(key, handler).undeclare

    def notice(self, key: str, found: Callable[[bool], object]) -> Callable[[], object]:
        """See `Link.notice`."""
        querier = self._session.declare_querier(key)
        querier.declare_matching_listener(lambda status: found(status.matching))
        status = querier.matching_status
        found(status.matching)  # type: ignore[attr-defined]  # its stub is wrong
        return querier.undeclare

    def close(self) -> None:
        """See `Link.close`."""
        self.withdraw()
        self._session.close()  # type: ignore[no-untyped-call]

    def withdraw(self) -> None:
        """Serve nothing any more.

        Closing a session with what it declared, while one that is connected to it closes too, is a
        race inside zenoh, which ended in a panic of a thread of it in 24 of 200 cases.
        """
        while self._declared:
            self._declared.pop().undeclare()  # type: ignore[no-untyped-call]


def _first(replies: Iterable[zenoh.Reply], timeout_s: float) -> Reply:
    for reply in replies:
        if reply.ok is not None:
            return Reply(reply.ok.payload.to_string())
        if reply.err is not None:
            return _error_reply(reply.err, timeout_s)
    raise Unreachable(_NOBODY)


def _reply_of(reply: zenoh.Reply, timeout_s: float) -> Reply:
    try:
        return _first([reply], timeout_s)
    except Unreachable as error:
        return failure(error)


def _receiver(
    prefix: str, is_extension: bool, enqueue: Callable[[Request], object]
) -> Callable[[zenoh.Query], None]:
    def receive(query: zenoh.Query) -> None:
        key = str(query.key_expr)

        def answer(reply: Reply) -> None:
            if reply.error:
                query.reply_err(f"{reply.error} {reply.text}", encoding=_ERROR_ENCODING)
            else:
                query.reply(key, reply.text)
            query.drop()  # type: ignore[no-untyped-call]

        try:
            payload = query.payload.to_string() if query.payload is not None else None
        except ValueError:  # which is what zenoh raises
            answer(Reply("payload is not UTF-8 text", "malformed"))
            return
        attached, given = query.attachment, str(query.parameters)
        until = math.inf if attached is None else deadline_from_bytes(attached.to_bytes())
        id = given.removeprefix(_ID) if given.startswith(_ID) else ""
        enqueue(Request(key.removeprefix(prefix), payload, answer, is_extension, until, id))

    return receive


def _error_reply(error: zenoh.ReplyError, timeout_s: float) -> Reply:
    text = error.payload.to_string()
    if error.encoding != _ERROR_ENCODING:
        raise Unreachable(f"no answer within {timeout_s:g} s")
    kind, _, message = text.partition(" ")
    return Reply(message, kind)
