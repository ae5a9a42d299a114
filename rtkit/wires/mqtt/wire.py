"""Record of MQTT: properties below a topic of a broker."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.wires.wire import ProviderAddress, Wire, WireSettings, opened

if TYPE_CHECKING:
    from rtkit.serving.provider import PropertyProvider


def _provider(address: str, settings: WireSettings) -> ProviderAddress:
    from rtkit.property.naming import segment_of
    from rtkit.wires.mqtt.address import read_address
    from rtkit.wires.mqtt.provider_connection import MqttConnection

    place = read_address(address, is_insecure=settings.is_insecure)
    return ProviderAddress(
        lambda: MqttConnection(settings.host, place, settings.timeout_s),
        segment_of(place.path.rpartition("/")[2]),
    )


def _open(address: str, provider: PropertyProvider, settings: WireSettings) -> str:
    from rtkit.wires.mqtt.address import read_address
    from rtkit.wires.mqtt.endpoint import MqttEndpoint

    place = read_address(address, is_insecure=settings.is_insecure)
    MqttEndpoint(settings.host, provider, place, settings.timeout_s)
    return opened(f"{place}/{provider.name}", "mqtt", place.host, settings)


MQTT = Wire(
    "mqtt",
    "Topics of an MQTT 5 broker of this host (password: RTKIT_MQTT_PASSWORD).",
    "mqtt:USER@HOST/TOPIC",
    "mqtt:USER@HOST/TOPIC",
    _provider,
    _open,
    extra="mqtt",
)
