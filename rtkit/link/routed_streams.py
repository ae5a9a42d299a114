"""Streams of port data, and calls of services, between processes of different hosts.

They go through the routers that link the hosts: each process has one session to the router of a
manager of its own host, which takes data on and off. So they stand still while a manager or a link
on the way does, and go on by themselves when it is back.

See decision 74.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from typing import Any

import zenoh

from rtkit.errors import Unreachable
from rtkit.link import host_links, places
from rtkit.link import zenoh as control
from rtkit.link.ends import (
    CallerEnd,
    ConnectorEnd,
    Deliver,
    Fetcher,
    Inlet,
    Octets,
    Outlet,
    Streams,
)
from rtkit.link.routed_ends import (
    ProviderEnd,
    RoutedCaller,
    RoutedFetcher,
    RoutedInlet,
    RoutedOutlet,
)

_OPEN_S = 2.0
"""How long a router may take to let a process of its own host in [s]."""


class StreamsByRouter:
    """Opens streams to other hosts, by the router that leads to each.

    Args:
        manager: Manager of that router, where this host has no link there itself.
    """

    def __init__(self, manager: str) -> None:
        self._manager = manager
        self._by_router: dict[str, RoutedStreams] = {}

    def to(self, host: str) -> Streams:
        """Return what opens streams to a host."""
        name = host_links.router(host, self._manager)
        if name not in self._by_router:
            self._by_router[name] = RoutedStreams(name)
        return self._by_router[name]

    def close(self) -> None:
        """End every stream."""
        for streams in self._by_router.values():
            streams.close()


class RoutedStreams(Streams):
    """All streams of one process through the router of one manager."""

    def __init__(self, manager: str) -> None:
        super().__init__()
        self._manager = manager
        self._opened: zenoh.Session | None = None
        self._lock = threading.Lock()

    def receive(self, key: str, deliver: Deliver, *, is_patient: bool = False) -> tuple[str, Inlet]:
        """See `Streams.receive`."""
        inlet = RoutedInlet()
        inlet.receive(self._session(), key, deliver)
        return _here(), inlet

    def send(
        self,
        endpoint: str,
        key: str,
        timeout_s: float,
        *,
        is_blocking: bool = False,
        is_numbered: bool = False,
    ) -> Outlet:
        """See `Streams.send`."""
        session = self._session()
        congestion = zenoh.CongestionControl.BLOCK if is_blocking else zenoh.CongestionControl.DROP
        publisher = session.declare_publisher(key, congestion_control=congestion)
        outlet = RoutedOutlet(session, publisher, is_numbered=is_numbered)
        matched = threading.Event()

        def changed(status: zenoh.MatchingStatus) -> None:
            if status.matching:
                matched.set()

        listener = publisher.declare_matching_listener(changed)
        status: Any = publisher.matching_status  # the stubs of zenoh 1.10 say bool, wrongly
        is_matched = status.matching or matched.wait(timeout_s)
        listener.undeclare()  # type: ignore[no-untyped-call]
        if not is_matched:
            outlet.close()
            raise Unreachable(f"nobody takes data at {endpoint}")
        return outlet

    def answer(self, key: str, next_value: Callable[[], Octets | None]) -> tuple[str, ConnectorEnd]:
        """See `Streams.answer`."""
        inlet = RoutedInlet()
        inlet.answer(self._session(), key, next_value)
        return _here(), inlet

    def ask(self, endpoint: str, key: str, timeout_s: float) -> Fetcher:
        """See `Streams.ask`."""
        return RoutedFetcher(self._session(), key)

    def serve(self, key: str, reply_to: Callable[[bytes], bytes]) -> tuple[str, ConnectorEnd]:
        """See `Streams.serve`."""
        end = ProviderEnd(key, reply_to)
        end.declare(self._session())
        return _here(), end

    def caller(self, endpoint: str, key: str, timeout_s: float) -> CallerEnd:
        """See `Streams.caller`."""
        return RoutedCaller(self._session(), key)

    def close(self) -> None:
        """See `Streams.close`."""
        with self._lock:
            if self._opened is not None:
                self._opened.close()  # type: ignore[no-untyped-call]
                self._opened = None

    def _session(self) -> zenoh.Session:
        with self._lock:
            if self._opened is None:
                endpoint = control.unix_endpoint(places.manager_socket(self._manager))
                self._opened = control.open_client(endpoint, _OPEN_S)
            return self._opened


def _here() -> str:
    """Return the endpoint of this process for those of another host, which is for messages only."""
    return f"process {os.getpid()} on another host"
