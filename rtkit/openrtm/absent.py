"""Names of OpenRTM-aist that rtkit does not have: they say so when they are called."""

from __future__ import annotations

from typing import Any


class NotSupported(AttributeError, NotImplementedError):
    """A part of OpenRTM-aist was used that rtkit does not have; `hasattr` may ask for it."""


def refuse(name: str) -> NotSupported:
    """Return the error that names what is absent."""
    return NotSupported(f"{name} of OpenRTM-aist is not supported by rtkit")


class _AbsentType(type):
    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return absent(f"{cls.__doc__}.{name}")

    def __call__(cls, *arguments: Any, **named: Any) -> Any:
        owner = next(each for each in cls.__mro__ if "is_absent" in vars(each))
        raise refuse(str(owner.__doc__))


def absent(name: str) -> Any:
    """Return a class of that name, which may be named and derived from, but not called."""
    return _AbsentType(name.rpartition(".")[2], (), {"__doc__": name, "is_absent": True})


def is_absent(found: Any) -> bool:
    """Return whether something stands for a name that is absent."""
    return isinstance(found, _AbsentType) and "is_absent" in vars(found)
