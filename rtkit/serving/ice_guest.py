"""One client of the Ice door: who it is, how much it may still send, and who listens for it."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from time import monotonic
from typing import Any, NamedTuple

from rtkit.link import ice
from rtkit.link.ice import DOOR, LEASE_S
from rtkit.property.codes import PropertyError
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.listening import Listener
from rtkit.property.messages import Answer, Ask, Caller, Payload
from rtkit.serving.host import Host
from rtkit.serving.ice_ear import IceEar
from rtkit.serving.login import Login
from rtkit.serving.pace import too_fast
from rtkit.serving.room import Room

_IDLE_S = 60
_HIGH = 1 << 20
"""Bytes of answers that may lie unread, above which no further request is taken."""
_MOST_WAITING = 4096
"""Requests that are being worked on or wait, and bytes of them, above which a client is cut off."""
_MOST_HELD = 1 << 22
_HEAD = 64
_LONGEST_IDENTITY = 255


class Asked(NamedTuple):
    """A request as it came.

    Attributes:
        payload: None of a GET, and of who wants to listen.
        listener: The identity of who wants to listen.
        until: When the client gives it up, by the monotonic clock of this host [s].
    """

    service: str
    target: str
    payload: Payload | None
    answer: Callable[[Answer], None]
    listener: Any = None
    until: float = math.inf

    @property
    def size(self) -> int:
        """How many characters or bytes it has, about."""
        return len(self.target) + len(self.payload or "")


class IceGuest(Caller):
    """A client behind a connection; used on the loop, or by who holds the lock of the host.

    Args:
        connection: Of Ice.
    """

    def __init__(self, host: Host, connection: Any, login: Login, room: Room) -> None:
        super().__init__()
        self.access = room.access
        self._host = host
        self._connection = connection
        self._login = login
        self._room = room
        self._pace = room.pace()
        self._ears: dict[str, IceEar] = {}
        self._held: deque[Asked] = deque()
        self._held_size = 0
        self._waiting = 0
        self._unread = 0
        self._marked = 0
        nobody = connection.createProxy(ice.identity_of("nobody"))
        self._mark = nobody.ice_oneway()

    @property
    def listening(self) -> int:
        """How much it listens to."""
        return sum(each.listening for each in self._ears.values())

    def listen(self, listener: Listener) -> None:
        """See `Caller.listen`: events need somebody to call."""
        raise PropertyError("denied", "events are for a listener: listen")

    # Requests

    def take(self, asked: Asked) -> None:
        """Take a request, now or when replies to earlier ones have been read."""
        if self._waiting >= _MOST_WAITING or self._held_size > _MOST_HELD:
            self.cut_off()
            asked.answer(Answer(f"{self._waiting} requests are not answered", "busy"))
            return
        self._waiting += 1
        if self._unread <= _HIGH:
            self._work(asked)
        else:
            self._held.append(asked)
            self._held_size += asked.size

    def _work(self, asked: Asked) -> None:
        def answer(reply: Answer) -> None:
            self._waiting -= 1
            asked.answer(reply)
            self._sent(len(reply.payload) + _HEAD)

        most = self._room.limits.size
        if self._pace is not None and not self._pace.takes(monotonic()):
            answer(Answer(too_fast(self._room.limits.rate), "busy"))
        elif asked.size > most:
            answer(Answer(f"longer than {most} bytes", "too-large"))
        elif asked.service == DOOR or not self.identity:
            self._enter(asked, answer)
        elif asked.service not in self._host.services:
            answer(Answer(f"no such service: {asked.service}", "no-service"))
        else:
            self._dispatch(asked, answer)

    def _enter(self, asked: Asked, answer: Callable[[Answer], None]) -> None:
        was_known = bool(self.identity)
        answer(self._login.take(self, asked.service, asked.target, asked.payload))
        if self._login.is_refused:
            self._connection.close(ice.runtime().ice.ConnectionClose.Gracefully)
        elif self.identity and not was_known:
            runtime = ice.runtime().ice
            # Now it may wait for as long as an action takes.
            self._connection.setACM(
                _IDLE_S, runtime.ACMClose.CloseOnIdle, runtime.ACMHeartbeat.HeartbeatOff
            )

    def _dispatch(self, asked: Asked, answer: Callable[[Answer], None]) -> None:
        service = self._host.services[asked.service]
        if asked.listener is None:
            if monotonic() > asked.until:
                answer(Answer(NOT_BEGUN, "timeout"))
                return
            ask = Ask(asked.target, asked.payload, answer, self, until=asked.until)
            service.handle(ask)
            return
        try:
            ear = self._ear(asked.listener)
        except PropertyError as error:
            answer(Answer(str(error), error.code))
            return

        def answered(reply: Answer) -> None:
            answer(reply)
            if not ear.listening:
                self.drop(ear)

        service.handle(Ask(_to_listen(asked.target), "self", answered, ear))

    def _ear(self, identity: Any) -> IceEar:
        key = ice.runtime().ice.identityToString(identity)
        if len(key) > _LONGEST_IDENTITY:
            raise PropertyError("too-large", f"more than {_LONGEST_IDENTITY} bytes of identity")
        if key not in self._ears:
            proxy = self._connection.createProxy(identity)
            self._ears[key] = IceEar(self._host, self, key, proxy, self._room)
        return self._ears[key]

    def _sent(self, size: int) -> None:
        """Note an answer; nobody tells when it is read but a mark that is sent behind it."""
        self._unread += size
        if self._unread <= _HIGH or self._marked:
            return
        self._marked = self._unread
        try:
            mark = self._mark.ice_pingAsync()
        except ice.runtime().ice.Exception:
            return  # the connection has ended, which is heard of
        mark.add_sent_callback(lambda *_: self._host.post(self._arrived))

    def _arrived(self) -> None:
        self._unread -= self._marked
        self._marked = 0
        while self._held and self._unread <= _HIGH:
            asked = self._held.popleft()
            self._held_size -= asked.size
            self._work(asked)
        self._sent(0)

    # The end

    def check(self, now: float) -> None:
        """Look whether it takes too long to say who it is."""
        if not self.identity and now > self._login.ends_at:
            self.cut_off()

    def cut_off(self) -> None:
        """End its connection, of which the door hears."""
        self._connection.close(ice.runtime().ice.ConnectionClose.Forcefully)

    def leave(self) -> None:
        """Forget it: its connection has ended."""
        held, self._held = list(self._held), deque()
        for asked in held:
            asked.answer(Answer("the connection has ended", "no-service"))
        ears, self._ears = list(self._ears.values()), {}
        for service in self._host.services.values():
            service.forget(self)
            for ear in ears:
                service.forget(ear)

    def drop(self, ear: IceEar) -> None:
        """Forget one that listens."""
        if self._ears.get(ear.key) is ear:
            del self._ears[ear.key]
            for service in self._host.services.values():
                service.forget(ear)


def _to_listen(target: str) -> str:
    """Return the target to which is said who listens, with a lease."""
    name, _, given = target.partition("?")
    is_leased = any(each.startswith(("lease=", "remove")) for each in given.split("&"))
    wishes = [each for each in (given, "" if is_leased else f"lease={LEASE_S:g}") if each]
    return f"{name}.listen".lstrip(".") + f"?{'&'.join(wishes)}"
