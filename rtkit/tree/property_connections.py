"""Finds the owner of a property as it was typed, and connects to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from time import monotonic
from typing import TYPE_CHECKING

from rtkit.errors import RtkitError
from rtkit.link.places import host_name
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, Payload
from rtkit.property.naming import EXTENSIONS
from rtkit.rtc.names import LOCAL
from rtkit.tree.property_targets import (
    OwnerKind,
    PropertyTarget,
    no_service,
    no_service_here,
    parse,
)

if TYPE_CHECKING:
    from rtkit.tree.live_properties import ThisHost
    from rtkit.wires.property_client import PropertyClient
    from rtkit.wires.wire import ClientSide

_NAMES_S = 1.0
"""How long a service may take to list the names that one was perhaps to be [s]."""


def bound_of(
    end: PropertyClient, typed: str | None, parameters: Sequence[str], timeout_s: float
) -> list[str]:
    """Return the parameter by which a request to set states how long its client waits.

    For services behind a socket, which do not begin what was given up; devices do not know it.
    """
    from rtkit.wires.line.client import LineClient

    is_given = any(each.startswith("timeout=") for each in (*parameters, *(typed or "").split("&")))
    client = end.endpoint if isinstance(end, OfService) else end
    is_known = isinstance(client, LineClient) and not is_given
    return [f"timeout={timeout_s:g}"] if is_known else []


class _Endpoint:
    """Endpoint on any wire, with a connection for each of its services.

    Args:
        timeout_s: Bound on connecting, and on each request [s].
    """

    def __init__(self, side: ClientSide, address: str, timeout_s: float) -> None:
        self._connect = partial(side.connect, address, timeout_s)
        self._ends: dict[str, PropertyClient] = {}

    @cached_property
    def first(self) -> PropertyClient:
        """The connection that lists the services, and serves the first of them."""
        return self._connect()

    @cached_property
    def services(self) -> list[str]:
        """The services behind it."""
        return str(self.first.ask("door/services").value()).strip("()").split()

    def of_service(self, service: str) -> PropertyClient:
        """Return a connection for one service alone: names of events do not tell their service."""
        if service not in self._ends:
            client = self._connect() if self._ends else self.first
            self._ends[service] = OfService(client, service)
        return self._ends[service]

    def close(self) -> None:
        """End all connections."""
        if "first" in vars(self):
            self.first.close()
        for end in self._ends.values():
            end.close()


class PropertyConnections:
    """Finds properties and keeps one connection for each owner.

    Args:
        at: ``HOST:PORT`` of a TCP endpoint, or the address of an endpoint on another wire;
            empty for the services of this user on this host. A service behind it is where names
            begin; behind a serial line there is one, which needs no name.
        timeout_s: Bound on each request [s]; a target may state a shorter one.
    """

    def __init__(self, cwd: str, at: str, timeout_s: float) -> None:
        self._cwd = cwd
        self._at = at
        self._timeout_s = timeout_s
        self._ends: dict[str, PropertyClient] = {}
        self._endpoints: dict[tuple[str, float], _Endpoint] = {}

    def find(self, typed: str) -> tuple[PropertyTarget, PropertyClient]:
        """Return where a property is and the connection to its owner.

        Raises:
            RtkitError: ``no-service``, with what was typed in front.
        """
        try:
            return self._behind(typed) or self._here(typed)
        except Exception as error:
            raise printed_error(typed, error) from error

    def _behind(self, typed: str) -> tuple[PropertyTarget, PropertyClient] | None:
        """Return a property behind an endpoint, None if it is one of this host."""
        if not (self._at or ":" in typed):
            return None
        from rtkit.wires.property_client import bound_in
        from rtkit.wires.table import client_side_of, endpoint_of

        side, service = client_side_of(typed), ""
        if side is not None:
            cwd, (address, path) = "/", side.split(typed)
        elif self._at:
            side, address, service = endpoint_of(self._at)
            cwd, path = f"/{service}" if service else self._cwd, typed
        else:
            return None
        key = (address, bound_in(typed, self._timeout_s))
        endpoint = self._endpoints.setdefault(key, _Endpoint(side, *key))
        if not side.has_services:
            return PropertyTarget.of_path(typed, path), endpoint.first
        place = parse(path, cwd, endpoint.services, _hostname())
        if not place.service:
            name = place.name if path == typed else ""
            raise no_service(service or name, endpoint.services)
        return place._replace(typed=typed), endpoint.of_service(place.service)

    def _here(self, typed: str) -> tuple[PropertyTarget, PropertyClient]:
        """Return a property of a service, component or manager of this host, or of the host."""
        place, kind = place_here(typed, self._cwd, self._services, self._timeout_s)
        if kind == "host":
            return place, self._host
        if place.service not in self._ends:
            self._ends[place.service] = self._opened(place.service, kind)
        return place, self._ends[place.service]

    def _opened(self, owner: str, kind: str) -> PropertyClient:
        if kind == "service":
            from rtkit.link.places import service_socket
            from rtkit.wires.line.client import connect_unix

            return connect_unix(service_socket(owner), self._timeout_s)
        if kind in ("far", "far host"):
            from rtkit.tree.far_places import open_far

            return open_far(owner, self._timeout_s)
        from rtkit.tree.live_place import open_live

        return open_live(owner, self._timeout_s)

    @cached_property
    def _host(self) -> ThisHost:
        return this_host()

    @cached_property
    def _services(self) -> list[str]:
        from rtkit.link.places import services

        return services()

    def close(self) -> None:
        """End all connections."""
        for endpoint in self._endpoints.values():
            endpoint.close()
        for end in self._ends.values():
            end.close()
        self._ends.clear()
        self._endpoints.clear()


def place_here(
    typed: str, cwd: str, services: Sequence[str], timeout_s: float = _NAMES_S
) -> tuple[PropertyTarget, OwnerKind]:
    """Return where a property is that was typed without an address, and what owns it.

    A node is named by its path, a service of another host by ``/HOST/SERVICE``.

    Raises:
        PropertyError: ``no-service``; ``unknown``: the host has no such property.
        Unreachable: The host that is named cannot be reached.
    """
    place = parse(typed, cwd, services, _hostname())
    if place.service:
        return place, "service"
    from rtkit.tree.live_place import name_of_host, split, steps_of

    path = place.typed.partition("?")[0]
    node, name = split(path, cwd)
    if node:
        return place._replace(service=node, name=name), "node"
    of_host = name_of_host(path, cwd, _hostname())
    if of_host is None:
        if not (path.startswith("/") or cwd.strip("/")):
            raise no_service_here(place.name, services)
        from rtkit.tree.far_places import far_place

        return far_place(place, steps_of(path, cwd), services, timeout_s)
    first = of_host.partition(".")[0]
    if of_host and first not in EXTENSIONS and first not in (names := this_host().names):
        known = f"this host has {' '.join(names)}"
        if path.endswith(f".{of_host}"):
            raise PropertyError("unknown", f"no such property: {of_host} ({known})")
        raise no_service_here(place.name, services, f"; {known}")
    return place._replace(service=LOCAL, name=of_host), "host"


def this_host() -> ThisHost:
    """Return this host, as a client."""
    from rtkit.link.host_links import hosts
    from rtkit.link.places import services
    from rtkit.link.running import managers
    from rtkit.tree.live_properties import ThisHost

    return ThisHost(services, managers, hosts)


def _hostname() -> str:
    return host_name()


class OfService:
    """Connection to one of several services behind an endpoint."""

    def __init__(self, endpoint: PropertyClient, service: str) -> None:
        self.endpoint = endpoint
        self._service = service
        self.event = endpoint.event
        self.close = endpoint.close

    def ask(self, target: str, payload: Payload | None = None) -> Answer:
        """See `PropertyClient.ask`."""
        return self.endpoint.ask(f"{self._service}/{target}", payload)

    def listen(self, target: str) -> None:
        """See `PropertyClient.listen`."""
        self.endpoint.listen(f"{self._service}/{target}")


def printed_error(typed: str, error: Exception) -> PropertyError:
    """Return an error as commands show it: ``TARGET: code: text``."""
    from rtkit.wires.property_client import failure

    answer = failure(error)
    return PropertyError(answer.error, f"{typed}: {answer.error}: {answer.payload!s}")


def asked(ask: Callable[[], Answer], place: PropertyTarget, end: PropertyClient) -> Payload:
    """Return the value of an answer.

    Raises:
        PropertyError: As commands show it.
    """
    try:
        return ask().value()
    except Exception as error:
        raise with_near_names(error, place, end) from error


def with_near_names(error: Exception, place: PropertyTarget, end: PropertyClient) -> PropertyError:
    """Return an error as commands show it; of an unknown property, with names like it."""
    shown = printed_error(place.typed, error)
    if shown.code != "unknown" or not place.name:
        return shown
    from rtkit.rtc.nearest import did_you_mean

    path = place.typed.partition("?")[0]
    begin = path.removesuffix(place.name) if path.endswith(place.name) else ""
    try:
        names = str(end.ask(f"properties?all=1&timeout={_NAMES_S}").value()).strip("()").split()
    except RtkitError:
        return shown  # the error itself is what counts
    if place.name in names or "(did you mean " in str(shown):
        return shown  # it is something else that is unknown
    meant = did_you_mean(place.name, names, shown=lambda name: f"{begin}{name}")
    return PropertyError("unknown", f"{shown}{meant}")


def ended(payload: Payload, place: PropertyTarget, end: PropertyClient, until: float) -> Payload:
    """Return what a property tells; of a behaviour that runs, once it runs no longer.

    Raises:
        PropertyError: As commands show it; ``timeout``: it runs still.
    """
    if not str(payload).startswith('<behavior state="running"'):
        return payload
    try:
        end.listen(f"{place.name}.state")
        while (event := end.event(max(0.0, until - monotonic()))) and event.payload == "running":
            pass
    except (PropertyError, RtkitError) as error:
        raise printed_error(place.typed, error) from error
    if event is None:
        raise printed_error(place.typed, PropertyError("timeout", "it runs still"))
    if event.code:
        raise printed_error(place.typed, PropertyError(event.code, "its owner has gone"))
    return asked(lambda: end.ask(place.name), place, end)


def check_outcome(payload: Payload, typed: str) -> None:
    """Check that an action that has ended did what it was to do.

    Raises:
        PropertyError: It failed; as commands show it.
    """
    if not (isinstance(payload, str) and payload.startswith(("<call ", "<behavior "))):
        return
    from rtkit.property.reading import read
    from rtkit.property.values import Element

    outcome = read(payload)
    error = outcome.find("error") if isinstance(outcome, Element) else None
    if error is not None:
        failure = PropertyError(error.attributes.get("code", "internal"), str(error.leaf or ""))
        raise printed_error(typed, failure)
