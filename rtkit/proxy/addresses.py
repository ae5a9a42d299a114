"""Resolves addresses of a proxy: an owner to ask on one side, an endpoint to open on the other.

An address is ``SCHEME:REST``, or a path of the tree. Each scheme is a row of `SOURCES` or `DOORS`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import NamedTuple

from rtkit.errors import Malformed, Refused
from rtkit.link import places
from rtkit.property.codes import PropertyError
from rtkit.property.naming import canonical_segment, escape, segment_of
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.wires.blocking_connection import BlockingConnection
from rtkit.wires.line.provider_connection import LineConnection
from rtkit.wires.provider_connection import ConnectionMaker, ProviderConnection
from rtkit.wires.wire import BoundedClient

_HERE = ("", "localhost", "127.0.0.1")


class ProxySettings(NamedTuple):
    """Settings that addresses are read with.

    Attributes:
        cwd: Working directory in the tree.
        timeout_s: Bound on each attempt to connect [s].
    """

    host: PropertyEventLoop
    cwd: str
    timeout_s: float


class ProviderAddress(NamedTuple):
    """Address of an owner to ask.

    Attributes:
        wire: Makes connections to it.
        name: What it is called, where the other side asks for a name.
    """

    wire: ConnectionMaker
    name: str


def source_of(address: str, setting: ProxySettings) -> ProviderAddress:
    """Return the owner that an address stands for.

    Raises:
        RtkitError: It is no address, or it has to be asked for its name and cannot be reached.
    """
    scheme, mark, rest = address.partition(":")
    if not mark or "/" in scheme:
        return _in_tree(address, setting)
    if scheme not in SOURCES:
        raise Malformed(f"not a way to a service: {address} (there is {_known(SOURCES)})")
    return SOURCES[scheme](rest, setting)


def open_endpoint(address: str, owner: PropertyProvider, setting: ProxySettings) -> str:
    """Open the endpoint of an address, on the loop; return its full address.

    Raises:
        RtkitError: It is no address, or the endpoint cannot be opened.
    """
    scheme, mark, rest = address.partition(":")
    if not mark or "/" in scheme:
        return _named(address, owner, setting)
    if scheme not in DOORS:
        raise Malformed(f"not a door: {address} (there is {_known(DOORS)})")
    setting.host.add(owner)
    return DOORS[scheme](rest, owner, setting)


def _known(table: Mapping[str, object]) -> str:
    return " ".join([*(f"{scheme}:" for scheme in table), "and paths of the tree"])


# Owners


def _in_tree(path: str, setting: ProxySettings) -> ProviderAddress:
    from rtkit.tree.live_place import open_live, split
    from rtkit.tree.properties import parse

    place = parse(path, setting.cwd, places.services(), os.uname().nodename)
    if place.service and not place.name:
        return _unix(places.service_socket(place.service), setting)._replace(name=place.service)
    node, name = split(path, setting.cwd)
    if node and not name:
        called = _calls(lambda: open_live(node, setting.timeout_s), setting.host)
        return ProviderAddress(called, escape(node.rpartition("/")[2].rpartition(".")[0]))
    known = " ".join(places.services()) or "none"
    raise PropertyError("no-service", f"no service: {path} (there is {known})")


def _unix(path: str, setting: ProxySettings) -> ProviderAddress:
    from rtkit.wires.line.client import connect_unix

    def connect() -> ProviderConnection:
        return LineConnection(setting.host, connect_unix(path, setting.timeout_s).detach())

    return ProviderAddress(connect, escape(path.rpartition("/")[2].partition(".")[0]) or "service")


def _tcp(address: str, setting: ProxySettings) -> ProviderAddress:
    from rtkit.wires.line.client import connect_tcp

    place, _, service = address.partition("/")
    host, port = _host_and_port(place)

    def connect() -> ProviderConnection:
        end = connect_tcp(host, port, setting.timeout_s).detach()
        return LineConnection(setting.host, end, service)

    if not service:
        with connect_tcp(host, port, setting.timeout_s) as endpoint:
            known = str(endpoint.ask("door/services").value()).strip("()").split()
        if len(known) != 1:
            told = " ".join(known) or "none"
            raise Refused(f"which service? tcp:{place}/NAME (there is {told})")
        service = known[0]
    return ProviderAddress(connect, service)


def _zenoh(name: str, setting: ProxySettings) -> ProviderAddress:
    from rtkit.link import keys
    from rtkit.link.zenoh import open_client, unix_endpoint
    from rtkit.wires.zenoh.provider_connection import ZenohConnection

    service = _service(name.removeprefix("/localhost/"))
    path = places.check_socket_length(places.service_key_socket(service))
    key = keys.property_service(os.uname().nodename, service)

    def connect() -> ProviderConnection:
        session = open_client(unix_endpoint(path), setting.timeout_s)
        return ZenohConnection(setting.host, session, key)

    return ProviderAddress(connect, service)


def _serial(device: str, setting: ProxySettings) -> ProviderAddress:
    from rtkit.wires.serial.address import read_address
    from rtkit.wires.serial.client import connect_serial
    from rtkit.wires.serial.provider_connection import SerialConnection

    name = read_address(device).device.rpartition("/")[2]

    def connect() -> ProviderConnection:
        return SerialConnection(setting.host, connect_serial(device, setting.timeout_s))

    return ProviderAddress(connect, escape(name))


def _mqtt(address: str, setting: ProxySettings) -> ProviderAddress:
    from rtkit.wires.mqtt.provider_connection import MqttConnection
    from rtkit.wires.mqtt.session import read_address

    place = read_address(address)
    name = segment_of(place.path.rpartition("/")[2])
    return ProviderAddress(lambda: MqttConnection(setting.host, place, setting.timeout_s), name)


def _http(address: str, setting: ProxySettings) -> ProviderAddress:
    from rtkit.wires.http.client import connect_http

    place, _, service = address.removeprefix("//").partition("/")
    service = service.removeprefix("ps/").rstrip("/")
    if not service:
        raise Malformed(f"not http://HOST:PORT/ps/SERVICE: http:{address}")
    another = lambda: connect_http(f"http://{place}", setting.timeout_s, service)  # noqa: E731
    return ProviderAddress(_calls(another, setting.host), service)


def _ice(address: str, setting: ProxySettings) -> ProviderAddress:
    from rtkit.wires.ice.protocol import read_address
    from rtkit.wires.ice.provider_connection import IceConnection

    place = read_address(f"ice:{address}")
    if not place.service:
        raise Malformed(f"not ice://HOST:PORT/SERVICE: ice:{address}")
    return ProviderAddress(
        lambda: IceConnection(setting.host, place, setting.timeout_s), place.service
    )


def _calls(another: Callable[[], BoundedClient], host: PropertyEventLoop) -> ConnectionMaker:
    return lambda: BlockingConnection(host, another(), another)


SOURCES: dict[str, Callable[[str, ProxySettings], ProviderAddress]] = {
    "unix": _unix,
    "tcp": _tcp,
    "zenoh": _zenoh,
    "serial": _serial,
    "http": _http,
    "mqtt": _mqtt,
    "ice": _ice,
}


# Endpoints


def _named(path: str, owner: PropertyProvider, setting: ProxySettings) -> str:
    from rtkit.wires.line.endpoint import open_unix
    from rtkit.wires.zenoh.endpoint import open_zenoh

    owner.name = _service(path.removeprefix("/localhost/"))
    setting.host.add(owner)
    open_unix(setting.host, owner.name)
    open_zenoh(setting.host, owner)
    return f"/localhost/{owner.name}"


def _unix_endpoint(path: str, owner: PropertyProvider, setting: ProxySettings) -> str:
    from rtkit.wires.line.endpoint import open_unix_at

    if not path:
        raise Malformed("not a door: unix: (unix:PATH)")
    return f"unix:{open_unix_at(setting.host, owner.name, path)}"


def _tcp_endpoint(address: str, owner: PropertyProvider, setting: ProxySettings) -> str:
    from rtkit.wires.line.endpoint import open_tcp

    host, port = _host_and_port(address)
    if host not in _HERE:
        raise Refused(f"doors are opened on this host only: tcp:{address}")
    return f"tcp:localhost:{open_tcp(setting.host, owner.name, port)}"


def _http_door(address: str, owner: PropertyProvider, setting: ProxySettings) -> str:
    from rtkit.wires.http.endpoint import open_http

    host, port = _host_and_port(address.removeprefix("//").rstrip("/"))
    if host not in _HERE:
        raise Refused(f"doors are opened on this host only: http:{address}")
    return f"http://localhost:{open_http(setting.host, port)}/ps/{owner.name}"


def _ice_door(address: str, owner: PropertyProvider, setting: ProxySettings) -> str:
    from rtkit.wires.ice.endpoint import open_ice

    host, port = _host_and_port(address.removeprefix("//").rstrip("/"))
    if host not in _HERE:
        raise Refused(f"doors are opened on this host only: ice:{address}")
    return f"ice://localhost:{open_ice(setting.host, port)}/{owner.name}"


def _serial_endpoint(device: str, owner: PropertyProvider, setting: ProxySettings) -> str:
    from rtkit.wires.serial.address import read_address
    from rtkit.wires.serial.endpoint import open_serial

    # What may be set has been decided: nobody is known on a serial line.
    open_serial(setting.host, read_address(device), owner.name, ("*",))
    return f"serial:{device}"


def _mqtt_door(address: str, owner: PropertyProvider, setting: ProxySettings) -> str:
    from rtkit.wires.mqtt.endpoint import MqttEndpoint
    from rtkit.wires.mqtt.session import read_address

    place = read_address(address)
    MqttEndpoint(setting.host, owner, place, setting.timeout_s)
    return f"{place}/{owner.name}"


DOORS: dict[str, Callable[[str, PropertyProvider, ProxySettings], str]] = {
    "unix": _unix_endpoint,
    "tcp": _tcp_endpoint,
    "zenoh": _named,
    "http": _http_door,
    "serial": _serial_endpoint,
    "mqtt": _mqtt_door,
    "ice": _ice_door,
}


def _host_and_port(address: str) -> tuple[str, int]:
    host, _, port = address.rpartition(":")
    if not port.isdecimal() or int(port) > 65535:
        raise Malformed(f"not HOST:PORT: {address}")
    return host or "localhost", int(port)


def _service(name: str) -> str:
    try:
        return "/".join(map(canonical_segment, name.split("/")))
    except PropertyError:
        raise Malformed(f"not a name of a service: {name!r}") from None
