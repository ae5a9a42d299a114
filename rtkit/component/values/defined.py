"""Creates classes of data types from the IDL definitions that ports and recordings give."""

from __future__ import annotations

import keyword
import re
from collections.abc import Sequence
from enum import Enum
from functools import cache
from math import prod
from typing import Any

from rtkit.component.types import BASIC_TYPES
from rtkit.component.values.definition import idl_of
from rtkit.component.values.type_layout import layout_of, layout_of_hint, zero
from rtkit.component.values.typenames import give_name, is_standard, shared, type_by_name
from rtkit.errors import Malformed, RtkitError
from rtkit.fast_dataclass import make_dataclass
from rtkit.idl.model import (
    ArrayOf,
    Basic,
    Definitions,
    EnumDeclaration,
    Named,
    Opaque,
    Path,
    SequenceOf,
    StructDeclaration,
    Type,
    Typedef,
)
from rtkit.rtc.data_types import scoped_name

_MOST_ITEMS = 1 << 20
"""Greatest number of items of an array: rubbish could ask for all the memory."""
UNFIT = (TypeError, ValueError, RecursionError)
"""Errors of classes that cannot be made, since rubbish defines them."""
_HIDDEN = ("mro", "name", "value")
"""Names that members of a Python enumeration cannot have, or would hide."""


def class_of(name: str, definition: str) -> type:
    """Return the class of a data type that a definition has; the same one each time.

    Raises:
        Malformed: The definition cannot be read, or has no such type, or one of no fixed form.
    """
    return _class_of(scoped_name(name), definition)


@cache
def _class_of(name: str, definition: str) -> type:
    from rtkit.idl.read import read_idl  # what was read already does without

    definitions = read_idl(definition, name)
    try:
        made: type = class_in(definitions, name)
        layout_of(made)
    except UNFIT as error:
        raise Malformed(f"{name} cannot be made of its definition: {error}") from error
    return made


def is_same_definition(name: str, one: str, other: str) -> bool:
    """Return whether values of a type have one form by both definitions; so too where one lacks."""
    if not one or not other or one == other:
        return True
    try:
        texts = {re.sub(r"\s*//.*", "", idl_of(class_of(name, each))) for each in (one, other)}
    except RtkitError:
        return True  # it cannot be said
    return len(texts) == 1


def class_in(definitions: Definitions, name: str) -> Any:
    """Return the class of a data type of definitions that were read.

    Raises:
        Malformed: There is no such type, or one of no fixed form.
    """
    return DefinedTypes(definitions).of(tuple(scoped_name(name).split("::")))


class DefinedTypes:
    """Makes classes of the declarations of one text.

    Args:
        definitions: The declarations.
        are_shared: Whether a type that others in this process know, too, is their class.
    """

    def __init__(self, definitions: Definitions, *, are_shared: bool = False) -> None:
        self._definitions = definitions
        self._are_shared = are_shared
        self._made: dict[Path, Any] = {}
        self._sizes: dict[Path, int] = {}

    def of(self, path: Path) -> Any:
        """Return the annotation of a declaration."""
        name = "::".join(path)
        known = type_by_name(name) if is_standard(name) else self._made.get(path)
        if known is not None:
            return known
        declared = self._definitions.by_path.get(path)
        if isinstance(declared, Typedef):
            return self.hint(declared.type)
        if isinstance(declared, StructDeclaration):
            made = self._struct(declared)
        elif isinstance(declared, EnumDeclaration):
            members = [(_free(each, _HIDDEN), n) for each, n in declared.numbers.items()]
            made = Enum(path[-1], members)  # type: ignore[misc, no-redef]
        else:
            kind = f" but a {declared.kind}" if isinstance(declared, Opaque) else ""
            raise Malformed(f"{name} is no structure{kind} in its definition")
        give_name(made, name)
        if self._are_shared:
            made = shared(name, idl_of(made))(made)
        self._made[path] = made
        return made

    def _struct(self, declared: StructDeclaration) -> type:
        fields = []
        for each in declared.fields:
            own = _free(each.name)
            hint = self.hint(each.type)
            fields.append((own, hint, zero(layout_of_hint(hint, each.name))))
        return make_dataclass(declared.path[-1], fields, module=__name__, doc=_doc(declared))

    def hint(self, type: Type) -> Any:
        """Return the annotation of a type."""
        if isinstance(type, Named):
            return self.of(type.path)
        if isinstance(type, SequenceOf):
            item = type.item
            return bytes if item == Basic("octet") else tuple[self.hint(item), ...]  # type: ignore[misc]
        if isinstance(type, ArrayOf):
            if self._size(type) > _MOST_ITEMS:
                raise Malformed(f"an array has more than {_MOST_ITEMS} items")
            hint = self.hint(type.item)
            for size in reversed(type.sizes):
                hint = tuple[(hint,) * size]  # type: ignore[misc]
            return hint
        if type.name not in BASIC_TYPES:
            raise Malformed(f"{type.name} cannot be carried")
        return BASIC_TYPES[type.name]

    def _size(self, type: Type) -> int:
        """Return how many items a value has at least, with those of structures inside."""
        if isinstance(type, ArrayOf):
            return prod(type.sizes) * self._size(type.item)
        declared = self._definitions.by_path.get(type.path) if isinstance(type, Named) else None
        if isinstance(declared, Typedef):
            return self._size(declared.type)
        if not isinstance(declared, StructDeclaration):
            return 1
        if declared.path not in self._sizes:
            self._sizes[declared.path] = sum(self._size(each.type) for each in declared.fields)
        return self._sizes[declared.path]


def _free(name: str, hidden: Sequence[str] = ()) -> str:
    return f"{name}_" if name in hidden or keyword.iskeyword(name) else name


def _doc(declared: StructDeclaration) -> str:
    """Return the docstring of a structure, with what is said of its fields."""
    lines = [declared.doc or declared.path[-1]]
    described = [each for each in declared.fields if each.doc]
    lines += ["\nAttributes:"] * bool(described)
    lines += [f"    {_free(each.name)}: {' '.join(each.doc.split())}" for each in described]
    return "\n".join(lines)
