"""Finds the data types that a tool reads and writes: standard ones, and those of modules."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from rtkit.component.values.typenames import type_by_name
from rtkit.errors import NotFound, Refused, RtkitError
from rtkit.rtc.data_types import scoped_name

if TYPE_CHECKING:
    from rtkit.deployment.facts import Snapshot


def import_modules(names: Sequence[str], folders: Sequence[str]) -> None:
    """Import modules that define data types, looked for in these folders too.

    Raises:
        NotFound: There is no such module.
        Refused: It does not import; the message has the reason.
    """
    sys.path[:0] = [os.path.abspath(folder) for folder in folders]
    for name in names:
        try:
            import_module(name)
        except ModuleNotFoundError as error:
            if error.name is None or not f"{name}.".startswith(f"{error.name}."):
                raise Refused(f"module {name} does not import: {error}") from error
            raise NotFound(f"Module not found: {name}") from None
        except Exception as error:
            raise Refused(
                f"module {name} does not import: {type(error).__name__}: {error}"
            ) from error


def data_type(name: str, typed: str, definition: str = "") -> type:
    """Return the class of a data type; bytes for a port that carries any.

    Args:
        name: Of the type.
        typed: The port or recording with values of it, for messages.
        definition: The IDL that comes with it; types that modules define take precedence.

    Raises:
        NotFound: It is not defined.
    """
    if not scoped_name(name):
        return bytes
    found = type_by_name(name)
    if found is None and definition:
        from rtkit.component.values.defined import class_of

        try:
            return class_of(name, definition)
        except RtkitError as error:
            raise NotFound(f"Type not found: {name} of {typed} ({error})") from error
    if found is None:
        raise NotFound(f"Type not found: {name} of {typed} (-m imports the module that defines it)")
    return found


def type_or_bytes(
    name: str, typed: str, notify: Callable[[str], object], definition: str = ""
) -> type:
    """Return the class of a data type; bytes, with a note, where it is not defined.

    One stream of an unknown type is no reason to lose all others.
    """
    try:
        return data_type(name, typed, definition)
    except NotFound as error:
        notify(f"warning: {error}; its values stay bytes")
        return bytes


def definitions(snapshot: Snapshot) -> dict[str, str]:
    """Return the IDL of each data type that a port tells, by the name of the type."""
    return {
        scoped_name(port.data_type): port.definition
        for facts in snapshot.components
        for port in facts.ports
        if port.definition
    }
