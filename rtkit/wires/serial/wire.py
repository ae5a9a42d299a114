"""Record of serial lines: the line protocol with checks."""

from __future__ import annotations

from rtkit.wires.serial.address import SCHEME, read_address, split_target
from rtkit.wires.wire import ClientSide, ProviderAddress, Wire, WireSettings, loaded


def _provider(device: str, settings: WireSettings) -> ProviderAddress:
    from rtkit.property.naming import escape
    from rtkit.wires.serial.client import connect_serial
    from rtkit.wires.serial.provider_connection import SerialConnection

    def connect() -> SerialConnection:
        return SerialConnection(settings.host, connect_serial(device, settings.timeout_s))

    return ProviderAddress(connect, escape(read_address(device).device.rpartition("/")[2]))


SERIAL = Wire(
    "serial",
    "Lines of text with checks over a serial device.",
    "serial:DEVICE",
    "serial:DEVICE",
    _provider,
    loaded("serial.endpoint:open_serial"),
    ClientSide(
        SCHEME,
        split_target,
        loaded("serial.client:connect_serial"),
        read_address,
        has_services=False,
    ),
    extra="serial",
)
