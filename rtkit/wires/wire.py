"""Wire of the Property Service: the record by which every other table knows it.

A package of `rtkit.wires` declares its wires in ``wire.py``, `rtkit.wires.table` lists them. The
functions of a record import what they need when they are called: commands load records at each
start.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.serving.event_loop import PropertyEventLoop
    from rtkit.serving.provider import PropertyProvider
    from rtkit.wires.property_client import PropertyClient
    from rtkit.wires.provider_connection import ConnectionMaker

LOOPBACK = "127.0.0.1"
SERVICES = "door/services"
"""Target that lists the services behind an endpoint."""


class WireSettings(NamedTuple):
    """Settings that endpoints are opened with, and providers connected to.

    Attributes:
        host: Event loop of the process.
        timeout_s: Bound on each attempt to connect [s].
        settable: Patterns of names that clients may set over wires that do not tell who they are.
        is_insecure: Whether endpoints without TLS may be reached from other hosts.
    """

    host: PropertyEventLoop
    timeout_s: float = 5.0
    settable: Sequence[str] = ()
    is_insecure: bool = False


class ProviderAddress(NamedTuple):
    """Address of an owner to ask.

    Attributes:
        connect: Makes connections to it.
        name: What it is called, where the other side asks for a name.
    """

    connect: ConnectionMaker
    name: str


class ClientSide(NamedTuple):
    """Addresses that commands take for one property: ``http://HOST:PORT/ps/SERVICE/NAME``.

    Attributes:
        prefix: Beginning of the addresses.
        split: Returns the address of the endpoint in one, and what follows; raises `Malformed`.
        connect: Connects to the address of an endpoint, waiting so long for each answer [s].
        check: Raises `Malformed` if something is no address of an endpoint.
        has_services: Whether the endpoint serves several services, each of which has a name.
        folder: Between the address of an endpoint and the name of a service.
    """

    prefix: str
    split: Callable[[str], tuple[str, str]]
    connect: Callable[[str, float], PropertyClient]
    check: Callable[[str], object] = str
    has_services: bool = True
    folder: str = ""


class Wire(NamedTuple):
    """Wire of the Property Service.

    Attributes:
        scheme: In front of its addresses, and its name in access rules.
        summary: One line about it.
        source: Form of the address of a service.
        target: Form of the address of an endpoint; `PORT`, `PATH`, `SERVICE` and `DEVICE` in it
            are what tests fill in.
        provider: Returns the owner behind what follows the scheme in an address.
        open: Opens an endpoint, on the loop, at what follows the scheme; returns its full address.
        client: How commands reach one property, None if they do not.
        extra: Extra of the distribution that it needs, empty for none.
    """

    scheme: str
    summary: str
    source: str
    target: str
    provider: Callable[[str, WireSettings], ProviderAddress]
    open: Callable[[str, PropertyProvider, WireSettings], str]
    client: ClientSide | None = None
    extra: str = ""


def loaded(function: str) -> Callable[..., Any]:
    """Return what calls a function of `rtkit.wires`, ``package.module:name``, loaded by then."""
    module, _, name = function.partition(":")
    return lambda *args: getattr(import_module(f"rtkit.wires.{module}"), name)(*args)


def host_and_port(address: str) -> tuple[str, int]:
    """Read ``[HOST:]PORT``.

    Raises:
        Malformed: It is something else.
    """
    host, _, port = address.removeprefix("//").rstrip("/").rpartition(":")
    if not (port.isascii() and port.isdigit() and int(port) <= 65535):
        raise Malformed(f"not HOST:PORT: {address}")
    return host or "localhost", int(port)


def place_to_open(scheme: str, address: str, settings: WireSettings) -> tuple[str, int]:
    """Return address and port to open, that of loopback unless told.

    Raises:
        Malformed: It is neither PORT nor ADDRESS:PORT with a numeric address.
        Refused: Other hosts would reach it, and it is not for them.
    """
    from ipaddress import ip_address

    from rtkit.keys import reach

    host, port = host_and_port(address)
    reach.check(scheme, host, is_insecure=settings.is_insecure)
    bare = LOOPBACK if host in reach.HERE else host.strip("[]")
    try:
        return str(ip_address(bare)), port
    except ValueError:
        raise Malformed(f"not a numeric ADDRESS:PORT (0.0.0.0 is all of IPv4): {address}") from None


def opened(address: str, scheme: str, place: str, settings: WireSettings) -> str:
    """Return the address of an endpoint that was opened at a place, noted if it is insecure."""
    from rtkit.keys import reach

    if scheme not in reach.BEHIND_TLS and not reach.is_here(place):
        from rtkit.link import insecure

        settings.host.at_end(insecure.note(address))
    return address


def shown_host(address: str) -> str:
    """Return how clients may write the host of an address that is opened."""
    from rtkit.link.places import host_name

    if address in ("127.0.0.1", "::1"):
        return "localhost"
    if address in ("0.0.0.0", "::"):
        return host_name()
    return f"[{address}]" if ":" in address else address


def split_behind(prefix: str, separator: str = "/") -> Callable[[str], tuple[str, str]]:
    """Return the function that splits an address at the first separator behind its prefix."""

    def split(typed: str) -> tuple[str, str]:
        place, _, path = typed.removeprefix(prefix).partition(separator)
        return prefix + place, path

    return split


def service_name(typed: str) -> str:
    """Return the name of a service of this host, with or without ``/localhost/``.

    Raises:
        Malformed: It is none.
    """
    from rtkit.property.codes import PropertyError
    from rtkit.property.naming import canonical_segment

    name = typed.removeprefix("/localhost/")
    try:
        return "/".join(map(canonical_segment, name.split("/")))
    except PropertyError as error:
        raise Malformed(f"not a name of a service: {name!r}") from error
