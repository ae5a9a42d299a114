"""Clients of the endpoints of property services, and places for endpoints of every wire.

What tests open on a wire, and how they reach it, follows from its record in `rtkit.wires.table`.
"""

from __future__ import annotations

import itertools
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import icekit
import pytest
from mosquittokit import MOSQUITTO, Mosquitto
from oneline import OneLine
from serialkit import Cable
from zenoh_client import ZenohClient

from rtkit.keys.reach import BEHIND_TLS
from rtkit.link import zenoh_keys
from rtkit.link.zenoh import open_to_service
from rtkit.property.access import read_policy
from rtkit.property.messages import PropertyEvent
from rtkit.property.service import Service
from rtkit.proxy.addresses import open_endpoint
from rtkit.proxy.bridge import bridge
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.tree.property_connections import OfService
from rtkit.wires.property_client import PropertyClient
from rtkit.wires.serve import ServedObject
from rtkit.wires.table import PORT, PUBLIC, WIRES, wire_of
from rtkit.wires.wire import Wire, WireSettings

BOUND_S = 30.0
_IS_ABSENT = {} if icekit.IS_THERE else {"ice": icekit.MISSING}


def params(*schemes: str) -> list[object]:
    """Return parameters of a test: each scheme, skipped where the wire cannot be had here."""
    return [
        pytest.param(each, marks=pytest.mark.skip(_IS_ABSENT[each])) if each in _IS_ABSENT else each
        for each in schemes
    ]


SERVED = [
    each for each in WIRES if WIRES[each].option is not None and wire_of(each).client is not None
]
"""Schemes of the wires over which objects are served, and properties asked for."""
KNOWING = [each for each in SERVED if WIRES[each].option.knows_clients]  # type: ignore[union-attr]
"""Those of them that learn who asks, and serve many."""


def opening(place: str) -> dict[str, int | str]:
    """Return keywords of `rtkit.serve` that open an endpoint on each of the wires in `KNOWING`."""
    options = [WIRES[each].option for each in KNOWING if each not in _IS_ABSENT]
    return {
        each.name: 0 if each.metavar in (PORT, PUBLIC) else f"{place}/{each.name}.sock"
        for each in options
        if each is not None
    }


class Lines:
    """Clients of one endpoint; each listening has a client of its own."""

    def __init__(self, connect: Callable[[], PropertyClient]) -> None:
        self._connect = connect
        self._client = connect()
        self.ask = self._client.ask
        self.close = self._client.close

    @contextmanager
    def listen(self, target: str) -> Iterator[Iterator[PropertyEvent]]:
        with listening(self._connect(), target) as events:
            yield events


@contextmanager
def listening(client: PropertyClient, target: str) -> Iterator[Iterator[PropertyEvent]]:
    """Listen on a connection of its own, which is closed at the end."""
    try:
        client.listen(target)
        yield iter(client.event, None)
    finally:
        client.close()


class Zenoh:
    """Queries on a session of its own."""

    def __init__(self, service: str = "robot") -> None:
        self._session = open_to_service(service, BOUND_S)
        key = zenoh_keys.property_service(os.uname().nodename, service)
        self._client = ZenohClient(self._session, key, BOUND_S)
        self.ask = self._client.ask

    @contextmanager
    def listen(self, target: str) -> Iterator[Iterator[PropertyEvent]]:
        with self._client.listen(target) as subscription:
            yield iter(subscription)

    def close(self) -> None:
        self._session.close()  # type: ignore[no-untyped-call]


def client_at(scheme: str, address: str, service: str = "robot") -> Lines | OneLine:
    """Connect to an endpoint as commands do, by the record of its wire."""
    side = wire_of(scheme).client
    assert side is not None
    place, _ = side.split(f"{address}/")
    if side.has_services:
        return Lines(lambda: OfService(side.connect(place, BOUND_S), service))
    return OneLine(side.connect(place, BOUND_S))


def client_of(served: ServedObject, scheme: str) -> Lines | OneLine:
    """Connect to an endpoint of a served object."""
    return client_at(scheme, served.addresses[scheme], served.name)


def _found(wire: Wire, address: str, target: str) -> str:
    """Return where clients of a wire find what was opened; a name in the tree is not on a wire."""
    return address if address.startswith(f"{wire.scheme}:") else target


class WirePlaces:
    """Places for endpoints of any wire: fills in the form of its addresses."""

    _NUMBERS = itertools.count(1)

    def __init__(self, folder: str, ends: ExitStack) -> None:
        os.makedirs(folder, exist_ok=True)
        self._folder, self._ends = folder, ends

    def opened(self, wire: Wire, source: str) -> str:
        """Open an endpoint by a proxy; return the address at which clients find it."""
        target, found = self.address(wire)
        near = self._ends.enter_context(bridge(source, target, allow_set=["*"]))
        return found or _found(wire, near.address, target)

    def ruled(self, wire: Wire, service: Service, rules: str) -> str:
        """Open an endpoint where access rules hold; return the address that clients find it at."""
        target, found = self.address(wire)
        host = PropertyEventLoop(read_policy(rules, endpoints=WIRES))
        self._ends.callback(host.close)
        host.start()
        settings = WireSettings(host, BOUND_S, settable=("*",))
        address = host.call(lambda: open_endpoint(target, service, settings))
        return found or _found(wire, address, target)

    def address(self, wire: Wire) -> tuple[str, str]:
        """Return where to open an endpoint, and where that is found unless it says so itself."""
        number = next(self._NUMBERS)
        form = wire.target
        if "DEVICE" in form:
            cable = Cable(tempfile.mkdtemp(dir=self._folder))
            self._ends.callback(cable.close)
            return form.replace("DEVICE", cable.far), wire.source.replace("DEVICE", cable.near)
        if "USER@HOST" in form:
            if MOSQUITTO is None:
                pytest.skip("there is no mosquitto")
            keys = os.environ["RTKIT_KEYS"] if wire.scheme in BEHIND_TLS else ""
            broker = Mosquitto(Path(self._folder), keys)
            self._ends.callback(broker.stop)
            return broker.address("lab"), ""
        known = {"PORT": "0", "PATH": f"{self._folder}/{number}.sock", "SERVICE": f"p{number}"}
        for word, value in known.items():
            form = form.replace(word, value)
        return form, ""
