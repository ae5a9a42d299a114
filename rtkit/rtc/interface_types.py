"""How a data connector carries its values: names of its interface type, and what is usual."""

from __future__ import annotations

from collections.abc import Mapping

INTERFACE_TYPE = "dataport.interface_type"
DEFAULT_INTERFACE = "zenoh"
DIRECT = "direct"
USUAL_NAMES = {DEFAULT_INTERFACE: "corba_cdr", "shm": "shared_memory"}
"""Names by which other tools know interface types of rtkit."""

DATAFLOW_TYPE = "dataport.dataflow_type"
USUAL_DATAFLOW = "push"

_ALIASES = {"corba_cdr": "zenoh", "data_service": "zenoh", "shared_memory": "shm"}


def interface_name(text: str) -> str:
    """Return the name by which rtkit knows an interface type."""
    word = text.strip().lower()
    return _ALIASES.get(word, word)


def differing(wanted: Mapping[str, str], present: Mapping[str, str]) -> list[str]:
    """Return the keys of `wanted` whose value means another one in `present`.

    Interface types go by any of their names; what is left out is what is usual.
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
    return key == DATAFLOW_TYPE and (one or USUAL_DATAFLOW) == (other or USUAL_DATAFLOW)
