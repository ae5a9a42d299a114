"""Records of MQTT: properties below a topic of a broker, also behind mutual TLS."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rtkit.wires.wire import ProviderAddress, Wire, WireSettings, opened

if TYPE_CHECKING:
    from rtkit.serving.provider import PropertyProvider


def _provider(address: str, settings: WireSettings, scheme: str = "mqtt") -> ProviderAddress:
    from rtkit.property.naming import segment_of
    from rtkit.wires.mqtt.address import read_address
    from rtkit.wires.mqtt.provider_connection import MqttConnection

    place = read_address(address, scheme, is_insecure=settings.is_insecure)
    return ProviderAddress(
        lambda: MqttConnection(settings.host, place, settings.timeout_s),
        segment_of(place.path.rpartition("/")[2]),
    )


def _open(
    address: str, provider: PropertyProvider, settings: WireSettings, scheme: str = "mqtt"
) -> str:
    from rtkit.wires.mqtt.address import read_address
    from rtkit.wires.mqtt.endpoint import MqttEndpoint

    place = read_address(address, scheme, is_insecure=settings.is_insecure)
    MqttEndpoint(settings.host, provider, place, settings.timeout_s)
    return opened(f"{place}/{provider.name}", scheme, place.host, settings)


MQTT = Wire(
    "mqtt",
    "Topics of an MQTT 5 broker of this host (password: RTKIT_MQTT_PASSWORD).",
    "mqtt:USER@HOST/TOPIC",
    "mqtt:USER@HOST/TOPIC",
    _provider,
    _open,
    extra="mqtt",
)

MQTTS = Wire(
    "mqtts",
    "Topics of an MQTT 5 broker behind mutual TLS.",
    "mqtts:USER@HOST/TOPIC",
    "mqtts:USER@HOST/TOPIC",
    partial(_provider, scheme="mqtts"),
    partial(_open, scheme="mqtts"),
    extra="mqtt",
)
