"""Notifies properties of other services: SETs them to what changes here.

Only those that the owner allows: else a client could have a service SET any property. They are
properties of services of the same user on this host, or stand behind an address of a wire.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from fnmatch import fnmatchcase
from functools import partial

from rtkit.link.places import service_socket, services_of
from rtkit.property.codes import PropertyError
from rtkit.property.messages import PropertyEvent
from rtkit.property.naming import parse_target
from rtkit.property.requests import Requester
from rtkit.property.service import Service
from rtkit.property.subscription import Listener
from rtkit.serving.event_loop import IOHandler, PropertyEventLoop
from rtkit.wires.line.client import connect_unix
from rtkit.wires.property_client import PropertyClient
from rtkit.wires.table import WIRES, wire_of

Deliver = Callable[[PropertyEvent], object]

DELIVERY_S = 5.0
"""How long one event may take [s]."""
MOST_FAILURES = 3
MOST_TARGETS = 64


class Notified(IOHandler, Requester):
    """Property of another service; each event is a SET of it.

    Args:
        gone: Called when it is not to be told any more.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        target: str,
        deliver: Callable[[PropertyEvent], object],
        gone: Callable[[Notified], object],
    ) -> None:
        super().__init__(f"notified:{target}")
        self._host = host
        self._deliver = deliver
        self._gone = gone
        self._listener: Listener | None = None
        self._is_busy = False
        self._failures = 0

    @property
    def is_used(self) -> bool:
        """Return whether it listens to something."""
        return self._listener is not None

    def listen(self, listener: Listener) -> None:
        """See `Requester.listen`."""
        self._listener = listener

    def unlisten(self, listener: Listener) -> None:
        """See `Requester.unlisten`."""
        if self._listener is listener:
            self._listener = None

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`: one event is on the way at a time, what comes meanwhile waits."""
        listener = self._listener
        if listener is None or self._is_busy:
            return None
        event = listener.take(now)
        if event is None:
            return listener.due() if listener.pending else None
        if event.code:
            self._listener = None  # the property is gone
            return None
        self._is_busy = True
        self._host.user_code.later(
            self.identity,
            lambda: self._set_event(event),
            lambda late: self._delivered(False),
            DELIVERY_S,
        )
        return None

    def _set_event(self, event: PropertyEvent) -> None:
        outcome = self._host.user_code.call(lambda: self._deliver(event))
        if self._is_busy:
            self._delivered(outcome.error is None)

    def _delivered(self, is_well: bool, /) -> None:
        self._is_busy = False
        self._failures = 0 if is_well else self._failures + 1
        if self._failures >= MOST_FAILURES:
            self._gone(self)
        elif self._listener is not None:
            self._host.mark(self)


class Notifying:
    """Notifies the listeners of one service that are properties elsewhere.

    Args:
        allowed: Patterns of ``SERVICE/NAME``, or of addresses (``tcp:HOST:PORT/SERVICE/NAME``):
            such a pattern begins with the scheme of its wire.
    """

    def __init__(self, host: PropertyEventLoop, service: Service, allowed: Sequence[str]) -> None:
        self._host = host
        self._service = service
        self._allowed = allowed
        self._known: dict[tuple[str, str], Notified] = {}

    def caller_for(self, reference: str, listened: str) -> Requester:
        """Return who listens to a property for a target.

        Raises:
            PropertyError: ``denied``: it is not allowed, or there are too many.
        """
        scheme, colon, _ = reference.partition(":")
        is_far = bool(colon) and scheme in WIRES
        full, deliver = self._far(scheme, reference) if is_far else self._near(reference)
        if not any(fnmatchcase(full, each) for each in self._allowed
                   if not is_far or each.startswith(f"{scheme}:")):  # fmt: skip
            raise PropertyError("denied", f"events do not go to {reference[:80]}: not allowed")
        key = (full, listened)
        self._known = {key: each for key, each in self._known.items() if each.is_used}
        if key not in self._known:
            if len(self._known) >= MOST_TARGETS:
                raise PropertyError("denied", f"{MOST_TARGETS} targets are told already")
            self._known[key] = Notified(self._host, full, deliver, self._service.forget)
        return self._known[key]

    def _near(self, reference: str) -> tuple[str, Deliver]:
        """Return the full name of a property on this host, and what sets it."""
        target = parse_target(_with_slash(reference))
        if not target.service or target.parameters or target.service == self._service.name:
            raise PropertyError("denied", f"events do not go to {reference[:80]}: not allowed")
        connect = partial(connect_unix, service_socket(target.service), DELIVERY_S)
        return f"{target.service}/{target.name}", partial(_set, connect, target.name)

    def _far(self, scheme: str, reference: str) -> tuple[str, Deliver]:
        """Return the address of a property, and what sets it."""
        side = wire_of(scheme).client
        place, path = side.split(reference) if side is not None else ("", "")
        if side is None or not path or "?" in path:
            raise PropertyError("denied", f"events do not go to {reference[:80]}: no target")
        return reference, partial(_set, partial(side.connect, place, DELIVERY_S), path)


def _set(connect: Callable[[], PropertyClient], name: str, event: PropertyEvent) -> None:
    with closing(connect()) as client:
        client.ask(name, event.payload).value()


def _with_slash(reference: str) -> str:
    """Return ``SERVICE.NAME``, as commands take it, as ``SERVICE/NAME``; that goes before."""
    there = services_of(reference)
    if reference.rpartition("/")[0] not in there:
        for service in there:
            if reference.startswith(f"{service}."):
                return f"{service}/{reference[len(service) + 1 :]}"
    return reference
