"""Taps of clients of a gateway: processes that read or write values of ports for them.

Each is a data tool of the manager's own host (decision 15) in a process of its own, which ends with
the connection of its client: what a client leaves to wait fills the memory of no other.
"""

from __future__ import annotations

import json
import os
import socket
import sys
from collections import Counter
from collections.abc import Callable
from typing import Any

from rtkit.errors import Malformed, Refused
from rtkit.link.tap_messages import CALL, DONE, OPEN, WORDS, FrameSplitter, call_from_bytes, frame
from rtkit.link.threads import start_thread
from rtkit.manager.gateway.permissions import OPERATOR, VIEWER, Permission, shown
from rtkit.property.messages import Answer, Payload
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.serving.event_loop import IOHandler, PropertyEventLoop

PREFIX = "@x/tap/"
_MODULE = "rtkit.probe.far_tap"
_MOST, _MOST_OF_ONE = 16, 4
"""Taps at a gateway, and those of one name."""
_MOST_OUT = 1 << 24
_CHUNK = 1 << 18
_MOST_NAMED = 3
_OPEN, _CALL = WORDS[OPEN], WORDS[CALL]

Check = Callable[[Permission], object]
Answering = Callable[[Answer], object]


class Taps:
    """The taps of all clients.

    Args:
        host: Owner of the loop that calls it.
        manager: Manager of the ports.
    """

    def __init__(self, host: PropertyEventLoop, manager: str) -> None:
        self._host = host
        self._manager = manager
        self._taps: dict[Requester, _Tap] = {}

    def take(
        self,
        ask: PropertyRequest,
        word: str,
        caller: Requester,
        check: Check,
        record: Callable[[str, str], object],
    ) -> None:
        """Take a request of a client to its tap, which the first one opens.

        Args:
            ask: The request.
            word: Work of the tap.
            caller: The client.
            check: Raises if it may not do what it wants.
            record: Puts on record what it wants, and what came of that.

        Raises:
            Malformed: It is none.
            Refused: There are enough taps.
        """
        payload = ask.payload or b""
        body = payload.encode("utf-8", "surrogatepass") if isinstance(payload, str) else payload
        tap = self._taps.get(caller)
        answer: Answering = ask.answer
        if word == _OPEN:
            wanted = _permission(body)
            check(wanted)
            if tap is not None:
                raise Refused("this connection has a tap already")
            tap = self._begin(caller)
            if wanted.role != VIEWER:
                answer = _recorded(answer, wanted.what, record)
        elif word == _CALL:
            wanted = _calling(body)
            check(wanted)
            if tap is None or not tap.is_open:
                tap = self._begin(caller)
            answer = _recorded(answer, wanted.what, record, _outcome)
        if word not in WORDS or tap is None:
            raise Malformed(f"no request to a tap: {word[:20]!r}")
        tap.ask(WORDS.index(word), body, answer)

    def _begin(self, caller: Requester) -> _Tap:
        self._taps = {who: tap for who, tap in self._taps.items() if tap.is_open}
        counts = Counter(each.identity for each in self._taps)
        if len(self._taps) >= _MOST or counts[caller.identity] >= _MOST_OF_ONE:
            raise Refused("there are enough taps of ports: end one")
        tap = self._taps[caller] = _Tap(self._host, self._manager)
        return tap

    def forget(self, caller: Requester) -> None:
        """End the tap of a client that has gone."""
        tap = self._taps.pop(caller, None)
        if tap is not None:
            tap.close()


class _Tap(IOHandler):
    """A process, and the requests that it has not answered yet."""

    def __init__(self, host: PropertyEventLoop, manager: str) -> None:
        self._host = host
        self._frames = FrameSplitter()
        self._waiting: dict[int, Answering] = {}
        self._count = 0
        self._out = bytearray()
        self._end, theirs = socket.socketpair()
        self.is_open = True
        with theirs:
            theirs.set_inheritable(True)
            words = [sys.executable, "-P", "-m", _MODULE, str(theirs.fileno()), manager]
            pid = os.posix_spawn(sys.executable, words, os.environ)
        start_thread(lambda: os.waitpid(pid, 0), "reaper")
        self._end.setblocking(False)
        host.register(self._end, self)

    def ask(self, kind: int, body: bytes, answer: Answering) -> None:
        """Send a request."""
        if not self.is_open or len(self._out) > _MOST_OUT:
            why = "it takes no more" if self.is_open else "the process of the tap has ended"
            answer(Answer(why, "busy"))
            return
        self._count = self._count % 0xFFFF_FFFF + 1
        self._waiting[self._count] = answer
        self._out += frame(self._count, kind, body)
        self._send()

    def ready(self, mask: int) -> None:
        """See `IOHandler.ready`."""
        self._send()
        try:
            data = self._end.recv(_CHUNK)
            received = list(self._frames.feed(data))
        except BlockingIOError:
            return
        except (OSError, ValueError):
            data, received = b"", []
        for number, kind, body in received:
            answer = self._waiting.pop(number, None)
            if answer is not None:
                answer(_answer(kind, body))
        if not data:
            self.close()

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`: what waits goes when the process takes it."""
        return None

    def close(self) -> None:
        """End the process, which ends with its socket."""
        if not self.is_open:
            return
        self.is_open = False
        self._host.unregister(self._end, self)
        self._end.close()
        waiting, self._waiting = self._waiting, {}
        for answer in waiting.values():
            answer(Answer("the process of the tap has ended", "no-service"))

    def _send(self) -> None:
        try:
            while self._out and self.is_open:
                del self._out[: self._end.send(memoryview(self._out)[:_CHUNK].tobytes())]
        except BlockingIOError:
            pass
        except OSError:
            self.close()
            return
        if self.is_open:
            self._host.await_room(self._end, reads=True, writes=bool(self._out))


def _answer(kind: int, body: bytes) -> Answer:
    if kind == DONE:
        return Answer(body)
    code, why = json.loads(body)
    return Answer(" ".join(str(why).split()), str(code))


def _recorded(
    answer: Answering,
    what: str,
    record: Callable[[str, str], object],
    outcome: Callable[[Payload], str] = lambda _payload: "done",
) -> Answering:
    def give(given: Answer) -> None:
        record(what, f"{given.error}: {given.payload!s}" if given.error else outcome(given.payload))
        answer(given)

    return give


def _outcome(reply: Payload) -> str:
    """Return what came of a call, by its encoded reply: a provider may raise an exception."""
    head = reply.partition(b"\n")[0].decode(errors="replace") if isinstance(reply, bytes) else ""
    return "done" if head == "ok" else shown(head.replace("\t", " "))


def _calling(body: bytes) -> Permission:
    """Return what the call of an operation takes.

    Raises:
        Malformed: It is no call.
    """
    try:
        (instance, port, _), _, call = call_from_bytes(body)
    except ValueError as error:
        raise Malformed(str(error)) from error
    signature = call.partition(b"\n")[0].partition(b"\t")[2].decode(errors="replace")
    operation = signature.partition("(")[0]
    return Permission(OPERATOR, f"call {shown(f'{instance}.{port}')}.{shown(operation)}")


def _permission(body: bytes) -> Permission:
    """Return what opening a tap takes: who only looks holds up no component, and writes nothing.

    Raises:
        Malformed: It is no request to open one.
    """
    try:
        asked: dict[str, Any] = json.loads(body)
        does = "write values to" if asked["writes"] else "read values of"
        role = OPERATOR if asked["writes"] or asked["lossless"] else VIEWER
        ports = [f"{end[0]}.{end[1]}" for _, ends in asked["streams"] for end in ends]
    except (ValueError, KeyError, TypeError, IndexError, RecursionError) as error:
        raise Malformed(f"no request for a tap: {error}") from error
    more = f" and {len(ports) - _MOST_NAMED} more" if len(ports) > _MOST_NAMED else ""
    named = ", ".join(shown(each) for each in ports[:_MOST_NAMED])
    return Permission(role, f"{does} {named}{more}{' lossless' * bool(asked['lossless'])}")
