"""Connection of a proxy to the owner it stands for: its interface, and what each wire builds on."""

from __future__ import annotations

import itertools
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable
from functools import partial
from math import inf
from time import monotonic
from typing import Any

from rtkit.property.codes import PASSING
from rtkit.property.messages import Answer, Mark, Payload, PropertyEvent
from rtkit.property.naming import parse_parameters, with_parameter
from rtkit.property.subscription import LEASE_S, LONGEST_QUEUE
from rtkit.serving.event_loop import PropertyEventLoop

Answering = Callable[[Answer], object]
EventHandler = Callable[[PropertyEvent], object]
Gone = Callable[[str], object]

ENDED = Answer("the connection has ended", "no-service")
STATUS = "~proxy.status"
"""Property that every proxy answers itself; asked of a silent peer, to learn that it lives."""
ASKED_S = 5.0
"""Silence after which a peer that owes an answer is asked for a sign of life [s]."""
DEAD_S = 15.0
"""Silence after which the connection is given up [s]."""


class ProviderConnection(ABC):
    """Connection to an owner, used by the loop only; its callbacks run there."""

    _key_of: Callable[[str], str] = staticmethod(str)
    """Returns what a wire knows a subscription by; it carries one for each."""

    def __init__(self, host: PropertyEventLoop) -> None:
        self._host = host
        self._count = itertools.count(1)
        self._callers: dict[int, Answering] = {}
        self._subscriptions: dict[str, Any] = {}
        self._threads: list[threading.Thread] = []
        self._is_open = True
        self._gone: Gone = lambda why: None

    def start(self, gone: Gone) -> None:
        """Start the connection; `gone` is called once with the reason when it ends."""
        self._gone = gone

    @abstractmethod
    def ask(
        self, target: str, payload: Payload | None, id: str, answer: Answering, until: float = inf
    ) -> None:
        """GET, or SET; `answer` is called exactly once, also when the connection ends.

        What is asked one after the other arrives in that order. By the id, one of
        `rtkit.property.idempotency.shared`, a repetition is known; it is empty for nothing. What
        has not begun at `until`, by the monotonic clock of this host [s], is to be done by nobody.
        """

    def has_room(self, name: str) -> bool:
        """Return whether it can listen to this beside what it listens to."""
        return self._key_of(name) not in self._subscriptions

    @abstractmethod
    def listen(self, name: str, options: str, on_event: EventHandler, answer: Answering) -> None:
        """Listen to a property, with the parameters `options`."""

    @abstractmethod
    def leave(self, name: str) -> None:
        """Listen to a property no longer."""

    def check(self, now: float) -> None:  # noqa: B027  not all have anything to look at
        """Check whether the peer has been silent for too long [s, of a monotonic clock]."""

    def close(self) -> None:
        """Close the connection; callers that wait for an answer get an error."""
        self._finish(ENDED)

    def join(self, until: float) -> None:
        """Wait until its threads have ended, by the monotonic clock [s]; not on the loop.

        A process that ends while one of them closes a session of zenoh is aborted.
        """
        for thread in list(self._threads):
            if thread is not threading.current_thread():
                thread.join(max(0.0, until - monotonic()))

    # For the wires

    def _begin_thread(self, work: Callable[..., object], *args: Any, name: str) -> None:
        thread = threading.Thread(target=work, args=args, name=name, daemon=True)
        thread.start()
        self._threads = [*(each for each in self._threads if each.is_alive()), thread]

    @abstractmethod
    def _release(self) -> None:
        """Give back what the connection holds: it has ended."""

    def _take_callers(self) -> Iterable[Answering]:
        """Return the callers that wait for an answer; they wait no longer."""
        callers, self._callers = self._callers, {}
        return callers.values()

    def _expect(self, answer: Answering) -> int:
        """Add a caller that waits; return the number of its request."""
        number = next(self._count)
        self._callers[number] = answer
        return number

    def _answer(self, number: int, reply: Answer) -> None:
        """Answer the caller of a request; none waits once the connection has ended."""
        answer = self._callers.pop(number, None)
        if answer is not None:
            answer(reply)

    def _answering(self, name: str, subscription: object, answer: Answering) -> Answering:
        """Return what passes on the answer to a request to listen; no subscription if refused."""
        key = self._key_of(name)

        def answered(reply: Answer) -> None:
            if reply.error and self._subscriptions.get(key) is subscription:
                self._take_off(key)
            answer(reply)

        return answered

    def _take_off(self, key: str) -> Any:
        """Forget a subscription; return it, None if there is none."""
        return self._subscriptions.pop(key, None)

    def _finish(self, reply: Answer) -> None:
        """End the connection, with the same reply to all callers."""
        if self._is_open:
            self._is_open = False
            for answer in self._take_callers():
                answer(reply)
            self._release()

    def _fail(self, why: str, code: str = "no-service") -> None:
        """End the connection, and report why."""
        if self._is_open:
            self._finish(Answer(why, code))
            self._gone(why)


ConnectionMaker = Callable[[], ProviderConnection]
"""Makes a connection. It may take its time, on a thread of its own, and raises `RtkitError`."""


def with_id(target: str, id: str) -> str:
    """Return a target with an id among its parameters, for wires that have no other place."""
    return with_parameter(target, f"id={id}") if id else target


def over(name: str, reply: Answer) -> PropertyEvent | None:
    """Return the last event of a listening that the owner does not go on with, None if it may."""
    if not reply.error or reply.error in PASSING:
        return None
    return PropertyEvent(name, "", 0.0, 0, "bad", 0, reply.error)


class LeasedSubscription:
    """Subscription that ends at the owner unless it is renewed.

    Args:
        target: Of the request to listen.
        address: At which the owner finds it.
        take: Takes an event of the wire, or the last one, of a property that is gone.
        end: Receives no more.

    Attributes:
        last: Of the event that came last, where a wire repeats events.
    """

    def __init__(
        self,
        target: str,
        address: str,
        take: EventHandler,
        end: Callable[[], object] = lambda: None,
    ) -> None:
        self.target = target
        self.address = address
        self.take = take
        self.end = end
        self.renewed_at = monotonic()
        self.last: Mark | None = None


class LeasedConnection(ProviderConnection):
    """Connection through something that does not tell the owner when this side is gone."""

    _subscriptions: dict[str, LeasedSubscription]

    @abstractmethod
    def _subscribe(self, name: str, options: str, on_event: EventHandler) -> LeasedSubscription:
        """Prepare to receive the events of a property."""

    @abstractmethod
    def _ask_about(
        self, subscription: LeasedSubscription, target: str, answer: Answering, *, is_new: bool
    ) -> None:
        """Ask the owner to begin a subscription, to go on with it or to end it."""

    def listen(self, name: str, options: str, on_event: EventHandler, answer: Answering) -> None:
        """See `ProviderConnection.listen`."""
        subscription = self._subscribe(name, options, on_event)
        self._subscriptions[name] = subscription
        answered = self._answering(name, subscription, answer)
        self._ask_about(subscription, subscription.target, answered, is_new=True)

    def leave(self, name: str) -> None:
        """See `ProviderConnection.leave`."""
        subscription = self._take_off(name)
        if subscription is not None:
            target = f"{subscription.target.partition('?')[0]}?remove"
            self._ask_about(subscription, target, lambda _: None, is_new=False)

    def check(self, now: float) -> None:
        """See `ProviderConnection.check`: renew leases."""
        for name, each in self._subscriptions.items():
            if now - each.renewed_at > LEASE_S / 3:
                each.renewed_at = now
                self._ask_about(each, each.target, partial(self._renewed, name, each), is_new=False)

    def _renewed(self, name: str, subscription: LeasedSubscription, reply: Answer) -> None:
        last = over(name, reply)
        if last is not None and self._subscriptions.get(name) is subscription:
            self._take_off(name)
            subscription.take(last)

    def _take_off(self, key: str) -> LeasedSubscription | None:
        subscription = self._subscriptions.pop(key, None)
        if subscription is not None:
            subscription.end()
        return subscription

    def _release(self) -> None:
        for name in list(self._subscriptions):
            self._take_off(name)


def slot(name: str) -> str:
    """Return the name in events of a property: an inner name has events of its listing."""
    return "" if name == "properties" else name.removesuffix(".properties")


class Keepalive:
    """Measures how long nothing has been received."""

    def __init__(self) -> None:
        self._since = monotonic()
        self._is_asked = False

    def end(self) -> None:
        """Note that the peer was heard from, or owes nothing."""
        self._since, self._is_asked = monotonic(), False

    def check(
        self, now: float, ask: Callable[[], object], give_up: Callable[[str, str], object]
    ) -> None:
        """Ask for a sign of life when it has lasted long; give up, saying why, when too long."""
        silent_s = now - self._since
        if silent_s > DEAD_S and self._is_asked:
            give_up(f"no answer within {DEAD_S:g} s", "timeout")
        elif silent_s > ASKED_S and not self._is_asked:
            self._is_asked = True
            ask()


class LoopInbox:
    """Inbox of the events of one subscription.

    Args:
        options: Parameters of the listening; the queue is one of them.
        on_event: Called on the loop with each event.
    """

    def __init__(
        self, host: PropertyEventLoop, options: str, on_event: Callable[[PropertyEvent], object]
    ) -> None:
        self._host = host
        self._on_event = on_event
        self._events: deque[PropertyEvent] = deque(maxlen=_queue_of(options))
        self._dropped = 0
        self._is_posted = False
        self._lock = threading.Lock()

    def put(self, event: PropertyEvent, lost: int = 0) -> None:
        """Take an event, before which some were lost; a full queue drops its oldest."""
        with self._lock:
            if self._events.maxlen != 1:
                event = event._replace(dropped=event.dropped + lost)
            if len(self._events) == self._events.maxlen and self._events.maxlen > 1:
                self._dropped += 1 + self._events[0].dropped
            self._events.append(event)
            if self._is_posted:
                return
            self._is_posted = True
        self._host.post(self._empty)

    def _empty(self) -> None:
        with self._lock:
            events, dropped = list(self._events), self._dropped
            self._events.clear()
            self._dropped, self._is_posted = 0, False
        if dropped:
            events[0] = events[0]._replace(dropped=events[0].dropped + dropped)
        for event in events:
            self._on_event(event)


def _queue_of(options: str) -> int:
    queue = (parse_parameters(options).get("queue") or "1") if options else "1"
    return max(1, min(int(queue), LONGEST_QUEUE)) if queue.isdecimal() else 1
