"""Maps names of interface definitions to the data types that rtkit provides itself."""

from __future__ import annotations

from rtkit.component.standard import SCOPES, find, home_of, names_of
from rtkit.idl.model import Path
from rtkit.rtc.data_types import scoped_name

KNOWN: frozenset[Path] = frozenset((scope, name) for scope in SCOPES for name in names_of(scope))
"""Paths of the standard data types."""

IMAGES = "from rtkit.component import images"
"""Import that code with data types of the module ``Img`` needs."""

_PREFIXES = {"RTC": "rt", "Img": "images"}


def expression(path: Path) -> str:
    """Return the expression of a standard type; empty for another one."""
    return f"{_PREFIXES[path[0]]}.{path[1]}" if path in KNOWN else ""


def path_of(text: str) -> Path:
    """Return the path of a data type as a profile names it: ``TimedLong``, ``RTC::TimedLong``."""
    path = tuple(part for part in scoped_name(text).split("::") if part)
    if len(path) == 1:
        return next(((scope, *path) for scope in SCOPES if home_of(scope, path[0])), path)
    return path


def first_member(path: Path) -> str:
    """Return the first member of a type that is an enumeration; empty for another one."""
    scope, name = path
    known = find(scope, name)
    return known.body.partition(",")[0].strip() if known and known.kind == "enum" else ""
