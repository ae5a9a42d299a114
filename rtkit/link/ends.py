"""Ends of connectors between two processes: value streams, pull streams and service calls."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Protocol

Octets = bytes | memoryview
Payload = Octets | list[Octets]
"""What is sent: octets, or the parts that make them up, which are not changed meanwhile."""
Deliver = Callable[[Octets], object]


def joined(value: Payload) -> bytes:
    """Return what is sent as one piece."""
    return b"".join(value) if isinstance(value, list) else bytes(value)


class Reader(Protocol):
    """Lets the thread that reads a port take values from their stream by itself."""

    def receive(self, timeout_s: float) -> bool:
        """Deliver the next value; False when none comes in time [s]."""

    def leave(self) -> None:
        """Have others take them again."""


class Outlet(ABC):
    """Sending end of one stream; `put` may be called from one thread at a time.

    Attributes:
        patience_s: How long `put` waits at most where it would lose a value; 0: never [s].
    """

    patience_s = 0.0

    @abstractmethod
    def put(self, value: Payload) -> bool:
        """Send one value; False when the stream is closed, or nobody took it in time."""

    def offer(self, value: Payload) -> bool:
        """Send one value if that needs no waiting; False when it was not sent."""
        return self.put(value)

    @abstractmethod
    def flush(self, timeout_s: float) -> bool:
        """Wait until the receiver has all that was put before; False when it did not confirm."""

    @abstractmethod
    def close(self) -> None:
        """Close this end; the other one receives nothing more."""


class Inlet(ABC):
    """Receiving end of one stream: values are pushed to it, or asked of it.

    Attributes:
        lost: Values that were sent and did not arrive, where the sender numbers them.
    """

    lost = 0

    def borrow(self) -> Reader | None:
        """Have this thread receive; None when that is not possible now."""
        return None

    def sip(self) -> None:  # noqa: B027 - most need not
        """Deliver what has come, if a reader has borrowed this and is not there."""

    @abstractmethod
    def settle(self, timeout_s: float) -> bool:
        """Count losses behind the last value too; False when the sender does not report them.

        It is for streams whose values are numbered.
        """

    @abstractmethod
    def close(self) -> None:
        """Take no part in the stream any more."""


class Fetcher(ABC):
    """Asking end of one pull stream."""

    @abstractmethod
    def fetch(self, timeout_s: float) -> Octets | None:
        """Return the next value, None when the other end has none or is gone."""

    @abstractmethod
    def close(self) -> None:
        """Ask no more."""


class CallerEnd(ABC):
    """Caller's end of a service connector."""

    @abstractmethod
    def call(self, request: bytes, timeout_s: float) -> bytes:
        """Return the reply to a request.

        Raises:
            Unreachable: There was none in time, or nobody is there any more.
        """

    @abstractmethod
    def close(self) -> None:
        """Call no more."""


class ConnectorEnd(Protocol):
    """Any end of a connector."""

    def close(self) -> None:
        """Take no part in it any more."""


class Streams(ABC):
    """Opens all streams of one process, by one way.

    Attributes:
        report: Is told, in a line, what keeps values from being sent.
    """

    def __init__(self) -> None:
        self.report: Callable[[str], object] = lambda _text: None

    @abstractmethod
    def receive(self, key: str, deliver: Deliver, *, is_patient: bool = False) -> tuple[str, Inlet]:
        """Listen on `key`; return the endpoint for the sender and the stream's end.

        `deliver` is called with one value after the other. One that is patient may take its time:
        other streams do not wait for it.

        Raises:
            Unreachable: The socket cannot be made.
        """

    @abstractmethod
    def send(
        self,
        endpoint: str,
        key: str,
        timeout_s: float,
        *,
        is_blocking: bool = False,
        is_numbered: bool = False,
    ) -> Outlet:
        """Open the sending end of a stream; returns when the receiver was found.

        A blocking one waits where another would lose values. One that numbers its values lets the
        receiver count what is lost.

        Raises:
            Unreachable: It was not, within `timeout_s` [s].
        """

    @abstractmethod
    def answer(self, key: str, next_value: Callable[[], Octets | None]) -> tuple[str, ConnectorEnd]:
        """Be asked for values on `key`; return the endpoint for who asks and the stream's end.

        Raises:
            Unreachable: The socket cannot be made.
        """

    @abstractmethod
    def ask(self, endpoint: str, key: str, timeout_s: float) -> Fetcher:
        """Open the end of a pull stream that asks.

        Raises:
            Unreachable: Nobody listens at `endpoint`.
        """

    @abstractmethod
    def serve(self, key: str, reply_to: Callable[[bytes], bytes]) -> tuple[str, ConnectorEnd]:
        """Answer calls on `key`; return the endpoint for who calls and the connector's end.

        Raises:
            Unreachable: The socket cannot be made.
        """

    @abstractmethod
    def caller(self, endpoint: str, key: str, timeout_s: float) -> CallerEnd:
        """Open the end of a service connector that calls.

        Raises:
            Unreachable: Nobody listens at `endpoint`.
        """

    @abstractmethod
    def close(self) -> None:
        """End every stream."""
