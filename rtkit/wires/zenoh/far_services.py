"""Property services of other hosts, reached through the routers of the hosts' managers.

A host that is linked from here may be asked all. Any other one may be asked what its owner lets
services of this host ask: where a link is seen from its far end, or a third host links both.

See decision 80.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import zenoh

from rtkit.errors import Unreachable
from rtkit.link import host_links, places, zenoh_keys
from rtkit.link.places import host_name
from rtkit.link.zenoh import open_client, unix_endpoint
from rtkit.wires.wire import ProviderAddress, WireSettings
from rtkit.wires.zenoh.provider_connection import ZenohConnection

if TYPE_CHECKING:
    from rtkit.serving.event_loop import PropertyEventLoop

_MOST = 100_000
"""Services of one host; zenoh hangs where replies have no room (transport, deadlocks)."""


class FarService(NamedTuple):
    """Service of another host."""

    host: str
    name: str

    @classmethod
    def parse(cls, path: str) -> FarService:
        """Read ``/HOST/SERVICE``."""
        host, _, name = path.strip("/").partition("/")
        return cls(host, name)

    @property
    def key(self) -> str:
        """Its key, as services of this host ask it."""
        return f"{_root(self.host)}/{self.name}"

    def connect(self, host: PropertyEventLoop, timeout_s: float) -> ZenohConnection:
        """Connect to it.

        Raises:
            Unreachable: Its host cannot be reached.
        """
        return ZenohConnection(host, _session(self.host, timeout_s), self.key, self.why_silent)

    def provider(self, settings: WireSettings) -> ProviderAddress:
        """Return it as an owner to ask."""
        return ProviderAddress(lambda: self.connect(settings.host, settings.timeout_s), self.name)

    def why_silent(self) -> str:
        """Return why nobody answers."""
        try:
            check_reached(self.host)
        except Unreachable as error:
            return str(error)
        return f"service {self.name} of host {self.host} has gone"


def check_reached(host: str) -> None:
    """Check that the link to a host is up, where there is one.

    Raises:
        Unreachable: It is not; tells why.
    """
    if why := host_links.why_lost(host):
        raise Unreachable(f"host {host} cannot be reached: {why}")


def services_of(host: str, timeout_s: float) -> list[str]:
    """Return the names of the services of a host that may be asked from here.

    The router of this host knows them: nobody there is asked.

    Raises:
        Unreachable: The host cannot be reached, or there is no manager here.
    """
    root = _root(host)
    session = _session(host, timeout_s)
    try:
        channel: Any = zenoh.handlers.FifoChannel(_MOST)
        key = zenoh_keys.presence(f"{root}/**")
        tokens = [*session.liveliness().get(key, timeout=timeout_s, handler=channel)]
    finally:
        session.close()  # type: ignore[no-untyped-call]
    keys = [str(each.ok.key_expr) for each in tokens if each.ok is not None]
    end = zenoh_keys.presence("")
    return sorted(each.removeprefix(f"{root}/").removesuffix(end) for each in keys)


def _root(host: str) -> str:
    """Return what the keys of all services of a host begin with, as services of this host ask."""
    if host_links.is_linked(host):
        return zenoh_keys.property_service(host, "").rstrip("/")
    return zenoh_keys.service_for(host, "", host_name()).rstrip("/")


def _session(host: str, timeout_s: float) -> zenoh.Session:
    check_reached(host)
    manager = host_links.router(host, places.usual_manager())
    return open_client(unix_endpoint(places.manager_socket(manager)), timeout_s)
