"""Time as the RTC specification has it, and the IDL widths to declare data types with.

A data type of one's own is a dataclass whose fields are annotated with the names here, with
``bool``, ``str``, ``bytes`` (a sequence of octets), ``tuple`` or ``list`` of one of them, an enum,
or another dataclass. A plain ``int`` has 64 bits, a plain ``float`` too.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Annotated, Any

from rtkit.component.values.typenames import register
from rtkit.fast_dataclass import dataclass

Char = Annotated[str, "char"]
Octet = Annotated[int, "uint8"]
Short = Annotated[int, "int16"]
UShort = Annotated[int, "uint16"]
Long = Annotated[int, "int32"]
ULong = Annotated[int, "uint32"]
LongLong = Annotated[int, "int64"]
ULongLong = Annotated[int, "uint64"]
Float = Annotated[float, "float32"]
Double = Annotated[float, "float64"]
WChar = Annotated[str, "wchar"]
WString = Annotated[str, "wstring"]

BASIC_TYPES: Mapping[str, Any] = {
    "boolean": bool,
    "string": str,
    "octet": Octet,
    "char": Char,
    "wchar": WChar,
    "wstring": WString,
    "short": Short,
    "unsigned short": UShort,
    "long": Long,
    "unsigned long": ULong,
    "long long": LongLong,
    "unsigned long long": ULongLong,
    "float": Float,
    "double": Double,
    "int8": Annotated[int, "int8"],
    "uint8": Octet,
    "int16": Short,
    "uint16": UShort,
    "int32": Long,
    "uint32": ULong,
    "int64": LongLong,
    "uint64": ULongLong,
}
"""Names of each basic type of interface definitions; the usual names come first."""

_NANOSECONDS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Time:
    """A point in time: seconds [s] and nanoseconds since 1970-01-01 UTC."""

    sec: ULong = 0
    nsec: ULong = 0

    @classmethod
    def now(cls) -> Time:
        """Return the current time."""
        return cls(*divmod(time.time_ns(), _NANOSECONDS))


register(Time, "RTC::Time")
