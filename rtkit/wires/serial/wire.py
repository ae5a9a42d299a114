"""Record of serial lines: the line protocol with checks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.wires.serial.address import SCHEME, read_address, split_target
from rtkit.wires.wire import ClientSide, ProviderAddress, Wire, WireSettings

if TYPE_CHECKING:
    from rtkit.serving.provider import PropertyProvider
    from rtkit.wires.property_client import PropertyClient


def _provider(device: str, settings: WireSettings) -> ProviderAddress:
    from rtkit.property.naming import escape
    from rtkit.wires.serial.client import connect_serial
    from rtkit.wires.serial.provider_connection import SerialConnection

    name = read_address(device).device.rpartition("/")[2]
    return ProviderAddress(
        lambda: SerialConnection(settings.host, connect_serial(device, settings.timeout_s)),
        escape(name),
    )


def _open(device: str, provider: PropertyProvider, settings: WireSettings) -> str:
    from rtkit.wires.serial.endpoint import open_serial

    open_serial(settings.host, read_address(device), provider.name, settings.settable)
    return f"{SCHEME}{device.removeprefix(SCHEME)}"


def _connect(address: str, timeout_s: float) -> PropertyClient:
    from rtkit.wires.serial.client import connect_serial

    return connect_serial(address, timeout_s)


SERIAL = Wire(
    "serial",
    "Lines of text with checks over a serial device.",
    "serial:DEVICE",
    "serial:DEVICE",
    _provider,
    _open,
    ClientSide(SCHEME, split_target, _connect, read_address, has_services=False),
    extra="serial",
)
