"""Makes the classes of standard data types, each when it is first asked for.

Type checkers and editors read the stubs beside the modules of these types, which
``tools/make_standard_types.py`` writes.

See decision 50.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from enum import Enum
from importlib import import_module
from threading import RLock
from typing import Any

from rtkit.component.standard import FAMILIES, StandardType, declared_in, find
from rtkit.component.types import BASIC_TYPES, Char, WChar
from rtkit.component.values.typenames import register
from rtkit.fast_dataclass import make_dataclass

_DEFAULTS = {"Mat44": tuple(tuple(float(row == column) for column in range(4)) for row in range(4))}
"""Defaults of types whose default is not everything zero: no shift and no turn."""
_making = RLock()  # else two threads might get two classes for one type


def family(module: str) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """Return ``__all__``, ``__getattr__`` and ``__dir__`` of a module of standard data types."""
    home = module.rpartition(".")[2]
    own = {name: each for name, each in declared_in(home).items() if each.home == home}
    present = vars(sys.modules[module])

    def get(name: str) -> Any:
        if name not in own:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        with _making:
            if name not in present:
                present[name] = _made(module, name, own[name])
            return present[name]

    return list(own), get, lambda: sorted({*present, *own})


def _made(module: str, name: str, declared: StandardType) -> Any:
    """Return the class of a type, or the annotation that a type definition stands for."""
    scope = FAMILIES[module.rpartition(".")[2]]
    if declared.kind == "typedef":
        return next(_fields(scope, declared.body))[1]
    if declared.kind == "enum":
        members = declared.body.replace(",", " ").split()
        make_enum: Callable[..., Any] = Enum
        made = make_enum(name, {each: at for at, each in enumerate(members)}, module=module)
        made.__doc__ = declared.doc
    else:
        fields = _fields(scope, declared.body)
        made = make_dataclass(name, fields, module=module, doc=declared.doc)
    register(made, f"{scope}::{name}")
    return made


def _fields(scope: str, body: str) -> Iterator[tuple[str, Any, Any]]:
    """Yield name, annotation and default of each member that a text declares."""
    for line in filter(None, map(str.strip, body.split(";"))):
        head, *others = line.split(",")
        kind, _, first = head.rpartition(" ")
        hint = _hint(scope, kind)
        for each in (first, *others):
            name, _, size = each.strip("] \n").partition("[")
            full = tuple[(hint,) * int(size)] if size else hint  # type: ignore[misc]
            yield name, full, _DEFAULTS[kind] if kind in _DEFAULTS else _zero(full)


def _hint(scope: str, kind: str) -> Any:
    if kind.startswith("sequence<"):
        item = kind[len("sequence<") : -1]
        return bytes if item == "octet" else tuple[_hint(scope, item), ...]  # type: ignore[misc]
    if kind in BASIC_TYPES:
        return BASIC_TYPES[kind]
    outer, _, name = kind.rpartition("::")
    declared = find(outer or scope, name)
    assert declared is not None, kind
    return getattr(import_module(f"{__package__}.{declared.home}"), name)


def _zero(hint: Any) -> Any:
    """Return the value of an annotation with everything zero or empty."""
    if hint is Char or hint is WChar:
        return "\0"
    base = getattr(hint, "__origin__", hint)
    if base is tuple and hint.__args__[-1] is not Ellipsis:
        return (_zero(hint.__args__[0]),) * len(hint.__args__)
    return next(iter(base)) if issubclass(base, Enum) else base()
