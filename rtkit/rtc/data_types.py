"""Names of data types, as the RTC world writes them.

``IDL:RTC/TimedLong:1.0``, ``RTC::TimedLong`` and ``TimedLong`` are one type.
"""

from __future__ import annotations

ANY = "any"
"""Data type of a port that carries bytes of whatever type."""


def scoped_name(text: str) -> str:
    """Return the name in the form ``RTC::TimedLong``; "" for a type that is left open."""
    name = text.strip()
    if name.upper().startswith("IDL:"):
        name = name[4:]
        head, colon, tail = name.rpartition(":")
        if colon and tail.replace(".", "").isdigit():
            name = head
    name = name.replace("/", "::").removeprefix("::")
    return "" if name.lower() == ANY else name


def is_same_type(one: str, other: str) -> bool:
    """Return whether two data type names may be connected; an open type goes with all.

    A name without module stands for the type of that name in any module.
    """
    one, other = scoped_name(one), scoped_name(other)
    if not one or not other or one == other:
        return True
    if "::" in one and "::" in other:
        return False
    return one.rpartition("::")[2] == other.rpartition("::")[2]
