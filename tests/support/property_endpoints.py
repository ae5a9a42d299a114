"""Clients of the endpoints of property services, as the conformance table needs them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

from rtkit.link import keys, places
from rtkit.link.zenoh import open_client, unix_endpoint
from rtkit.property.messages import PropertyEvent
from rtkit.wires.http.client import HttpClient
from rtkit.wires.ice.client import IceClient
from rtkit.wires.line.client import LineClient, listening
from rtkit.wires.zenoh.client import ZenohClient

BOUND_S = 30.0


class Lines:
    """Lines, HTTP or Ice; each who listens has a client of its own."""

    def __init__(self, connect: Callable[[], LineClient | HttpClient | IceClient]) -> None:
        self._connect = connect
        self._client = connect()
        self.ask = self._client.ask
        self.close = self._client.close

    def listen(self, target: str) -> AbstractContextManager[Iterator[PropertyEvent]]:
        return listening(self._connect(), target)


class Zenoh:
    """Queries on a session of its own."""

    def __init__(self, service: str = "robot") -> None:
        path = places.service_key_socket(service)
        self._session = open_client(unix_endpoint(path), BOUND_S)
        key = keys.property_service(os.uname().nodename, service)
        self._client = ZenohClient(self._session, key, BOUND_S)
        self.ask = self._client.ask

    @contextmanager
    def listen(self, target: str) -> Iterator[Iterator[PropertyEvent]]:
        with self._client.listen(target) as subscription:
            yield iter(subscription)

    def close(self) -> None:
        self._session.close()  # type: ignore[no-untyped-call]
