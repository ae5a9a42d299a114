"""Refuses names of component classes that the base class needs for something else.

A name that hides another shows late or never: rtkit itself calls `leave`, and reads `ports`.
Callbacks and the settings of a class (``vendor``, ``rate`` …) are there to be overridden.
"""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from typing import Any

from rtkit.component.configuration.parameter import Parameter
from rtkit.component.ports.any_port import Port
from rtkit.component.services.service import ServicePort
from rtkit.errors import Refused

_HOME = "rtkit.component."


def refuse_collisions(cls: type, own_attributes: Collection[str]) -> None:
    """Refuse a class that names something of its own like an attribute of every component.

    Args:
        cls: A class that is being defined; its bases have been looked at already.
        own_attributes: Names of the attributes that the base class keeps on each instance.

    Raises:
        Refused: It does; one sentence with file, line, name and what it collides with.
    """
    ours = tuple(base for base in cls.__mro__ if base.__module__.startswith(_HOME))
    needed = _needed(ours)
    for name, value in _own(cls, ours):
        owner = needed.get(name)
        if owner is None and name in own_attributes:
            owner = ours[0]
        if owner is not None and not _may_override(name, value, vars(owner).get(name)):
            raise Refused(_sentence(cls, name, _kind(value), f"{owner.__name__}.{name}", value))
        for operation in value.own_operations if isinstance(value, ServicePort) else ():
            owner = needed.get(operation)
            if owner is not None:
                what = f"operation {operation}, of port"
                raise Refused(_sentence(cls, name, what, f"{owner.__name__}.{operation}", value))


@cache
def _needed(ours: tuple[type, ...]) -> Mapping[str, type]:
    """Return the class that needs each name, the nearest one."""
    return {
        name: base
        for base in reversed(ours)
        for name in vars(base)
        if not (name.startswith("__") and name.endswith("__"))
    }


def _own(cls: type, ours: Collection[type]) -> Iterator[tuple[str, Any]]:
    """Yield what a class has of its own, and what it gets from bases that are no components."""
    for base in cls.__mro__:
        is_mixin = base is not object and not any(issubclass(base, each) for each in ours)
        if base is cls or (is_mixin and base not in ours):
            yield from vars(base).items()


def _may_override(name: str, value: Any, ours: Any) -> bool:
    if isinstance(value, (Port, Parameter)):
        return isinstance(ours, (Port, Parameter))  # it declares the inherited one anew
    if name.startswith("_"):
        return False
    if name.startswith("on_"):
        return callable(value)
    is_setting = ours is not None and not callable(ours) and not hasattr(ours, "__get__")
    return is_setting and not callable(value) and not hasattr(value, "__get__")


def _kind(value: Any) -> str:
    if isinstance(value, (Port, Parameter)):
        return "port" if isinstance(value, Port) else "parameter"
    return "method" if callable(value) else "attribute"


def _sentence(cls: type, name: str, what: str, other: str, value: Any) -> str:
    file, line = _place(cls, name, value)
    if what.startswith("operation"):
        help = "implementation=… names an object of its own that does it"
    elif isinstance(value, (Port, Parameter)):
        help = f"write {name}_ = …, the name for others stays {name}"
    else:
        help = "give it another name"
    where = f"{file}:{line}: {what} {name} of {cls.__name__}"
    return f"{where} collides with {other}, which rtkit itself uses: {help}"


def _place(cls: type, name: str, value: Any) -> tuple[str, int]:
    """Return file and line of a declaration; else those of its class."""
    code = getattr(getattr(value, "fget", value), "__code__", None)
    if code is not None:
        return _plain(code.co_filename), code.co_firstlineno
    frame = sys._getframe()  # noqa: SLF001 - as `inspect` and `warnings` find their callers
    while frame.f_back is not None and frame.f_globals["__name__"].startswith(_HOME):
        frame = frame.f_back
    file, line = frame.f_code.co_filename, frame.f_lineno
    return _plain(file), next(_assigned(file, cls.__name__, name), line)


def _plain(file: str) -> str:
    return file.rpartition("/")[2]


def _assigned(file: str, class_name: str, name: str) -> Iterator[int]:
    import ast
    import linecache

    try:
        tree = ast.parse("".join(linecache.getlines(file)))
    except (SyntaxError, ValueError):
        return
    for each in ast.walk(tree):
        if isinstance(each, ast.ClassDef) and each.name == class_name:
            for line in each.body:
                targets = getattr(line, "targets", [getattr(line, "target", None)])
                if any(isinstance(t, ast.Name) and t.id == name for t in targets):
                    yield line.lineno
