"""The basic data types of the RTC specification, and the IDL widths to declare further ones.

A data type of one's own is a dataclass whose fields are annotated with the names here, with
``bool``, ``str``, ``bytes`` (a sequence of octets), ``tuple`` or ``list`` of one of them, an enum,
or another dataclass. A plain ``int`` has 64 bits, a plain ``float`` too.
"""

from __future__ import annotations

import time
from typing import Annotated

from rtkit.component.typenames import register_all
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


EPOCH = Time()


@dataclass(frozen=True, slots=True)
class TimedState:
    """A state number and when it was reached."""

    tm: Time = EPOCH
    data: Short = 0


@dataclass(frozen=True, slots=True)
class TimedBoolean:
    """A truth value and when it was taken."""

    tm: Time = EPOCH
    data: bool = False


@dataclass(frozen=True, slots=True)
class TimedChar:
    """A character and when it was taken."""

    tm: Time = EPOCH
    data: Char = "\0"


@dataclass(frozen=True, slots=True)
class TimedWChar:
    """A character of the basic multilingual plane and when it was taken."""

    tm: Time = EPOCH
    data: WChar = "\0"


@dataclass(frozen=True, slots=True)
class TimedOctet:
    """A byte and when it was taken."""

    tm: Time = EPOCH
    data: Octet = 0


@dataclass(frozen=True, slots=True)
class TimedShort:
    """A 16 bit integer and when it was taken."""

    tm: Time = EPOCH
    data: Short = 0


@dataclass(frozen=True, slots=True)
class TimedUShort:
    """An unsigned 16 bit integer and when it was taken."""

    tm: Time = EPOCH
    data: UShort = 0


@dataclass(frozen=True, slots=True)
class TimedLong:
    """A 32 bit integer and when it was taken."""

    tm: Time = EPOCH
    data: Long = 0


@dataclass(frozen=True, slots=True)
class TimedULong:
    """An unsigned 32 bit integer and when it was taken."""

    tm: Time = EPOCH
    data: ULong = 0


@dataclass(frozen=True, slots=True)
class TimedFloat:
    """A 32 bit number and when it was taken."""

    tm: Time = EPOCH
    data: Float = 0.0


@dataclass(frozen=True, slots=True)
class TimedDouble:
    """A 64 bit number and when it was taken."""

    tm: Time = EPOCH
    data: Double = 0.0


@dataclass(frozen=True, slots=True)
class TimedString:
    """A text and when it was taken."""

    tm: Time = EPOCH
    data: str = ""


@dataclass(frozen=True, slots=True)
class TimedWString:
    """A wide text and when it was taken."""

    tm: Time = EPOCH
    data: WString = ""


@dataclass(frozen=True, slots=True)
class TimedBooleanSeq:
    """A sequence of truth values and when it was taken."""

    tm: Time = EPOCH
    data: tuple[bool, ...] = ()


@dataclass(frozen=True, slots=True)
class TimedCharSeq:
    """A sequence of characters and when it was taken."""

    tm: Time = EPOCH
    data: tuple[Char, ...] = ()


@dataclass(frozen=True, slots=True)
class TimedOctetSeq:
    """A sequence of bytes and when it was taken."""

    tm: Time = EPOCH
    data: bytes = b""


@dataclass(frozen=True, slots=True)
class TimedShortSeq:
    """A sequence of 16 bit integers and when it was taken."""

    tm: Time = EPOCH
    data: tuple[Short, ...] = ()


@dataclass(frozen=True, slots=True)
class TimedUShortSeq:
    """A sequence of unsigned 16 bit integers and when it was taken."""

    tm: Time = EPOCH
    data: tuple[UShort, ...] = ()


@dataclass(frozen=True, slots=True)
class TimedLongSeq:
    """A sequence of 32 bit integers and when it was taken."""

    tm: Time = EPOCH
    data: tuple[Long, ...] = ()


@dataclass(frozen=True, slots=True)
class TimedULongSeq:
    """A sequence of unsigned 32 bit integers and when it was taken."""

    tm: Time = EPOCH
    data: tuple[ULong, ...] = ()


@dataclass(frozen=True, slots=True)
class TimedFloatSeq:
    """A sequence of 32 bit numbers and when it was taken."""

    tm: Time = EPOCH
    data: tuple[Float, ...] = ()


@dataclass(frozen=True, slots=True)
class TimedDoubleSeq:
    """A sequence of 64 bit numbers and when it was taken."""

    tm: Time = EPOCH
    data: tuple[Double, ...] = ()


@dataclass(frozen=True, slots=True)
class TimedWCharSeq:
    """A sequence of characters of the basic multilingual plane and when it was taken."""

    tm: Time = EPOCH
    data: tuple[WChar, ...] = ()


@dataclass(frozen=True, slots=True)
class TimedStringSeq:
    """A sequence of texts and when it was taken."""

    tm: Time = EPOCH
    data: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TimedWStringSeq:
    """A sequence of wide texts and when it was taken."""

    tm: Time = EPOCH
    data: tuple[WString, ...] = ()


register_all(globals(), "RTC")
