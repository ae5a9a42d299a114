"""Interface of a transport, which `rtkit.link.zenoh` implements."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from rtkit.errors import Unreachable

if TYPE_CHECKING:
    from rtkit.property.exchange import Reply, Request


class Link(Protocol):
    """Transport that reaches services and offers services; by default to and for nobody."""

    def send(self, key: str, payload: str | None, timeout_s: float) -> Callable[[], Reply]:
        """Send a GET (payload None) or SET of the property at `key`; return what awaits the reply.

        What one thread sends arrives in that order. The reply is to be awaited once, by any
        thread, and comes within `timeout_s` [s].

        Raises:
            Unreachable: Nobody answered in time; when awaited.
        """
        raise Unreachable(f"nobody serves {key}")

    def call(self, key: str, payload: str | None, timeout_s: float) -> Reply:
        """Send, and wait for the reply.

        Raises:
            Unreachable: Nobody answered in time.
        """
        return self.send(key, payload, timeout_s)()

    def serve(self, service_key: str, enqueue: Callable[[Request], object]) -> None:
        """Offer a service; `enqueue` is called on the transport's threads and must only enqueue."""
        return

    def announce(self, key: str, listened: Callable[[bool], object]) -> Callable[[str], object]:
        """Open a topic of texts; return the function that sends one to all subscribers.

        It never waits: a slow subscriber misses texts. `listened` is called, on the transport's
        threads, when the first subscriber comes and when the last one has gone.
        """
        return lambda text: None

    def listen(self, key: str, on_text: Callable[[str], object]) -> Callable[[], object]:
        """Subscribe `on_text` to the texts of a topic; return the function that ends it.

        It is called on the transport's threads and must only enqueue.
        """
        return lambda: None

    def notice(self, key: str, found: Callable[[bool], object]) -> Callable[[], object]:
        """Tell whether somebody serves a key: now, and whenever that changes.

        It is told on any thread, until what is returned is called.
        """
        return lambda: None

    def close(self) -> None:
        """Leave; nothing is served or reachable afterwards."""
        return


class DeadLink(Link):
    """Link on which nobody answers: no manager runs yet."""
