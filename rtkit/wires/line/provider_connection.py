"""Connection of a proxy to its owner over the line protocol, on the loop of the host."""

from __future__ import annotations

import itertools
import select
import socket
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from math import inf
from time import monotonic

from rtkit.link.deadline import with_deadline
from rtkit.property.codes import PropertyError
from rtkit.property.line import Replies, write_request
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.property.subscription import listen_target
from rtkit.serving.event_loop import IOHandler, PropertyEventLoop
from rtkit.wires.provider_connection import (
    STATUS,
    Answering,
    EventHandler,
    Gone,
    Keepalive,
    ProviderConnection,
    slot,
)

_PIECE = 1 << 16
_MOST_OUT = 1 << 24
"""Bytes that wait to be sent, above which a request is rejected."""
_MOST_LISTENINGS = 1000


class LineConnection(ProviderConnection, IOHandler):
    """One connection over the line protocol.

    Args:
        end: A connected socket, of somebody who knows already who asks.
        service: Which one is meant; empty for that of the endpoint.

    Attributes:
        is_overtaking: A request that is sent while others wait has an id.
    """

    is_overtaking = False
    _key_of = staticmethod(slot)
    _subscriptions: dict[str, EventHandler | None]

    def __init__(self, host: PropertyEventLoop, end: socket.socket, service: str = "") -> None:
        super().__init__(host)
        self._end = end
        self._prefix = f"{service}/" if service else ""
        self._replies = Replies()
        self._out = bytearray()
        self._in_turn: deque[Answering] = deque()
        self._by_id: dict[str, deque[Answering]] = {}
        self._silence = Keepalive()
        self._is_stuck = self._is_lent = False

    # Contact

    def start(self, gone: Gone) -> None:
        """See `ProviderConnection.start`."""
        super().start(gone)
        self._end.settimeout(0)
        self._host.register(self._end, self)

    def ask(
        self, target: str, payload: Payload | None, id: str, answer: Answering, until: float = inf
    ) -> None:
        """See `ProviderConnection.ask`.

        What could have to wait at the owner has an id, so that replies to others overtake its own.
        """
        if len(self._out) > _MOST_OUT:
            answer(Answer("the owner takes nothing more", "busy"))
            return
        if not id and ("?" in target or (self.is_overtaking and self._is_waited_for)):
            id = f"~{next(self._count)}"
        if not self._is_waited_for:
            self._silence.end()
        if id:
            self._by_id.setdefault(id, deque()).append(answer)
        else:
            self._in_turn.append(answer)
        target = self._prefix + target
        if payload is not None:
            target = with_deadline(target, until)
        self._out += write_request(target, payload, id)
        self._send()

    def has_room(self, name: str) -> bool:
        """See `ProviderConnection.has_room`: a connection has one listener per property."""
        return super().has_room(name) and len(self._subscriptions) < _MOST_LISTENINGS

    def listen(self, name: str, options: str, on_event: EventHandler, answer: Answering) -> None:
        """See `ProviderConnection.listen`."""
        self._subscriptions[slot(name)] = on_event
        answered = self._answering(name, on_event, answer)
        self.ask(listen_target(name, options), "self", "", answered)

    def leave(self, name: str) -> None:
        """See `ProviderConnection.leave`; events come until the owner has received it."""
        key = slot(name)
        if key in self._subscriptions:
            self._subscriptions[key] = None
            self.ask(listen_target(name, "remove"), "self", "", lambda _: self._take_off(key))

    def check(self, now: float) -> None:
        """See `ProviderConnection.check`."""
        if self._is_waited_for or self._subscriptions:
            probe = partial(self.ask, STATUS, None, "", lambda _: None)
            self._silence.check(now, probe, self._fail)

    # IOHandler

    def ready(self, mask: int) -> None:
        """See `IOHandler.ready`."""
        if mask & select.EPOLLOUT:
            self._send()
        if self._is_open and mask & ~select.EPOLLOUT and not self._is_lent:
            self._receive()

    def _receive(self) -> None:
        """Take what has arrived."""
        try:
            data = self._end.recv(_PIECE)
        except BlockingIOError:
            return
        except OSError as error:
            self._fail(f"the connection has ended: {error.strerror}")
            return
        if not data:
            self._fail("the connection has ended")
            return
        self._silence.end()
        self._replies.feed(data)
        try:
            while self._is_open and (received := self._replies.next()) is not None:
                self._take(received)
                if self._replies.is_idle:
                    break  # as after nearly each
        except PropertyError as error:
            self._fail(f"no line protocol: {error}")

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`: what waits goes when the owner takes it."""
        return None

    # A thread that waits for an answer

    def receive_here(self, is_answered: Callable[[], bool], until: float) -> None:
        """Receive on this thread until its answer is here, or its time over; without the lock.

        Decision 92: the loop would have to wake first, and then this thread. One thread does so at
        a time; it takes the answers of others as well, and lets the loop receive when it is done.

        Args:
            is_answered: Whether what the thread waits for has come.
            until: When it waits no longer, by the monotonic clock [s].
        """
        poll = select.poll()
        with self._host.lock:
            if not self._lend():
                return
            poll.register(self._end, select.POLLIN)
        try:
            while not is_answered() and (left_s := until - monotonic()) > 0:
                poll.poll(None if left_s == inf else left_s * 1000)
                with self._host.lock:
                    if self._is_open:
                        self._receive()
        finally:
            with self._host.lock:
                self._is_lent = False
                if self._is_open:
                    self._await_owner()

    def _lend(self) -> bool:
        """Let a thread receive in place of the loop; return whether it may."""
        is_plain = type(self._end) is socket.socket  # TLS has bytes that no poll tells of
        if self._is_lent or not (is_plain and self._is_open and self._is_waited_for):
            return False
        self._is_lent = True
        self._await_owner()
        return True

    def _await_owner(self) -> None:
        self._host.await_room(self._end, reads=not self._is_lent, writes=self._is_stuck)

    # Its own

    @property
    def _is_waited_for(self) -> bool:
        return bool(self._in_turn or self._by_id)

    def _take(self, received: tuple[str, Answer] | PropertyEvent) -> None:
        if isinstance(received, PropertyEvent):
            on_event = self._subscriptions.get(slot(received.name))
            if on_event is not None:
                on_event(received)
            return
        id, reply = received
        waiting = self._by_id.get(id) if id else self._in_turn
        if not waiting:
            raise PropertyError("syntax", "0 expected no reply")
        answer = waiting.popleft()
        if id and not waiting:
            del self._by_id[id]
        answer(reply)

    def _send(self) -> None:
        if not self._is_open:
            return
        try:
            while self._out:
                sent = self._end.send(memoryview(self._out)[:_MOST_OUT])
                del self._out[:sent]
        except BlockingIOError:
            pass
        except OSError:
            return  # whatever it said before it hung up is read first, then the end
        if bool(self._out) is not self._is_stuck:
            self._is_stuck = bool(self._out)
            self._await_owner()

    def _take_callers(self) -> list[Answering]:
        callers = [*self._in_turn, *itertools.chain(*self._by_id.values())]
        self._in_turn.clear()
        self._by_id.clear()
        return callers

    def _release(self) -> None:
        self._host.unregister(self._end, self)
        if self._is_lent:
            with suppress(OSError):  # whoever receives here wakes; unless the owner was quicker
                self._end.shutdown(socket.SHUT_RDWR)
        self._end.close()
        self._subscriptions.clear()
