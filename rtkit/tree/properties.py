"""Resolves a property as it was typed, and connects to its owner.

``SERVICE.NAME``, ``/localhost/SERVICE.NAME``, ``/localhost/SERVICE/NAME`` are the same. The longest
name of a present service that fits is the service.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, Payload
from rtkit.property.naming import EXTENSIONS
from rtkit.rtc.names import LOCAL, is_local_host

if TYPE_CHECKING:
    from rtkit.tree.live import ThisHost
    from rtkit.wires.property_client import PropertyClient
    from rtkit.wires.wire import ClientSide


class PropertyTarget(NamedTuple):
    """A property as it was typed.

    Attributes:
        service: Where it is, empty if no service fits.
        name: Of the property, as a target without parameters; empty for the service itself.
        parameters: What was typed behind the question mark, None for nothing.
    """

    typed: str
    service: str
    name: str
    parameters: str | None = None

    def target(self, more: str = "", extension: str = "") -> str:
        """Return what to ask for; the service itself stands for the names it has."""
        name = self.name or ("" if extension == "listen" else "properties")
        if extension:
            name = f"{name}.{extension}" if name else f"properties.{extension}"
        given = [each for each in (self.parameters, more) if each]
        is_marked = self.parameters is not None or more
        return f"{name}?{'&'.join(given)}" if is_marked else name


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


def parse(typed: str, cwd: str, services: Iterable[str], hostname: str) -> PropertyTarget:
    """Read what was typed, relative to the working directory `cwd` in the tree."""
    path, mark, parameters = typed.partition("?")
    whole = path if path.startswith("/") else f"{cwd.rstrip('/')}/{path}"
    steps = [step for step in whole.split("/") if step not in ("", ".")]
    if steps and is_local_host(steps[0], hostname):
        steps.pop(0)
    elif steps and path.startswith("/"):
        return PropertyTarget(typed, "", whole, parameters if mark else None)
    rest = "/".join(steps)
    given = parameters if mark else None
    for service in sorted(services, key=len, reverse=True):
        if rest == service:
            return PropertyTarget(typed, service, "", given)
        if rest.startswith((f"{service}.", f"{service}/")):
            name = rest[len(service) + 1 :].strip("/")
            return PropertyTarget(typed, service, name.replace("/", "."), given)
    return PropertyTarget(typed, "", rest, given)


class PropertyConnections:
    """Finds properties and keeps one connection for each owner.

    Args:
        at: ``HOST:PORT`` of a TCP endpoint, or the address of an endpoint on another wire;
            empty for the services of this user on this host. Behind a serial
            line there is one service, which needs no name.
        timeout_s: Bound on each request [s].
    """

    def __init__(self, cwd: str, at: str, timeout_s: float) -> None:
        self._cwd = cwd
        self._at = at
        self._timeout_s = timeout_s
        self._ends: dict[str, PropertyClient] = {}
        self._services: list[str] | None = None
        self._this_host: ThisHost | None = None

    def find(self, typed: str) -> tuple[PropertyTarget, PropertyClient]:
        """Return where a property is and the connection to its owner.

        Raises:
            RtkitError: ``no-service``, with what was typed in front.
        """
        try:
            if self._at or ":" in typed:
                from rtkit.wires.table import client_side_of, endpoint_side_of

                if (side := client_side_of(typed)) is not None:
                    return self._behind(side, *side.split(typed), typed)
                if self._at and not (side := endpoint_side_of(self._at)).has_services:
                    return self._behind(side, self._at, typed, typed)
        except Exception as error:
            raise printed_error(typed, error) from error
        place = parse(typed, self._cwd, self._known(), os.uname().nodename)
        try:
            if not place.service and not self._at:
                return self._in_tree(place)
            return place, self._end(place)
        except Exception as error:
            raise printed_error(typed, error) from error

    def _in_tree(self, place: PropertyTarget) -> tuple[PropertyTarget, PropertyClient]:
        """Return where a property of a component, of a manager or of this host is."""
        from rtkit.tree.live_place import name_of_host, open_live, split

        path = place.typed.partition("?")[0]
        node, name = split(path, self._cwd)
        if node:
            if node not in self._ends:
                self._ends[node] = open_live(node, self._timeout_s)
            return place._replace(service=node, name=name), self._ends[node]
        of_host = name_of_host(path, self._cwd, os.uname().nodename)
        if of_host is None:
            return place, self._end(place)
        host = self._host()
        first = of_host.partition(".")[0]
        if of_host and first not in host.names and first not in EXTENSIONS:
            known = f"this host has {' '.join(host.names)}"
            if path.endswith(f".{of_host}"):
                raise PropertyError("unknown", f"no such property: {of_host} ({known})")
            services = " ".join(self._known()) or "none"
            text = f"no service named {first} (there is {services}; {known})"
            raise PropertyError("no-service", text)
        return place._replace(service=LOCAL, name=of_host), host

    def _host(self) -> ThisHost:
        if self._this_host is None:
            from rtkit.link.running import managers
            from rtkit.tree.live import ThisHost

            self._this_host = ThisHost(self._known(), managers())
        return self._this_host

    def _known(self) -> list[str]:
        if self._services is None:
            from rtkit.link.places import services

            self._services = _listed(self._endpoint()) if self._at else services()
        return self._services

    def _endpoint(self) -> PropertyClient:
        return self._connected_to(self._side(), self._at)

    def _side(self) -> ClientSide:
        from rtkit.wires.table import endpoint_side_of

        return endpoint_side_of(self._at)

    def _connected_to(self, side: ClientSide, address: str) -> PropertyClient:
        if address not in self._ends:
            self._ends[address] = self._connect(side, address)
        return self._ends[address]

    def _connect(self, side: ClientSide, address: str) -> PropertyClient:
        return side.connect(address, self._timeout_s)

    def _behind(
        self, side: ClientSide, address: str, path: str, typed: str
    ) -> tuple[PropertyTarget, PropertyClient]:
        """Return what a path behind an endpoint is; a request shows whether it is a service."""
        end = self._connected_to(side, address)
        if not side.has_services:
            name, mark, parameters = path.partition("?")
            return PropertyTarget(typed, "", name, parameters if mark else None), end
        services = _listed(end)
        place = parse(path, "/", services, os.uname().nodename)
        if not place.service:
            raise PropertyError("no-service", f"there is {' '.join(services) or 'none'}")
        return place._replace(typed=typed), self._service_at(side, address, place.service)

    def _service_at(self, side: ClientSide, address: str, service: str) -> PropertyClient:
        """Return a connection for one service alone: names of events do not tell their service."""
        key = f"{address} {service}"
        if key not in self._ends:
            is_first = not any(each.startswith(f"{address} ") for each in self._ends)
            connect = self._connected_to if is_first else self._connect
            self._ends[key] = OfService(connect(side, address), service)
        return self._ends[key]

    def _end(self, place: PropertyTarget) -> PropertyClient:
        if not place.service:
            known = " ".join(self._known()) or "none"
            first = place.name.split(".")[0]
            raise PropertyError("no-service", f"no service named {first} (there is {known})")
        if place.service not in self._ends:
            self._ends[place.service] = self._connected(place.service)
        return self._ends[place.service]

    def _connected(self, service: str) -> PropertyClient:
        if self._at:
            return self._service_at(self._side(), self._at, service)
        from rtkit.link.places import service_socket
        from rtkit.wires.line.client import connect_unix

        return connect_unix(service_socket(service), self._timeout_s)

    def close(self) -> None:
        """End all connections."""
        for end in self._ends.values():
            end.close()
        self._ends.clear()


def _listed(endpoint: PropertyClient) -> list[str]:
    """Return the services behind an endpoint."""
    return str(endpoint.ask("door/services").value()).strip("()").split()


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

    code = failure(error).error
    return PropertyError(code, f"{typed}: {code}: {error}")


def asked(ask: Callable[[], Answer], typed: str) -> Payload:
    """Return the value of an answer.

    Raises:
        PropertyError: As commands show it.
    """
    try:
        return ask().value()
    except Exception as error:
        raise printed_error(typed, error) from error
