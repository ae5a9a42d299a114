"""Reads the properties of a data connector into options.

Values compare without regard to case; invalid numbers and policies are refused. Unknown keys and
words are kept for others, and `remarks` lists them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import StrEnum
from typing import TypeVar

from rtkit.component.ports.port_matching import ANY_DATA_TYPE
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass
from rtkit.rtc.connector_properties import (
    DATAFLOW_TYPE,
    DEFAULT_INTERFACE,
    INTERFACE_TYPE,
    PUSH_INTERVAL,
    PUSH_RATES,
    SUBSCRIPTION_TYPE,
    SUBSCRIPTIONS,
    USUAL_DATAFLOW,
    canonical,
    interface_name,
)
from rtkit.rtc.nearest import CLOSE, did_you_mean

DEFAULT_LENGTH = 8
MIN_LENGTH = 2
MAX_LENGTH = 1_000_000
DEFAULT_TIMEOUT_S = 1.0
DEFAULT_PUSH_RATE = 1000.0


class FullPolicy(StrEnum):
    """Action of a write to a full buffer: drop the oldest, drop the new value, wait."""

    OVERWRITE = "overwrite"
    DO_NOTHING = "do_nothing"
    BLOCK = "block"


class EmptyPolicy(StrEnum):
    """Action of a read from an empty buffer: return the last value again, return nothing, wait."""

    READBACK = "readback"
    DO_NOTHING = "do_nothing"
    BLOCK = "block"


class PushPolicy(StrEnum):
    """Choice of the buffered values that a publisher sends: newest, all, oldest, every (n+1)th."""

    NEW = "new"
    ALL = "all"
    FIFO = "fifo"
    SKIP = "skip"


class PortStatus(StrEnum):
    """Outcome of a write to, or a read from, a connector."""

    OK = "ok"
    ERROR = "error"
    FULL = "full"
    EMPTY = "empty"
    TIMEOUT = "timeout"
    CONNECTION_LOST = "connection lost"
    PRECONDITION_NOT_MET = "precondition not met"


@dataclass(frozen=True, slots=True)
class BufferOptions:
    """One ring buffer of a connector; time-outs [s] are for the policy ``block``."""

    length: int = DEFAULT_LENGTH
    full_policy: FullPolicy = FullPolicy.OVERWRITE
    write_timeout: float = DEFAULT_TIMEOUT_S
    empty_policy: EmptyPolicy = EmptyPolicy.READBACK
    read_timeout: float = DEFAULT_TIMEOUT_S


@dataclass(frozen=True, slots=True)
class ConnectorOptions:
    """Options of a data connector, defaults filled in.

    Attributes:
        interface: ``zenoh``, ``direct`` or another; old names of the default are ``zenoh``.
        dataflow: ``push``, ``pull`` or another.
        subscription: ``flush``, ``new`` or ``periodic``; unknown ones count as ``new``.
        push_rate: Of subscription ``periodic`` [Hz]; may be stated as an interval [s].
        is_big_endian: The order of bytes between processes, and for ports that read bytes.
        outport: The buffer on the side of the out port.
        inport: The buffer on the side of the in port.
    """

    data_type: str = ""
    interface: str = "zenoh"
    dataflow: str = "push"
    subscription: str = "new"
    push_policy: PushPolicy = PushPolicy.NEW
    skip_count: int = 0
    push_rate: float = DEFAULT_PUSH_RATE
    is_big_endian: bool = False
    outport: BufferOptions = BufferOptions()
    inport: BufferOptions = BufferOptions()


_ENDIAN = "dataport.serializer.cdr.endian"
NUMBERED = "rtkit.numbered"
"""Property of a connector between processes whose values are numbered, so that losses show."""
_OURS = "dataport."
_OTHERS = ("dataport.corba_cdr.", "dataport.data_service.", "dataport.direct.", "port.")
"""Prefixes of keys that other middleware or other modules interpret."""
_BUFFER = ("length", "write.full_policy", "write.timeout", "read.empty_policy", "read.timeout")
_KEYS = (
    "dataport.data_type",
    "dataport.inport.data_type",
    "dataport.outport.data_type",
    INTERFACE_TYPE,
    DATAFLOW_TYPE,
    SUBSCRIPTION_TYPE,
    "dataport.publisher.push_policy",
    "dataport.publisher.skip_count",
    *PUSH_RATES,
    PUSH_INTERVAL,
    *(f"dataport.{side}buffer.{tail}" for side in ("", "outport.", "inport.") for tail in _BUFFER),
    _ENDIAN,
    "dataport.fan_in",
    "dataport.fan_out",
)
_RTKIT = (ANY_DATA_TYPE, NUMBERED)
_WORDS = {
    INTERFACE_TYPE: (
        "zenoh", "direct", "shm", "shared_memory",
        "corba_cdr", "corba_any", "data_service", "csp_channel",
    ),
    DATAFLOW_TYPE: ("push", "pull", "duplex"),
    SUBSCRIPTION_TYPE: (*SUBSCRIPTIONS, "block", "nonblock"),
}  # fmt: skip
"""Words known here or in OpenRTM."""
P = TypeVar("P", bound=StrEnum)


def is_channel(properties: Mapping[str, str]) -> bool:
    """Return whether a connector is a channel: its out port knows when its in port takes a value.

    It is pulled, by an in port that reads ahead (see `rtkit.openrtm.csp.channel_out_port`).
    """
    is_duplex = _word(properties, DATAFLOW_TYPE, "") == "duplex"
    return is_duplex or _word(properties, INTERFACE_TYPE, "") == "csp_channel"


def parse_options(properties: Mapping[str, str]) -> ConnectorOptions:
    """Read the properties of a data connector.

    Raises:
        Malformed: A number or a policy that cannot be read; names the key.
    """
    for word in properties.get(_ENDIAN, "").split(","):
        if word.strip().lower() not in ("", "little", "big"):
            raise _bad(properties, _ENDIAN, "one of little, big")
    subscription = canonical(SUBSCRIPTION_TYPE, _word(properties, SUBSCRIPTION_TYPE, "new"))
    policy = _choice(PushPolicy, properties, "dataport.publisher.push_policy", PushPolicy.NEW)
    skip_count = _integer(properties, "dataport.publisher.skip_count", 0)
    if not 0 <= skip_count < MAX_LENGTH:
        raise _bad(properties, "dataport.publisher.skip_count", f"0 to {MAX_LENGTH - 1}")
    return ConnectorOptions(
        data_type=properties.get("dataport.data_type", ""),
        interface=interface_name(_word(properties, INTERFACE_TYPE, DEFAULT_INTERFACE)),
        dataflow=(
            "pull" if is_channel(properties) else _word(properties, DATAFLOW_TYPE, USUAL_DATAFLOW)
        ),
        subscription=subscription if subscription in SUBSCRIPTIONS else "new",
        push_policy=policy,
        skip_count=skip_count,
        push_rate=_push_rate(properties),
        is_big_endian=_word(properties, _ENDIAN, "").partition(",")[0].strip() == "big",
        # A group of skip_count + 1 values must fit, else none would ever be complete.
        outport=_buffer(properties, "outport", skip_count + 1 if policy == "skip" else 0),
        inport=_buffer(properties, "inport", 0),
    )


def remarks(properties: Mapping[str, str]) -> list[str]:
    """Return a line for each property of a data connector that has no meaning here."""
    stated = (key for key, value in properties.items() if value.strip())
    known = {*_KEYS, *_RTKIT}
    unknown = (key for key in stated if key not in known and not key.startswith(_OTHERS))
    hints = {key: _hint(key) for key in unknown}
    found = [
        f"unknown connector property: {key}{hint}"
        for key, hint in hints.items()
        if key.startswith((_OURS, "rtkit.")) or hint
    ]
    for key, words in _WORDS.items():
        word = _word(properties, key, "")
        if word and word not in words:
            hint = did_you_mean(word, words, 1) or f" (one of {', '.join(words)})"
            found.append(f"unknown value of {key}: {word}{hint}")
    return found


def _hint(key: str) -> str:
    if key.startswith("rtkit."):
        return did_you_mean(key, _RTKIT, 1)
    tails = [each.removeprefix(_OURS) for each in _KEYS]
    return did_you_mean(key.removeprefix(_OURS), tails, 1, lambda tail: _OURS + tail, CLOSE)


def _word(properties: Mapping[str, str], key: str, default: str) -> str:
    return properties.get(key, "").strip().lower() or default


def _push_rate(properties: Mapping[str, str]) -> float:
    """Return the rate [Hz]: as it is stated, else that of the interval, else the usual one."""
    rates = []
    for key in (*PUSH_RATES, PUSH_INTERVAL):
        if properties.get(key, "").strip():
            number = _number(properties, key, 0.0)
            unit = "s" if key == PUSH_INTERVAL else "Hz"
            rate = 1.0 / number if key == PUSH_INTERVAL and number else number
            if not 0 < rate < math.inf:
                raise _bad(properties, key, f"a positive number of {unit}")
            rates.append(rate)
    return rates[0] if rates else DEFAULT_PUSH_RATE


def _buffer(properties: Mapping[str, str], side: str, least: int) -> BufferOptions:
    def key(tail: str) -> str:
        own = f"dataport.{side}.buffer.{tail}"
        return own if own in properties else f"dataport.buffer.{tail}"

    length = _integer(properties, key("length"), DEFAULT_LENGTH)
    shortest = 0 if is_channel(properties) else 1
    if not shortest <= length <= MAX_LENGTH:
        raise _bad(properties, key("length"), f"{shortest} to {MAX_LENGTH}")
    return BufferOptions(
        length=max(length, least, MIN_LENGTH),
        full_policy=_choice(FullPolicy, properties, key("write.full_policy"), FullPolicy.OVERWRITE),
        write_timeout=_timeout(properties, key("write.timeout")),
        empty_policy=_choice(
            EmptyPolicy, properties, key("read.empty_policy"), EmptyPolicy.READBACK
        ),
        read_timeout=_timeout(properties, key("read.timeout")),
    )


def _choice(kind: type[P], properties: Mapping[str, str], key: str, default: P) -> P:
    text = properties.get(key, "").strip().lower()
    if not text:
        return default
    try:
        return kind(text)
    except ValueError:
        raise _bad(properties, key, "one of " + ", ".join(kind)) from None


def _integer(properties: Mapping[str, str], key: str, default: int) -> int:
    text = properties.get(key, "").strip()
    if not text:
        return default
    digits = text[1:] if text[0] in "+-" else text
    if not (digits.isascii() and digits.isdigit() and len(digits) < 20):
        raise _bad(properties, key, "an integer")
    return int(text)


def _number(properties: Mapping[str, str], key: str, default: float) -> float:
    text = properties.get(key, "").strip()
    if not text:
        return default
    try:
        value = float(text)
    except ValueError:
        raise _bad(properties, key, "a number") from None
    if not math.isfinite(value):
        raise _bad(properties, key, "a finite number")
    return value


def _timeout(properties: Mapping[str, str], key: str) -> float:
    timeout = _number(properties, key, DEFAULT_TIMEOUT_S)
    if timeout < 0:
        raise _bad(properties, key, "a time-out of 0 s or more")
    return timeout


def _bad(properties: Mapping[str, str], key: str, wanted: str) -> Malformed:
    return Malformed(f"{key}={properties.get(key, '')}: not {wanted}")
