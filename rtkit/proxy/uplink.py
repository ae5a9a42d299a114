"""Uplink to the owner: connects, reconnects, and keeps the connections that it consists of.

One connection carries the requests and the subscriptions; another one is made for a subscription
to the same property with other options. When one of them ends, all reconnect.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from math import inf
from time import monotonic

from rtkit.errors import RtkitError
from rtkit.property.codes import PropertyError
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.lanes import first_only
from rtkit.property.messages import Answer, Payload
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.provider_connection import Answering, ConnectionMaker, ProviderConnection

_FIRST_PAUSE_S = 0.05
_LONGEST_PAUSE_S = 2.0
_MOST_CONNECTIONS = 64
_MOST_WAITING = 1 << 16
"""Requests that the owner has not answered."""

Placed = Callable[[ProviderConnection | PropertyError], None]
Judging = Callable[[ProviderConnection, Callable[[str], None]], None]
_GRACE_S = 0.05
"""How much later than the owner a proxy gives up: the owner knows better why [s]."""


class Uplink:
    """Connections to one owner; used on the loop of the host only.

    Args:
        connect: Makes a connection.
        judge: Looks at a new connection and calls with why it cannot be used, empty if it can.
        came: Called when the owner can be reached.
        went: Called with why it no longer can, or cannot be to begin with.

    Attributes:
        label: Put before why a connection has ended, or an owner has not answered.
    """

    label = ""

    def __init__(
        self,
        host: PropertyEventLoop,
        connect: ConnectionMaker,
        judge: Judging,
        came: Callable[[], None],
        went: Callable[[str], None],
    ) -> None:
        self._host = host
        self._connect = connect
        self._judge = judge
        self._came = came
        self._went = went
        self._connections: list[ProviderConnection] = []
        self._wanted: list[tuple[str, Placed]] = []
        self._waiting = 0
        self._pause_s = _FIRST_PAUSE_S
        self._is_closed = threading.Event()
        self._round = 0
        self._is_up = False
        self.why = "not connected yet"

    @property
    def is_up(self) -> bool:
        """Return whether the owner can be reached."""
        return self._is_up

    def start(self) -> None:
        """Begin to connect; from any thread."""
        self._dial(self._connected, 0.0)

    def ask(
        self, target: str, payload: Payload | None, id: str, answer: Answering, until: float = inf
    ) -> None:
        """GET, or SET, and pass on the outcome: at `until` [s, monotonic] at the latest.

        That holds on every wire, whatever its own bounds; a little more is for the owner's answer.
        """
        if not self._is_up:
            answer(Answer(self.why, "no-service"))
            return
        if self._waiting >= _MOST_WAITING:
            answer(Answer(f"{_MOST_WAITING} requests are not answered", "busy"))
            return
        if monotonic() > until:
            answer(Answer(NOT_BEGUN, "timeout"))
            return
        self._waiting += 1

        def answered(reply: Answer) -> None:
            self._waiting -= 1
            answer(reply)

        left_s = until - monotonic() + _GRACE_S
        waiting = answered if until == inf else self._bounded(answered, left_s)
        self._connections[0].ask(target, payload, id, waiting, until)

    def _bounded(self, answer: Answering, wait_s: float) -> Answering:
        """Return what passes on a reply that comes in time; else the requester is told by then."""
        first = first_only(answer)
        late = lambda reply: first(reply._replace(payload=f"{self.label}{reply.payload}"))  # noqa: E731
        in_time = self._host.user_code.refuse_after(wait_s, late)

        def answered(reply: Answer) -> None:
            in_time()
            first(reply)

        return answered

    def place(self, name: str, placed: Placed) -> None:
        """Give a connection on which a property can be listened to, now or later."""
        if not self._is_up:
            placed(PropertyError("no-service", self.why))
            return
        for connection in self._connections:
            if connection.has_room(name):
                placed(connection)
                return
        if len(self._connections) >= _MOST_CONNECTIONS:
            why = f"{_MOST_CONNECTIONS} connections listen in different ways"
            placed(PropertyError("denied", why))
            return
        self._wanted.append((name, placed))
        if len(self._wanted) == 1:
            self._dial(self._widened, 0.0)

    def check(self, now: float) -> None:
        """Look whether the owner has been silent for too long."""
        for connection in list(self._connections):
            connection.check(now)

    def close(self) -> None:
        """Be connected no longer."""
        self._is_closed.set()
        self._lose("the proxy has ended", is_last=True)

    # Connecting

    def _dial(
        self, done: Callable[[int, ProviderConnection | RtkitError], None], pause_s: float
    ) -> None:
        """Make a connection on a thread of its own, after a pause."""
        number = self._round

        def work() -> None:
            if self._is_closed.wait(pause_s):
                return
            made: ProviderConnection | RtkitError
            try:
                made = self._connect()
            except RtkitError as error:
                made = error
            self._host.post(lambda: done(number, made))

        threading.Thread(target=work, name="connecting", daemon=True).start()

    def _connected(self, number: int, made: ProviderConnection | RtkitError) -> None:
        if self._is_old(number, made):
            return
        if isinstance(made, RtkitError):
            self._failed(str(made))
            return
        self._take(made)

        def judged(why: str) -> None:
            if number != self._round:
                return
            if why:
                self._lose(self.label + why)
                return
            self._is_up, self._pause_s = True, _FIRST_PAUSE_S
            self._came()

        self._judge(made, judged)

    def _widened(self, number: int, made: ProviderConnection | RtkitError) -> None:
        if self._is_old(number, made):
            return
        wanted, self._wanted = self._wanted, []
        if isinstance(made, RtkitError):
            for _, placed in wanted:
                placed(PropertyError("no-service", str(made)))
            return
        self._take(made)
        for name, placed in wanted:
            self.place(name, placed)

    def _is_old(self, number: int, made: ProviderConnection | RtkitError) -> bool:
        """Return whether a connection comes too late."""
        if number == self._round and not self._is_closed.is_set():
            return False
        if not isinstance(made, RtkitError):
            made.close()
        return True

    def _take(self, connection: ProviderConnection) -> None:
        number = self._round
        self._connections.append(connection)

        def gone(why: str) -> None:
            if number == self._round:
                self._lose(self.label + why)

        connection.start(gone)

    def _failed(self, why: str) -> None:
        self.why = why
        self._went(why)
        self._dial(self._connected, self._pause_s)
        self._pause_s = min(self._pause_s * 2, _LONGEST_PAUSE_S)

    def _lose(self, why: str, *, is_last: bool = False) -> None:
        """End all connections, report it, and begin to connect anew."""
        self._round += 1
        self._is_up, self.why = False, why
        contacts, self._connections = self._connections, []
        for connection in contacts:
            connection.close()
        wanted, self._wanted = self._wanted, []
        for _, placed in wanted:
            placed(PropertyError("no-service", why))
        if not is_last:
            self._failed(why)
