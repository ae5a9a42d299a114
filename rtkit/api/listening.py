"""Listening of clients: subscriptions that outlive the connection, and callbacks on a thread."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from queue import SimpleQueue
from time import monotonic

from rtkit.api.property_change import PropertyChange
from rtkit.closing import Closing
from rtkit.property.messages import Answer, PropertyEvent
from rtkit.property.requests import ListeningRequester, PropertyRequest
from rtkit.proxy.subscriptions import RelayedSubscriptions
from rtkit.proxy.uplink import Uplink
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.wires.provider_connection import Answering, ConnectionMaker


class ListenedOwner:
    """Owner that is listened to, over connections of its own; used under the lock of the host."""

    def __init__(self, host: PropertyEventLoop, connect: ConnectionMaker) -> None:
        usable = lambda _connection, judged: judged("")  # noqa: E731
        self.uplink = Uplink(host, connect, usable, self._came, self._went)
        self.subscriptions = RelayedSubscriptions(self.uplink, str, monotonic)
        self._waiting: list[Callable[[], None]] = []
        self._is_known = False

    def begin(
        self, name: str, options: dict[str, str | None], who: Listening, answer: Answering
    ) -> None:
        """Listen to a property, once it is known whether the owner can be reached."""
        self._waiting.append(lambda: self.subscriptions.begin(name, options, who, answer))
        if self._is_known:
            self._go_on()

    def _go_on(self) -> None:
        self._is_known = True
        waiting, self._waiting = self._waiting, []
        for begin in waiting:
            begin()

    def _came(self) -> None:
        self.subscriptions.came()
        self._go_on()

    def _went(self, _why: str) -> None:
        self.subscriptions.went()
        self._go_on()


class Listening(ListeningRequester, Closing):
    """Subscription of a client; close it to hear no more."""

    def __init__(
        self,
        typed: str,
        callback: Callable[[PropertyChange], object],
        object_of: Callable[[PropertyEvent], object],
        changes: Changes,
    ) -> None:
        super().__init__("owner")
        self.typed = typed
        self.answer: Answer | None = None
        self.is_answered = threading.Event()
        self._callback = callback
        self._object_of = object_of
        self._changes = changes
        self._is_due = self._is_over = False

    def wake(self) -> None:
        """See `Requester.wake`."""
        if not self._is_due:
            self._is_due = True
            self._changes.due.put(self)

    def answered(self, reply: Answer) -> None:
        """Take the owner's answer."""
        self.answer = reply
        self.is_answered.set()

    def deliver(self, lock: threading.Lock) -> None:
        """Call back with each change that waits; what that raises is reported, and it goes on."""
        events: list[PropertyEvent] = []
        with lock:
            self._is_due = False
            self.send_due(monotonic(), lambda: True, lambda _, event: events.append(event))
        for event in events:
            if self._is_over:
                return
            code = event.code or ("no-service" if event.quality == "stale" else "")
            change = PropertyChange(
                self.typed, self._object_of(event), event.time, event.quality, code
            )
            try:
                self._callback(change)
            except Exception:
                raised = (*sys.exc_info(), threading.current_thread())
                threading.excepthook(threading.ExceptHookArgs(raised))

    def close(self) -> None:
        """Hear no more; a callback that runs ends by itself."""
        self._is_over = True
        self._changes.end(self)


class Changes(PropertyProvider):
    """All that a client listens to, and the thread that calls back."""

    name = "changes"
    has_groups = False

    def __init__(self, host: PropertyEventLoop) -> None:
        self.due: SimpleQueue[Listening | None] = SimpleQueue()
        self._host = host
        self._owners: dict[ConnectionMaker, ListenedOwner] = {}
        self._of: dict[Listening, ConnectionMaker] = {}
        with host.lock:
            host.add(self)
        threading.Thread(target=self._call_back, name="changes", daemon=True).start()

    def begin(
        self, connect: ConnectionMaker, name: str, options: dict[str, str | None], who: Listening
    ) -> None:
        """Have a property listened to."""
        with self._host.lock:
            is_new = connect not in self._owners
            if is_new:
                self._owners[connect] = ListenedOwner(self._host, connect)
            owner = self._owners[connect]
            self._of[who] = connect
            owner.begin(name, options, who, who.answered)
        if is_new:
            owner.uplink.start()

    def end(self, who: Listening) -> None:
        """End a subscription, and the connection that nobody uses any more."""
        with self._host.lock:
            connect = self._of.pop(who, None)
            if connect is None:
                return
            owner = self._owners[connect]
            owner.subscriptions.forget(who)
            if connect not in self._of.values():
                del self._owners[connect]
                owner.uplink.close()

    def handle(self, ask: PropertyRequest) -> None:
        """See `PropertyProvider.handle`: nobody can ask a client."""
        ask.answer(Answer("a client has no properties", "unknown"))

    def forget(self, caller: object) -> None:
        """See `PropertyProvider.forget`: nobody listens to a client."""

    def tick(self) -> None:
        """See `PropertyProvider.tick`."""
        for owner in self._owners.values():
            owner.subscriptions.tick()
            owner.uplink.check(monotonic())

    def close(self) -> None:
        """End all; under the lock of the host."""
        self.due.put(None)
        for owner in self._owners.values():
            owner.uplink.close()
        self._owners.clear()
        self._of.clear()

    def _call_back(self) -> None:
        while (listening := self.due.get()) is not None:
            listening.deliver(self._host.lock)
