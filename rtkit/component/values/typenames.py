"""Registry of data types: maps their names to classes."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from importlib import import_module
from typing import TypeVar, get_type_hints

from rtkit.component.standard import SCOPES, home_of
from rtkit.errors import Malformed
from rtkit.rtc.data_types import ANY, scoped_name

C = TypeVar("C", bound=type)
_by_name: dict[str, type] = {}
_by_class: dict[type, str] = {bytes: ANY}
_by_version: dict[tuple[str, str], type] = {}
_OF_FILES = ("__main__", "rtkit_module_")
"""How the names of modules begin that a program ran, or a manager loaded, as files."""


def register(cls: type, name: str) -> None:
    """Make a class known under a name, any of its forms."""
    give_name(cls, name)
    _by_name[scoped_name(name)] = cls


def give_name(cls: type, name: str) -> None:
    """Name a class, without making it the class of that name: there may be several."""
    scoped = scoped_name(name)
    if not scoped:
        raise Malformed(f"a data type needs a name: {name!r}")
    _by_class[cls] = f"IDL:{scoped.replace('::', '/')}:1.0"


def shared(name: str, version: str) -> Callable[[C], C]:
    """Have all modules of this process that define a type of an IDL use one class for it.

    It is what the first of them defines. Generated code has this for each structure, enumeration
    and exception, so that components which know a type from modules of their own can compare
    values of it.

    Args:
        name: Of the type, ``Robot::Mode``.
        version: Stands for what the type consists of: another one makes another class.
    """

    def choose(cls: C) -> C:
        one: C = _by_version.setdefault((scoped_name(name), version), cls)  # type: ignore[assignment]
        if one is cls and hasattr(cls, "__dataclass_fields__"):
            # It may outlive its module, in which its annotations would be looked up later.
            cls.__annotations__ = get_type_hints(cls, include_extras=True)
        if not issubclass(one, BaseException):
            register(one, name)
        return one

    return choose


def type_name(cls: type) -> str:
    """Return the name of a data type; that of an unregistered class is its module and name."""
    known = _by_class.get(cls)
    if known is None:
        name = cls.__qualname__.rpartition("<locals>.")[2].replace(".", "_")
        register(cls, f"{_scope(cls.__module__)}::{name}")
        known = _by_class[cls]
    return known


def _scope(module: str) -> str:
    """Return the name of a module as IDL may have it; that of its file, where it was run as one.

    So a type has the same name wherever that file is, and however it is run.
    """
    name = module.rpartition(".")[2]
    if name.startswith(_OF_FILES):
        file = getattr(sys.modules.get(module), "__file__", None) or ""
        name = file.rpartition("/")[2][:-3] if file.endswith(".py") else name.strip("_")
    return re.sub(r"[^A-Za-z0-9]", "_", name).lstrip("_0123456789") or "main"


def is_standard(text: str) -> bool:
    """Return whether the name is that of a standard data type."""
    scope, _, name = scoped_name(text).rpartition("::")
    return bool(home_of(scope, name))


def type_by_name(text: str) -> type | None:
    """Return the class registered under that name; None when there is none.

    The types of the standard are imported when they are first asked for.
    """
    scoped = scoped_name(text)
    name = scoped.rpartition("::")[2]
    for scope in SCOPES:
        home = home_of(scope, name) if scoped in (name, f"{scope}::{name}") else ""
        if home:
            found: type = getattr(import_module(f"rtkit.component.{home}"), name)
            return found
    known = _by_name.get(scoped)
    if known is None and "::" not in scoped:
        matches = {cls for full, cls in _by_name.items() if full.rpartition("::")[2] == scoped}
        known = matches.pop() if len(matches) == 1 else None
    return known
