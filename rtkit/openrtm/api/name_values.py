"""Functions on lists of names and values; ``OpenRTM_aist.NVUtil``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rtkit.openrtm.api.properties import Properties
from rtkit.openrtm.corba.records import NameValue


def newNV(name: str, value: Any) -> NameValue:
    """Return a name with a value."""
    return NameValue(name, value)


def copyToProperties(properties: Properties, items: Sequence[NameValue]) -> None:
    """Set properties to the values of a list."""
    for each in items:
        properties.setProperty(each.name, each.value)


def copyFromProperties(items: list[NameValue], properties: Properties) -> None:
    """Append all properties to a list."""
    items.extend(NameValue(name, text) for name, text in properties.texts().items())


def toProperties(items: Sequence[NameValue]) -> Properties:
    """Return a list as properties."""
    made = Properties()
    copyToProperties(made, items)
    return made


def find(items: Sequence[NameValue], name: str) -> Any:
    """Return the value of a name.

    Raises:
        KeyError: The list does not have it.
    """
    return items[_at(items, name)].value


def find_index(items: Sequence[NameValue], name: str) -> int:
    """Return the place of a name, -1 where the list does not have it."""
    return next((at for at, each in enumerate(items) if each.name == name), -1)


def _at(items: Sequence[NameValue], name: str) -> int:
    at = find_index(items, name)
    if at < 0:
        raise KeyError(f"Not found: {name}")
    return at


def isString(items: Sequence[NameValue], name: str) -> bool:
    """Return whether a name has a text."""
    at = find_index(items, name)
    return at >= 0 and isinstance(items[at].value, str)


def isStringValue(items: Sequence[NameValue], name: str, value: str) -> bool:
    """Return whether a name has that text."""
    return isString(items, name) and find(items, name) == value


def toString(items: Sequence[NameValue], name: str | None = None) -> str:
    """Return the text of a name, or all of a list."""
    if name is None:
        return "".join(f"{each.name}: {each.value}\n" for each in items)
    return str(find(items, name)) if find_index(items, name) >= 0 else ""


def append(items: list[NameValue], others: Sequence[NameValue]) -> None:
    """Append a list to another one."""
    items.extend(others)


def appendStringValue(items: list[NameValue], name: str, value: str) -> bool:
    """Add a word to the value of a name, behind a comma."""
    at = find_index(items, name)
    if at < 0:
        items.append(NameValue(name, value))
    elif value not in [each.strip() for each in str(items[at].value).split(",")]:
        found = items[at]
        items[at] = NameValue(name, f"{found.value},{value}")
    return True
