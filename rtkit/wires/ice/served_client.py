"""One client of the Ice endpoint: its identity, its remaining quota, and its listeners."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from time import monotonic
from typing import Any, NamedTuple

from rtkit.property.codes import PropertyError
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.messages import Answer, Payload
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.subscription import LEASE_S, Listener, leased, listen_target
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.quota import EndpointQuota, too_fast
from rtkit.wires.ice import protocol
from rtkit.wires.ice.protocol import DOOR
from rtkit.wires.ice.subscriber import IceSubscriber
from rtkit.wires.line.login import Login

_IDLE_S = 60
_HIGH = 1 << 20
"""Bytes of answers that may lie unread, above which no further request is taken."""
_MOST_WAITING = 4096
"""Requests that are being worked on or wait, and bytes of them, above which a client is cut off."""
_MOST_HELD = 1 << 22
_HEAD = 64
_LONGEST_IDENTITY = 255


class IceRequest(NamedTuple):
    """Request as it came.

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
        """Return its approximate size [characters or bytes]."""
        return len(self.target) + len(self.payload or "")


class ServedIceClient(Requester):
    """Client behind a connection; used on the loop, or under the lock of the host.

    Args:
        connection: Of Ice.
    """

    def __init__(
        self, host: PropertyEventLoop, connection: Any, login: Login, quota: EndpointQuota
    ) -> None:
        super().__init__()
        self.access = quota.access
        self._host = host
        self._connection = connection
        self._login = login
        self._quota = quota
        self._pace = quota.pace()
        self._subscriptions: dict[str, IceSubscriber] = {}
        self._held: deque[IceRequest] = deque()
        self._held_size = 0
        self._waiting = 0
        self._unread = 0
        self._marked = 0
        nobody = connection.createProxy(protocol.identity_of("nobody"))
        self._mark = nobody.ice_oneway()

    @property
    def listening(self) -> int:
        """Return how many subscriptions it has."""
        return sum(each.listening for each in self._subscriptions.values())

    def listen(self, listener: Listener) -> None:
        """See `Requester.listen`: events need somebody to call."""
        raise PropertyError("denied", "events are for a listener: listen")

    # Requests

    def take(self, asked: IceRequest) -> None:
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

    def _work(self, asked: IceRequest) -> None:
        def answer(reply: Answer) -> None:
            self._waiting -= 1
            asked.answer(reply)
            self._sent(len(reply.payload) + _HEAD)

        most = self._quota.limits.size
        if self._pace is not None and not self._pace.takes(monotonic()):
            answer(Answer(too_fast(self._quota.limits.rate), "busy"))
        elif asked.size > most:
            answer(Answer(f"longer than {most} bytes", "too-large"))
        elif asked.service == DOOR or not self.identity:
            self._enter(asked, answer)
        elif asked.service not in self._host.services:
            answer(Answer(f"no such service: {asked.service}", "no-service"))
        else:
            self._dispatch(asked, answer)

    def _enter(self, asked: IceRequest, answer: Callable[[Answer], None]) -> None:
        was_known = bool(self.identity)
        answer(self._login.take(self, asked.service, asked.target, asked.payload))
        if self._login.is_refused:
            self._connection.close(protocol.runtime().ice.ConnectionClose.Gracefully)
        elif self.identity and not was_known:
            runtime = protocol.runtime().ice
            # Now it may wait for as long as an action takes.
            self._connection.setACM(
                _IDLE_S, runtime.ACMClose.CloseOnIdle, runtime.ACMHeartbeat.HeartbeatOff
            )

    def _dispatch(self, asked: IceRequest, answer: Callable[[Answer], None]) -> None:
        service = self._host.services[asked.service]
        if asked.listener is None:
            if monotonic() > asked.until:
                answer(Answer(NOT_BEGUN, "timeout"))
                return
            ask = PropertyRequest(asked.target, asked.payload, answer, self, until=asked.until)
            service.handle(ask)
            return
        try:
            subscription = self._subscription(asked.listener)
        except PropertyError as error:
            answer(Answer(str(error), error.code))
            return

        def answered(reply: Answer) -> None:
            answer(reply)
            if not subscription.listening:
                self.drop(subscription)

        name, _, options = asked.target.partition("?")
        target = leased(listen_target(name, options), LEASE_S)
        service.handle(PropertyRequest(target, "self", answered, subscription))

    def _subscription(self, identity: Any) -> IceSubscriber:
        key = protocol.runtime().ice.identityToString(identity)
        if len(key) > _LONGEST_IDENTITY:
            raise PropertyError("too-large", f"more than {_LONGEST_IDENTITY} bytes of identity")
        if key not in self._subscriptions:
            proxy = self._connection.createProxy(identity)
            self._subscriptions[key] = IceSubscriber(self._host, self, key, proxy, self._quota)
        return self._subscriptions[key]

    def _sent(self, size: int) -> None:
        """Note an answer; only a mark that is sent behind it shows when it is read."""
        self._unread += size
        if self._unread <= _HIGH or self._marked:
            return
        self._marked = self._unread
        try:
            mark = self._mark.ice_pingAsync()
        except protocol.runtime().ice.Exception:
            return  # the connection has ended, which a callback reports
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
        """Close its connection, which the endpoint notices."""
        self._connection.close(protocol.runtime().ice.ConnectionClose.Forcefully)

    def leave(self) -> None:
        """Forget it: its connection has ended."""
        held, self._held = list(self._held), deque()
        for asked in held:
            asked.answer(Answer("the connection has ended", "no-service"))
        subscriptions, self._subscriptions = list(self._subscriptions.values()), {}
        for service in self._host.services.values():
            service.forget(self)
            for subscription in subscriptions:
                service.forget(subscription)

    def drop(self, subscription: IceSubscriber) -> None:
        """Forget one that listens."""
        if self._subscriptions.get(subscription.key) is subscription:
            del self._subscriptions[subscription.key]
            for service in self._host.services.values():
                service.forget(subscription)
