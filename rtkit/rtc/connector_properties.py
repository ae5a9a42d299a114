"""Properties of connectors: their defaults and aliases, and which values mean the same."""

from __future__ import annotations

import math
from collections.abc import Mapping

INTERFACE_TYPE = "dataport.interface_type"
DEFAULT_INTERFACE = "zenoh"
DIRECT = "direct"
USUAL_NAMES = {DEFAULT_INTERFACE: "corba_cdr", "shm": "shared_memory"}
"""Names by which other tools know interface types of rtkit."""

DATAFLOW_TYPE = "dataport.dataflow_type"
USUAL_DATAFLOW = "push"

SUBSCRIPTION_TYPE = "dataport.subscription_type"
PORT_TYPE = "port.port_type"
"""States what the ends say already: a connector that leaves it out is the same one."""

SUBSCRIPTIONS = ("flush", "new", "periodic")

PUSH_RATES = ("dataport.publisher.push_rate", "dataport.push_rate")
"""Of these [Hz] the first that is stated counts, else `PUSH_INTERVAL` [s]."""
PUSH_INTERVAL = "dataport.push_interval"
_NUMBERS = frozenset(
    (
        *PUSH_RATES,
        PUSH_INTERVAL,
        "dataport.publisher.skip_count",
        *(
            f"dataport.{side}buffer.{tail}"
            for side in ("", "outport.", "inport.")
            for tail in ("length", "write.timeout", "read.timeout")
        ),
    )
)

_ALIASES = {
    INTERFACE_TYPE: {"corba_cdr": "zenoh", "data_service": "zenoh", "shared_memory": "shm"},
    # Writers of OpenRTM 2: one that waits until the value is delivered, and one that does not.
    SUBSCRIPTION_TYPE: {"block": "flush", "nonblock": "new"},
}
# Of subscriptions what is usual differs from port to port.
_USUAL = {INTERFACE_TYPE: DEFAULT_INTERFACE, DATAFLOW_TYPE: USUAL_DATAFLOW, SUBSCRIPTION_TYPE: ""}


def interface_name(text: str) -> str:
    """Return the name by which rtkit knows an interface type."""
    return canonical(INTERFACE_TYPE, text)


def canonical(key: str, text: str) -> str:
    """Return the word by which rtkit knows a value of a connector's property."""
    word = text.strip().lower()
    return _ALIASES.get(key, {}).get(word, word)


def finite(text: str) -> float | None:
    """Return a number, None of what is none, or is not finite."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def differing(wanted: Mapping[str, str], present: Mapping[str, str]) -> list[str]:
    """Return the keys of `wanted` whose value means another one in `present`.

    Numbers compare as numbers. Interface, data flow and subscription types go by any of their
    names; an absent one has its usual value.
    """
    return sorted(
        key
        for key, value in wanted.items()
        if present.get(key) != value and not _means_same(key, value, present.get(key, ""))
    )


def _means_same(key: str, one: str, other: str) -> bool:
    if key == PORT_TYPE:
        return not other
    if key in _NUMBERS:
        number = finite(one)
        return number is not None and number == finite(other)
    usual = _USUAL.get(key)
    return usual is not None and canonical(key, one or usual) == canonical(key, other or usual)
