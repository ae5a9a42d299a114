"""Record of zenoh: queries, and a key for each subscription."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.errors import Unreachable
from rtkit.link.places import host_name
from rtkit.rtc.names import is_local_host
from rtkit.wires.wire import ProviderAddress, Wire, WireSettings, service_name

if TYPE_CHECKING:
    from rtkit.serving.provider import PropertyProvider


def _provider(name: str, settings: WireSettings) -> ProviderAddress:
    from rtkit.link import places, zenoh_keys
    from rtkit.link.zenoh import open_to_service
    from rtkit.wires.zenoh.far_services import FarService
    from rtkit.wires.zenoh.provider_connection import ZenohConnection

    if name.startswith("/") and not is_local_host(name.split("/")[1], host_name()):
        return FarService.parse(name).provider(settings)
    service = service_name(name)
    places.check_socket_length(places.service_key_socket(service))
    key = zenoh_keys.property_service(host_name(), service)

    def connect() -> ZenohConnection:
        try:
            session = open_to_service(service, settings.timeout_s)
        except Unreachable as error:
            raise Unreachable(f"cannot reach service {service} over zenoh") from error
        return ZenohConnection(settings.host, session, key)

    return ProviderAddress(connect, service)


def _open(name: str, provider: PropertyProvider, settings: WireSettings) -> str:
    """Give a provider a name in the tree, where commands and zenoh find it."""
    from rtkit.wires.line.endpoint import open_unix
    from rtkit.wires.zenoh.on_demand import open_when_needed

    provider.name = service_name(name)
    if settings.host.services.get(provider.name) is not provider:  # as its owner is called, too
        settings.host.add(provider)
    open_unix(settings.host, provider.name)
    open_when_needed(settings.host, provider)
    return f"/localhost/{provider.name}"


ZENOH = Wire(
    "zenoh",
    "Queries over zenoh, by the name of a service of this host.",
    "zenoh:SERVICE",
    "zenoh:SERVICE",
    _provider,
    _open,
)
