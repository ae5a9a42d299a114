"""Owners of properties, as a client asks them: where each is, and one lasting connection to it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from time import monotonic
from typing import NamedTuple

from rtkit.errors import RtkitError
from rtkit.link import places
from rtkit.link.places import host_name
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, Payload
from rtkit.rtc.names import is_local_host
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.tree.property_connections import place_here, this_host
from rtkit.tree.property_targets import PropertyTarget, no_service, parse
from rtkit.wires.line.provider_connection import LineConnection
from rtkit.wires.property_client import BoundedClient, failure
from rtkit.wires.provider_connection import Answering, ConnectionMaker, ProviderConnection
from rtkit.wires.table import client_side_of, scheme_of, wire_of
from rtkit.wires.wire import SERVICES, WireSettings

_ZENOH = "zenoh:"
_MOST_KNOWN = 4096
"""Properties of which the owner is remembered."""


class _Waiting(NamedTuple):
    target: str
    payload: Payload | None
    answer: Answering
    until: float
    is_again: bool = False


class Owner:
    """Owner of properties, with the connection through which it is asked; made anew when it broke.

    Args:
        connect: Makes the connection.
        is_near: That takes no time worth a thread.
    """

    def __init__(self, host: PropertyEventLoop, connect: ConnectionMaker, *, is_near: bool) -> None:
        self.connect = connect
        self._host = host
        self._is_near = is_near
        self._connection: ProviderConnection | None = None
        self._waiting: list[_Waiting] = []
        self._is_connecting = self._is_closed = False
        self._ended: ProviderConnection | None = None
        self._dialling: threading.Thread | None = None

    def begin(self) -> None:
        """Connect, where that takes no time; not under the lock of the host.

        Raises:
            RtkitError: It cannot be reached.
        """
        if self._is_near and self._connection is None:
            made = self.connect()
            with self._host.lock:
                self._take(made)

    def ask(
        self,
        target: str,
        payload: Payload | None,
        answer: Answering,
        until: float,
        is_again: bool = False,
    ) -> None:
        """GET, or SET unless it is too late; under the lock of the host."""
        connection = self._connection
        if connection is not None:
            if not isinstance(connection, LineConnection):
                waiting = _Waiting(target, payload, answer, until, is_again)
                answer = partial(self._answered, connection, waiting)
            connection.ask(target, payload, "", answer, until)
            return
        if self._is_closed:
            answer(failure(_closed()))  # nobody would wait for a thread that is begun now
            return
        self._waiting.append(_Waiting(target, payload, answer, until, is_again))
        if not self._is_connecting:
            self._is_connecting = True
            dialling = threading.Thread(target=self._dial, name="connecting", daemon=True)
            dialling.start()
            self._dialling = dialling  # not before: who closes waits for it without the lock

    def receive_here(self, is_answered: Callable[[], bool], until: float) -> None:
        """Receive on this thread until its answer is here, where the wire lets it."""
        if isinstance(self._connection, LineConnection):
            self._connection.receive_here(is_answered, until)

    def _answered(self, connection: ProviderConnection, asked: _Waiting, reply: Answer) -> None:
        """Answer who asked over a wire that does not tell when the far side is gone."""
        if reply.error == "no-service" and self._connection is connection:
            self._connection = None
            connection.close()
            if asked.payload is None and not asked.is_again:
                self.ask(*asked._replace(is_again=True))
                return
        asked.answer(reply)

    def close(self) -> None:
        """End the connection; under the lock of the host."""
        self._is_closed = True
        self._connected(_closed())
        self._ended = self._connection
        if self._connection is not None:
            self._connection.close()

    def join(self, until: float) -> None:
        """Wait until all that it began has ended, by the monotonic clock [s]; once it is closed."""
        if self._dialling is not None:
            self._dialling.join(max(0.0, until - monotonic()))
        if self._ended is not None:
            self._ended.join(until)

    def _dial(self) -> None:
        made: ProviderConnection | RtkitError
        try:
            made = self.connect()
        except RtkitError as error:
            made = error
        with self._host.lock:
            self._connected(made)

    def _connected(self, made: ProviderConnection | RtkitError) -> None:
        self._is_connecting = False
        if not isinstance(made, RtkitError):
            self._take(made)
        waiting, self._waiting = self._waiting, []
        for each in waiting:
            if isinstance(made, RtkitError):
                each.answer(failure(made))
            else:
                self.ask(*each)

    def _take(self, made: ProviderConnection) -> None:
        if self._connection is not None or self._is_closed:
            made.close()  # somebody else was quicker
            self._ended = made
            return
        if isinstance(made, LineConnection):
            made.is_overtaking = True
        self._connection = made
        made.start(lambda why: self._lose(made))

    def _lose(self, made: ProviderConnection) -> None:
        if self._connection is made:
            self._connection = None


class Owners:
    """Finds the owners of properties, and keeps them.

    Args:
        timeout_s: Bound on each attempt to connect [s].
    """

    def __init__(self, host: PropertyEventLoop, timeout_s: float) -> None:
        self._host = host
        self._settings = WireSettings(host, timeout_s)
        self._known: dict[str, tuple[PropertyTarget, Owner]] = {}
        self._owners: dict[str, Owner] = {}
        self._is_closed = False

    def is_far(self, typed: str) -> bool:
        """Return whether it takes time to find a property: an address, or a manager, is asked."""
        if typed in self._known:
            return False
        is_path = typed.startswith("/") and not is_local_host(typed.split("/")[1], host_name())
        return is_path or ":" in typed

    def find(self, typed: str) -> tuple[PropertyTarget, Owner]:
        """Return what a property is called there, and its owner.

        Raises:
            RtkitError: There is no such owner, or the client has been closed.
        """
        known = self._known.get(typed)
        if known is None:
            known = self._found(typed)
            if len(self._known) > _MOST_KNOWN:
                self._known.clear()
            self._known[typed] = known
        if self._is_closed:  # meanwhile: an owner that was found since then is nobody's to end
            raise _closed()
        return known

    def forget(self, typed: str) -> None:
        """Find a property anew the next time: it may be that of another owner by then."""
        self._known.pop(typed, None)

    def close(self) -> None:
        """End all connections; under the lock of the host."""
        self._is_closed = True
        for owner in list(self._owners.values()):
            owner.close()

    def join(self, until: float) -> None:
        """Wait until all owners have ended what they began; see `Owner.join`."""
        for owner in list(self._owners.values()):
            owner.join(until)

    def _found(self, typed: str) -> tuple[PropertyTarget, Owner]:
        if typed.startswith(f"{_ZENOH}/"):
            return self._here(typed.removeprefix(_ZENOH))
        if typed.startswith(_ZENOH):
            place = self._among(places.services(), typed.removeprefix(_ZENOH))
            return place, self._behind(_ZENOH + place.service)
        if ":" in typed and (side := client_side_of(typed)) is not None:
            address, path = side.split(typed)
            if not side.has_services:
                return PropertyTarget.of_path(typed, path), self._behind(address)
            client = side.connect(address, self._settings.timeout_s)
            try:
                services = str(client.ask(SERVICES).value()).strip("()").split()
            finally:
                client.close()
            place = self._among(services, path)
            return place, self._behind(typed.removesuffix(path) + place.service)
        return self._here(typed)

    @staticmethod
    def _among(services: list[str], path: str) -> PropertyTarget:
        place = parse(path, "/", services, host_name())
        if not place.service:
            raise no_service(place.name, services)
        return place

    def _behind(self, address: str) -> Owner:
        scheme = scheme_of(address)
        if address not in self._owners:
            rest = address.removeprefix(f"{scheme}:")
            connect = wire_of(scheme).provider(rest, self._settings).connect
            self._owners.setdefault(address, Owner(self._host, connect, is_near=False))
        return self._owners[address]

    def _here(self, typed: str) -> tuple[PropertyTarget, Owner]:
        from rtkit.tree.live_place import open_live

        known = places.services_of(typed) or places.services()
        place, kind = place_here(typed, "/", known, self._settings.timeout_s)
        if kind == "service":
            path = places.service_socket(place.service)
            connect = wire_of("unix").provider(path, self._settings).connect
        elif kind == "far":
            from rtkit.wires.zenoh.far_services import FarService

            connect = FarService.parse(place.service).provider(self._settings).connect
        elif kind == "far host":
            from rtkit.tree.far_places import far_host

            connect = self._blocking(lambda: far_host(place.service, self._settings.timeout_s))
        elif kind == "node":
            connect = self._blocking(lambda: open_live(place.service, self._settings.timeout_s))
        else:
            connect = self._blocking(this_host)
        key = f"{kind}:{place.service}"
        owner = Owner(self._host, connect, is_near=kind == "service")
        return place, self._owners.setdefault(key, owner)

    def _blocking(self, another: Callable[[], BoundedClient]) -> ConnectionMaker:
        from rtkit.wires.blocking_connection import blocking_calls

        return blocking_calls(self._host, another)


def _closed() -> PropertyError:
    return PropertyError("no-service", "the client has been closed")
