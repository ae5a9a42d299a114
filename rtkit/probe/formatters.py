"""Formatters: functions of one argument that make text of a value, named on the command line."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from rtkit.errors import Malformed, NotFound, Refused

RAW = "rawpy"


def formatter(name: str) -> Callable[[Any], str]:
    """Return the function that ``rawpy`` or ``MODULE.NAME`` stands for.

    The function raises Refused when the user's one fails.

    Raises:
        NotFound: There is no such module.
        Malformed: Nothing of that name in it can be called.
    """
    if name == RAW:
        return repr
    module, dot, attribute = name.rpartition(".")
    if not dot:
        raise Malformed(f"Bad formatter: {name} (it is {RAW} or MODULE.NAME)")
    try:
        found = getattr(import_module(module), attribute, None)
    except Exception as error:
        raise NotFound(f"Error importing formatter: {name}: {error}") from error
    if not callable(found):
        raise Malformed(f"Bad formatter: {name}")

    def show(value: Any) -> str:
        try:
            return str(found(value))
        except Exception as error:
            raise Refused(f"formatter {name} failed: {type(error).__name__}: {error}") from error

    return show
