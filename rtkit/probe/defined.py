"""Creates classes of data types from the IDL definitions that ports and recordings give."""

from __future__ import annotations

import keyword
from enum import Enum
from functools import cache
from typing import Any

from rtkit.component.type_layout import layout_of_hint, zero
from rtkit.component.typenames import is_standard, register, type_by_name
from rtkit.component.types import BASIC_TYPES
from rtkit.errors import Malformed
from rtkit.fast_dataclass import make_dataclass
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
from rtkit.idl.read import read_idl
from rtkit.rtc.data_types import scoped_name


@cache
def class_of(name: str, definition: str) -> type:
    """Return the class of a data type that a definition has; the same one each time.

    Raises:
        Malformed: The definition cannot be read, or has no such type, or one of no fixed form.
    """
    definitions = read_idl(definition, name)
    made: type = _Maker(definitions).of(tuple(scoped_name(name).split("::")))
    return made


class _Maker:
    """Makes classes of the declarations of one text."""

    def __init__(self, definitions: Definitions) -> None:
        self._definitions = definitions
        self._made: dict[Path, type] = {}

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
            made = Enum(path[-1], declared.numbers)  # type: ignore[misc, no-redef]
        else:
            raise Malformed(f"{name} is no structure in its definition")
        register(made, name)
        self._made[path] = made
        return made

    def _struct(self, declared: StructDeclaration) -> type:
        fields = []
        for each in declared.fields:
            own = f"{each.name}_" if keyword.iskeyword(each.name) else each.name
            hint = self.hint(each.type)
            fields.append((own, hint, zero(layout_of_hint(hint, each.name))))
        return make_dataclass(declared.path[-1], fields, module=__name__, doc=declared.doc)

    def hint(self, type: Type) -> Any:
        """Return the annotation of a type."""
        if isinstance(type, Named):
            return self.of(type.path)
        if isinstance(type, SequenceOf):
            item = type.item
            return bytes if item == Basic("octet") else tuple[self.hint(item), ...]  # type: ignore[misc]
        if isinstance(type, ArrayOf):
            hint = self.hint(type.item)
            for size in reversed(type.sizes):
                hint = tuple[(hint,) * size]  # type: ignore[misc]
            return hint
        if type.name not in BASIC_TYPES:
            raise Malformed(f"{type.name} cannot be carried")
        return BASIC_TYPES[type.name]
