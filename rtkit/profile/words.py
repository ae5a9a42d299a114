"""Interprets texts inside profiles: port names, data types, properties."""

from __future__ import annotations

import re
from collections.abc import Iterable

from rtkit.profile.common import ExtensionProperty

OWN_PREFIX = "rtkit."
"""Names of rtkit's own extension properties begin with this."""

PATH_ID = "COMPONENT_PATH_ID"
"""Property of a connector's end: the path of its component."""

_IDL_FORM = r"\s*IDL:(.*?):([0-9.]+)\s*"


def strip_instance(port_name: str, instance_name: str) -> str:
    """Return the port's own name where a profile writes ``<instance>.<port>``.

    >>> strip_instance("ConsoleIn0.out", "ConsoleIn0"), strip_instance("out", "ConsoleIn0")
    ('out', 'out')
    """
    own = port_name.removeprefix(f"{instance_name}.")
    return own or port_name


def normal_data_type(text: str) -> str:
    """Bring the ways to write a data type to one form, ``IDL:RTC/TimedLong:1.0``.

    A name without module is taken from ``RTC``. Empty and ``Any`` stay as they are.

    >>> normal_data_type("TimedLong"), normal_data_type("RTC::TimedLong")
    ('IDL:RTC/TimedLong:1.0', 'IDL:RTC/TimedLong:1.0')
    """
    name = text.strip()
    version = "1.0"
    given = re.fullmatch(_IDL_FORM, name, re.DOTALL | re.IGNORECASE) if ":" in name else None
    if given:
        name, version = given[1], given[2]
    name = name.replace("::", "/").strip("/ ")
    if not name or name.lower() == "any":
        return name
    if "/" not in name:
        name = f"RTC/{name}"
    return f"IDL:{name}:{version}"


SET = "rtkit.set."
"""Property of a configuration parameter, with the name of a further set: its value in that set."""


def values_in_sets(properties: Iterable[ExtensionProperty]) -> dict[str, str]:
    """Return the values that a parameter has in further configuration sets, by name of the set."""
    named = ((item.name.removeprefix(SET), item) for item in properties)
    return {name: item.value or "" for name, item in named if name and name != item.name}


def property_value(properties: Iterable[ExtensionProperty], name: str) -> str | None:
    """Return the value of the first property named `name`; None when absent or without value."""
    for item in properties:
        if item.name == name:
            return item.value
    return None
