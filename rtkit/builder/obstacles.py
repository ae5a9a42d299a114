"""Finds the IDL declarations that rtkit cannot carry, and tells the reason for each."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, get_origin

from rtkit.builder.standard_types import KNOWN
from rtkit.component import types
from rtkit.idl.model import (
    ArrayOf,
    Basic,
    BasicKind,
    Constant,
    Declaration,
    Definitions,
    EnumDeclaration,
    InterfaceDeclaration,
    Named,
    Opaque,
    Operation,
    Path,
    SequenceOf,
    StructDeclaration,
    Type,
    Typedef,
)

_NAMES = {kind: name for name, kind in vars(types).items() if get_origin(kind) is Annotated}
CARRIED = {
    word: f"rt.{_NAMES[kind]}" if kind in _NAMES else kind.__name__
    for word, kind in types.BASIC_TYPES.items()
} | {"int8": "§Int8"}
"""How code names each type of the language that can be carried; ``§`` is our own module."""

_LARGEST_ARRAY = 10_000


def of_type(definitions: Definitions, type: Type, inside: tuple[Path, ...] = ()) -> str:
    """Return why a type cannot be carried; empty when it can."""
    if isinstance(type, Basic):
        return "" if type.name in CARRIED else f"{type.name} has no form in CDR here"
    if isinstance(type, SequenceOf):
        return of_type(definitions, type.item, inside)
    if isinstance(type, ArrayOf):
        count = 1
        for size in type.sizes:
            count *= size
        if count > _LARGEST_ARRAY:
            return f"an array of {count} items is too large"
        return of_type(definitions, type.item, inside)
    return _of_name(definitions, type.path, inside)


def _of_name(definitions: Definitions, path: Path, inside: tuple[Path, ...]) -> str:
    if path in KNOWN:
        return ""
    name, declared = "::".join(path), definitions.by_path.get(path)
    if path in inside:
        return f"{name} contains itself"
    if isinstance(declared, Typedef):
        return of_type(definitions, declared.type, (*inside, path))
    if isinstance(declared, EnumDeclaration):
        return ""
    if isinstance(declared, StructDeclaration) and not declared.is_exception:
        if not declared.fields:
            return f"{name} has no members"
        reasons = (of_type(definitions, each.type, (*inside, path)) for each in declared.fields)
        return next(filter(None, reasons), "")
    if isinstance(declared, InterfaceDeclaration):
        return f"{name} is an interface, to which no reference is passed"
    if isinstance(declared, Opaque) and declared.kind is not BasicKind.MISSING:
        return f"{name} is a {declared.kind.value}"
    absent = ", ".join(definitions.missing)
    return f"{name} is not defined" + (f" ({absent} not found)" if absent else "")


def of_interface(definitions: Definitions, interface: InterfaceDeclaration) -> str:
    """Return why an interface cannot be called; empty when it can."""
    is_empty = True
    for each in _lineage(definitions, interface, set()):
        if isinstance(each, str):
            return f"{each} is not defined"
        for operation in each.operations:
            is_empty = False
            reason = _of_operation(definitions, operation)
            if reason:
                return f"operation {operation.name}: {reason}"
        for attribute in each.attributes:
            is_empty = False
            reason = of_type(definitions, attribute.type)
            if reason:
                return f"attribute {attribute.name}: {reason}"
    return "it has no operations" if is_empty else ""


def _of_operation(definitions: Definitions, operation: Operation) -> str:
    types = [each.type for each in operation.parameters]
    if operation.result is not None:
        types.append(operation.result)
    return next(filter(None, (of_type(definitions, each) for each in types)), "")


def _lineage(
    definitions: Definitions, interface: InterfaceDeclaration, seen: set[Path]
) -> Iterator[InterfaceDeclaration | str]:
    """Yield the bases of an interface, the farthest first, then itself.

    A base without definition is yielded as its name; those `seen` already are passed over.
    """
    seen.add(interface.path)
    for path in interface.bases:
        base = definitions.by_path.get(path)
        if not isinstance(base, InterfaceDeclaration):
            yield "::".join(path)
        elif path not in seen:
            yield from _lineage(definitions, base, seen)
    yield interface


def resolved(definitions: Definitions, type: Type) -> Type:
    """Return a type without further names for it."""
    while isinstance(type, Named):
        declared = definitions.by_path.get(type.path)
        if type.path in KNOWN or not isinstance(declared, Typedef):
            break
        type = declared.type
    return type


def obstacle(definitions: Definitions, declared: Declaration) -> str:
    """Return why a declaration has no form in Python; empty when it has one."""
    if isinstance(declared, InterfaceDeclaration):
        return of_interface(definitions, declared)
    if isinstance(declared, Constant) or (
        isinstance(declared, StructDeclaration) and declared.is_exception
    ):
        return ""
    if isinstance(declared, Typedef):
        return of_type(definitions, declared.type)
    return of_type(definitions, Named(declared.path))
