"""Streams of port data, and calls of services, between processes of different hosts.

They go through the routers that link the hosts: each process has one session to the router of a
manager of its own host, which takes data on and off. So they stand still while a manager or a link
on the way does, and go on by themselves when it is back.

See decision 74.
"""

from __future__ import annotations

import os

import zenoh

from rtkit.link import host_links, places
from rtkit.link import zenoh as control
from rtkit.link.streams import Streams

_OPEN_S = 2.0
"""How long a router may take to let a process of its own host in [s]."""


class RoutedStreams:
    """Opens streams to other hosts, by the router that leads to each.

    Args:
        manager: Manager of that router, where this host has no link there itself.
    """

    def __init__(self, manager: str) -> None:
        self._manager = manager
        self._by_router: dict[str, _Routed] = {}

    def to(self, host: str) -> Streams:
        """Return what opens streams to a host."""
        name = host_links.router(host, self._manager)
        if name not in self._by_router:
            self._by_router[name] = _Routed(name)
        return self._by_router[name]

    def close(self) -> None:
        """End every stream."""
        for streams in self._by_router.values():
            streams.close()


class _Routed(Streams):
    """All streams through one router."""

    def __init__(self, manager: str) -> None:
        super().__init__("")
        self._manager = manager
        self._session: zenoh.Session | None = None

    def close(self) -> None:
        with self._lock:
            if self._session is not None:
                self._session.close()  # type: ignore[no-untyped-call]
                self._session = None

    @property
    def _endpoint(self) -> str:
        return f"process {os.getpid()} on another host"

    def _listening(self) -> zenoh.Session:
        with self._lock:
            if self._session is None:
                endpoint = control.unix_endpoint(places.manager_socket(self._manager))
                self._session = control.open_client(endpoint, _OPEN_S)
            return self._session

    def _sender(self, endpoint: str, timeout_s: float) -> zenoh.Session:
        return self._listening()

    def _release(self, endpoint: str) -> None:
        """Keep the session: other streams use it."""
