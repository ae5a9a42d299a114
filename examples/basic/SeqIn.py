"""A sink of all basic types and their sequences, for trying data ports."""

from __future__ import annotations

from typing import Any

from rtkit import component as rt

_TYPES = {
    "Boolean": rt.TimedBoolean,
    "Char": rt.TimedChar,
    "Octet": rt.TimedOctet,
    "Short": rt.TimedShort,
    "Long": rt.TimedLong,
    "Float": rt.TimedFloat,
    "Double": rt.TimedDouble,
    "String": rt.TimedString,
    "BooleanSeq": rt.TimedBooleanSeq,
    "CharSeq": rt.TimedCharSeq,
    "OctetSeq": rt.TimedOctetSeq,
    "ShortSeq": rt.TimedShortSeq,
    "LongSeq": rt.TimedLongSeq,
    "FloatSeq": rt.TimedFloatSeq,
    "DoubleSeq": rt.TimedDoubleSeq,
    "StringSeq": rt.TimedStringSeq,
}


class SeqIn(rt.Component):
    """Read every basic data type, alone and as a sequence, and keep the last of each.

    Its ports are made when it is initialised, one for each row of a table.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 10.0

    def on_initialize(self) -> None:
        """Make the ports."""
        self.last: dict[str, Any] = {}
        self._inputs: list[rt.InPort[Any]] = [
            self.add_in_port(name, data_type) for name, data_type in _TYPES.items()
        ]

    def on_execute(self, context: str) -> None:
        """Keep the newest value of each port, and log it."""
        for port in self._inputs:
            for value in port.read_all():
                self.last[port.name] = value
                self.logger.info("%s %s", port.name, value.data)


def SeqInInit(manager: rt.Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(SeqIn)
