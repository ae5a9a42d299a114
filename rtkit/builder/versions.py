"""Computes versions of IDL types: short digests of the members that a type consists of."""

from __future__ import annotations

from hashlib import sha256

from rtkit.idl.model import (
    ArrayOf,
    Basic,
    Definitions,
    EnumDeclaration,
    Named,
    Path,
    SequenceOf,
    StructDeclaration,
    Type,
    Typedef,
)

_FORM = "1"
"""Counts up when classes of the same content are generated in another form."""
_LENGTH = 12


def version_of(definitions: Definitions, path: Path) -> str:
    """Return the version of a structure, an enumeration or an exception.

    It changes with names and types of members, also of structures inside, not with comments, places
    or the names of type definitions.
    """
    text = f"{_FORM} {_content(definitions, path, ())}"
    return sha256(text.encode()).hexdigest()[:_LENGTH]


def _content(definitions: Definitions, path: Path, outer: tuple[Path, ...]) -> str:
    declared = definitions.by_path.get(path)
    name, within = "::".join(path), (*outer, path)
    if isinstance(declared, StructDeclaration) and path not in outer:
        inner = (f"{each.name}:{_type(definitions, each.type, within)}" for each in declared.fields)
        return f"{name}{{{';'.join(inner)}}}"
    if isinstance(declared, EnumDeclaration):
        return f"{name}{{{','.join(declared.members)}}}"
    if isinstance(declared, Typedef):
        return _type(definitions, declared.type, within)
    return name  # a type of the standard


def _type(definitions: Definitions, type: Type, outer: tuple[Path, ...]) -> str:
    if isinstance(type, Named):
        return _content(definitions, type.path, outer)
    if isinstance(type, ArrayOf):
        return f"{_type(definitions, type.item, outer)}{list(type.sizes)}"
    if isinstance(type, SequenceOf):
        return f"sequence<{_type(definitions, type.item, outer)},{type.bound}>"
    assert isinstance(type, Basic)
    return type.name
