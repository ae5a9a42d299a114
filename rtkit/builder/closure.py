"""Computes the closure of IDL declarations: those wanted and all that they depend on."""

from __future__ import annotations

from collections.abc import Iterable

from rtkit.builder.standard_types import KNOWN
from rtkit.idl.model import (
    ArrayOf,
    Constant,
    Definitions,
    EnumValue,
    InterfaceDeclaration,
    Named,
    Path,
    SequenceOf,
    StructDeclaration,
    Type,
    Typedef,
)


def closure(definitions: Definitions, wanted: Iterable[Path]) -> list[Path]:
    """Return the paths of all that `wanted` consists of, in the order of the text.

    Constants beside or inside an interface go with it.
    """
    found: set[Path] = set()
    for path in wanted:
        _add(definitions, path, found)
    near = {
        path[:-1] for path in found if isinstance(definitions.by_path[path], InterfaceDeclaration)
    }
    near |= {path for path in found if isinstance(definitions.by_path[path], InterfaceDeclaration)}
    for path, declared in definitions.by_path.items():
        if isinstance(declared, Constant) and path[:-1] in near:
            _add(definitions, path, found)
    return [path for path in definitions.by_path if path in found]


def _add(definitions: Definitions, path: Path, found: set[Path]) -> None:
    declared = definitions.by_path.get(path)
    if declared is None or path in found or path in KNOWN:
        return
    found.add(path)
    types: list[Type] = []
    if isinstance(declared, StructDeclaration):
        types = [each.type for each in declared.fields]
    elif isinstance(declared, Typedef):
        types = [declared.type]
    elif isinstance(declared, Constant) and isinstance(declared.value, EnumValue):
        types = [Named(declared.value.path)]
    elif isinstance(declared, InterfaceDeclaration):
        types = _types_of(declared)
    for type in types:
        for each in _names(type):
            _add(definitions, each, found)


def _types_of(interface: InterfaceDeclaration) -> list[Type]:
    types: list[Type] = [Named(base) for base in interface.bases]
    types += [each.type for each in interface.attributes]
    for operation in interface.operations:
        types += [each.type for each in operation.parameters]
        types += [operation.result] if operation.result is not None else []
        types += [Named(path) for path in operation.raises]
    return types


def _names(type: Type) -> list[Path]:
    while isinstance(type, (SequenceOf, ArrayOf)):
        type = type.item
    return [type.path] if isinstance(type, Named) else []
