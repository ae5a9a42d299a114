"""Finds the members of an object that become properties, and their kind; never private ones.

Nothing of the object is called or changed here but what reading its properties takes.
Source: `property-service` reference, section 8.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
import sys
from collections.abc import Mapping, MutableMapping
from enum import Enum
from types import MappingProxyType, MemberDescriptorType, ModuleType
from typing import Any, NamedTuple

from rtkit.property.annotations import bare, hints_of, is_final, returned, taken
from rtkit.property.conversion import has_element, is_array
from rtkit.property.presenting import Gui, is_presentation
from rtkit.property.values import Element

_ACCESSOR = re.compile(r"(get|set)(?:_(.+)|([A-Z].*))")
_PLAIN_MAPPINGS = (dict, MappingProxyType)
_PLAIN = (bool, int, float, str, bytes, bytearray, Enum, type(None), list, tuple, set, frozenset,
          Element)  # fmt: skip


class Member(NamedTuple):
    """Member of an object.

    Attributes:
        kind: ``attribute``, ``accessors``, ``method`` or ``gui``.
        getter: The name of the method that reads it, of accessors.
        setter: The name of the method that writes it, of accessors.
        is_plain: Reading it takes no user code.
    """

    name: str
    kind: str
    access: str = "rw"
    hint: Any = None
    doc: str = ""
    getter: str = ""
    setter: str = ""
    is_plain: bool = False


def members(thing: object, hidden: frozenset[str] = frozenset()) -> list[Member]:
    """Return what of an object may be seen, in the order in which it was written."""
    cls = type(thing)
    if isinstance(thing, Mapping):
        keys = [key for key in thing if isinstance(key, str) and is_public(key, hidden)]
        access = "rw" if isinstance(thing, MutableMapping) else "r"
        is_plain = type(thing) in _PLAIN_MAPPINGS
        return [Member(key, "attribute", access, is_plain=is_plain) for key in keys]
    hints, docs = hints_of(cls), _documented(cls)
    found: dict[str, Member] = {}
    accessors: dict[str, dict[str, str]] = {}
    for name in _names(thing, cls, hints):
        if not is_public(name, hidden):
            continue
        static = inspect.getattr_static(thing, name, None)
        if inspect.isroutine(static) and name in getattr(thing, "__dict__", ()):
            continue  # a function that the object was given, not one that it offers
        if _is_method(static):
            accessor = _accessor(cls, name, static)
            if is_presentation(name) and bare(returned(static)) is Gui:
                found[name] = Member(name, "gui")
            elif accessor:
                accessors.setdefault(accessor[1], {})[accessor[0]] = name
            else:
                doc = inspect.getdoc(static) or ""
                found[name] = Member(name, "method", doc=_first_line(doc))
        elif isinstance(static, Gui):
            found[name] = Member(name, "gui")
        elif _is_shown(static):
            hint, access, doc = _declared(cls, name, static, hints)
            is_plain = _is_plain(thing, name, static)
            doc = doc or docs.get(name, "")
            found[name] = Member(name, "attribute", access, hint, doc, is_plain=is_plain)
    for name, pair in accessors.items():
        if name not in found and is_public(name, hidden):
            found[name] = _with_accessors(cls, name, pair)
        else:
            for method in pair.values():
                found[method] = Member(method, "method")
    return list(found.values())


def is_public(name: str, hidden: frozenset[str]) -> bool:
    """Return whether a name may be seen."""
    return bool(name) and not name.startswith("_") and name not in hidden


def _names(thing: object, cls: type, hints: Mapping[str, Any]) -> list[str]:
    own = list(getattr(thing, "__dict__", ()))
    of_classes = [
        name for base in reversed(cls.__mro__) if base is not object for name in vars(base)
    ]
    return list(dict.fromkeys([*of_classes, *hints, *own]))


def _is_method(static: object) -> bool:
    if isinstance(static, staticmethod | classmethod):
        return True
    return inspect.isroutine(static) and not inspect.isdatadescriptor(static)


def _is_plain(thing: object, name: str, static: object) -> bool:
    """Return whether an attribute can be read without a call of what its class defines."""
    if type(thing).__getattribute__ is not object.__getattribute__:
        return False
    if isinstance(static, property):
        return static.fget is not None and _of_library(static.fget)
    if inspect.isdatadescriptor(static):
        return isinstance(static, MemberDescriptorType) or _is_read_only(static)
    is_own = name in getattr(thing, "__dict__", ())
    return is_own or not hasattr(type(static), "__get__")


def _is_shown(static: object) -> bool:
    return not (inspect.isclass(static) or isinstance(static, ModuleType)) and not (
        callable(static) and not hasattr(type(static), "__get__")
    )


def _accessor(cls: type, name: str, static: object) -> tuple[str, str] | None:
    """Return ``get`` or ``set`` and the property meant, if a method is such."""
    match = _ACCESSOR.fullmatch(name)
    if match is None:
        return None
    function = static.__func__ if isinstance(static, staticmethod | classmethod) else static
    if _of_library(function):
        return None  # get_nowait of a queue takes something out of it
    own = 0 if isinstance(static, staticmethod) else 1
    try:
        parameters = list(inspect.signature(function).parameters.values())[own:]  # type: ignore[arg-type]
    except (ValueError, TypeError):
        return None
    needed = [each for each in parameters if each.default is each.empty
              and each.kind not in (each.VAR_POSITIONAL, each.VAR_KEYWORD)]  # fmt: skip
    if len(needed) != (match[1] == "set"):
        return None
    return match[1], match[2] or match[3][0].lower() + match[3][1:]


def _of_library(function: object) -> bool:
    """Return whether a function comes with Python: its names follow no convention of getters."""
    module = getattr(function, "__module__", None) or "builtins"
    return module.partition(".")[0] in sys.stdlib_module_names


def _with_accessors(cls: type, name: str, pair: dict[str, str]) -> Member:
    getter, setter = pair.get("get", ""), pair.get("set", "")
    access = "r" * bool(getter) + "w" * bool(setter)
    chosen = getattr(cls, getter or setter, None)
    doc = _first_line(inspect.getdoc(chosen) or "")
    hint = returned(chosen) if getter else taken(chosen)
    return Member(name, "accessors", access, hint, doc, getter, setter)


def _declared(
    cls: type, name: str, static: object, hints: Mapping[str, Any]
) -> tuple[Any, str, str]:
    """Return annotation, access and doc string of an attribute."""
    if isinstance(static, property):
        access = "r" * (static.fget is not None) + "w" * (static.fset is not None)
        return returned(static.fget), access, _first_line(inspect.getdoc(static) or "")
    hint = hints.get(name)
    params = getattr(cls, "__dataclass_params__", None)
    is_fixed = is_final(hint) or (params is not None and params.frozen)
    if inspect.isdatadescriptor(static):
        # Slots and members of classes in C can be set or not; only they know.
        is_fixed = is_fixed or not hasattr(type(static), "__set__") or _is_read_only(static)
    elif issubclass(cls, tuple) or (not hasattr(static, "__dict__") and _is_slotless(cls, name)):
        is_fixed = True
    return hint, "r" if is_fixed else "rw", ""


def _is_read_only(static: object) -> bool:
    return type(static).__name__ == "_tuplegetter"


def _is_slotless(cls: type, name: str) -> bool:
    """Return whether instances have no place of their own for an attribute of the class."""
    return not any("__dict__" in vars(base) for base in cls.__mro__) and any(
        name in vars(base) for base in cls.__mro__
    )


def is_nested(value: object) -> bool:
    """Return whether an object is to be shown by its own members rather than as a value.

    Objects of the standard library that are no data (locks, loggers, files) never are.
    """
    if type(value) in _PLAIN:
        return False
    if isinstance(value, Mapping):
        return all(isinstance(key, str) for key in value)
    if is_data(value) or callable(value):
        return False
    if dataclasses.is_dataclass(value):
        return True
    module = type(value).__module__.partition(".")[0]
    return module not in sys.stdlib_module_names and module != "builtins"


def is_data(value: object) -> bool:
    """Return whether an object that is not nested can be shown as a value."""
    if isinstance(value, _PLAIN) or is_array(value) or has_element(value):
        return True
    return type(value).__module__ in ("datetime", "decimal", "fractions", "pathlib", "uuid")


def _first_line(doc: str) -> str:
    return " ".join(doc.strip().partition("\n\n")[0].split())


def _documented(cls: type) -> dict[str, str]:
    """Return the texts of the section ``Attributes:`` of a doc string, by name."""
    lines = iter((inspect.getdoc(cls) or "").splitlines())
    found: dict[str, str] = {}
    for line in lines:
        if line.strip() == "Attributes:":
            break
    last = ""
    for line in lines:
        entry = re.match(r" {4}(\w+)(?: \([^)]*\))?: *(.*)", line)
        if entry:
            last = entry[1]
            found[last] = entry[2]
        elif line.startswith("     ") and last:
            found[last] += f" {line.strip()}"
        else:
            break
    return found


__all__ = ["Member", "bare", "is_data", "is_nested", "is_public", "members"]
