"""Properties of connectors that have defaults and aliases, and which of them mean the same."""

from __future__ import annotations

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

_ALIASES = {
    INTERFACE_TYPE: {"corba_cdr": "zenoh", "data_service": "zenoh", "shared_memory": "shm"},
    # Writers of OpenRTM 2: one that waits until the value is delivered, and one that does not.
    SUBSCRIPTION_TYPE: {"block": "flush", "nonblock": "new"},
}


def interface_name(text: str) -> str:
    """Return the name by which rtkit knows an interface type."""
    return canonical(INTERFACE_TYPE, text)


def canonical(key: str, text: str) -> str:
    """Return the word by which rtkit knows a value of a connector's property."""
    word = text.strip().lower()
    return _ALIASES.get(key, {}).get(word, word)


def differing(wanted: Mapping[str, str], present: Mapping[str, str]) -> list[str]:
    """Return the keys of `wanted` whose value means another one in `present`.

    Interface and subscription types go by any of their names; what is left out is what is usual.
    """
    return sorted(
        key
        for key, value in wanted.items()
        if present.get(key) != value and not _is_alias(key, value, present.get(key, ""))
    )


def _is_alias(key: str, one: str, other: str) -> bool:
    if key == INTERFACE_TYPE:
        one, other = one or DEFAULT_INTERFACE, other or DEFAULT_INTERFACE
        return interface_name(one) == interface_name(other)
    if key == PORT_TYPE:
        return not other
    if key == SUBSCRIPTION_TYPE:
        return canonical(key, one) == canonical(key, other)
    return key == DATAFLOW_TYPE and (one or USUAL_DATAFLOW) == (other or USUAL_DATAFLOW)
