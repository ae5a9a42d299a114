"""Annotations: the Python names of IDL types, and the zero values of those types.

Names of the module under construction have a ``§`` before them. Other modules replace that mark
by the prefix under which they import the module.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from rtkit.builder import standard_types
from rtkit.builder.identifiers import Taken
from rtkit.builder.obstacles import CARRIED, of_type, resolved
from rtkit.builder.source_text import INDENT
from rtkit.idl.model import (
    ArrayOf,
    Basic,
    Definitions,
    EnumDeclaration,
    Named,
    Path,
    SequenceOf,
    Type,
)

OWN = "§"
_SPELT_OUT = 8
_LONGEST = 64
_ZEROS = {
    "boolean": "False",
    "char": '"\\0"',
    "double": "0.0",
    "float": "0.0",
    "string": '""',
    "wchar": '"\\0"',
    "wstring": '""',
}
_WORD = re.compile(r"\w+")
_IMPORTED = ("Annotated", "Enum", "Final", "Int8", "Protocol", "TYPE_CHECKING", "dataclass")


class Zero(NamedTuple):
    """A value with nothing in it: code, and whether it makes an object."""

    code: str
    is_made: bool = False

    @property
    def default(self) -> str:
        """The code of a field's default."""
        if not self.is_made:
            return self.code
        made = self.code.removesuffix("()")
        plain = made.replace(".", "").isidentifier()
        return f"field(default_factory={made if plain else f'lambda: {self.code}'})"


class Annotations:
    """The names of a module.

    Attributes:
        names: By path.
        uses: Names that the code so far needs to import.
        pending: Blocks of code that have to come before what is annotated now.
    """

    def __init__(self, definitions: Definitions, order: Sequence[Path]) -> None:
        self._definitions = definitions
        self._taken = Taken([*_IMPORTED, "field", "images", "rt", "shared"])
        self._arrays: dict[str, str] = {}
        self.names = {path: self._name(path) for path in order}
        self.uses: set[str] = set()
        self.pending: list[list[str]] = []

    def _name(self, path: Path) -> str:
        is_free = path[-1] not in self._taken or len(path) == 1
        return self._taken.add(path[-1] if is_free else "".join(path[-2:]))

    def new_name(self, preferred: str) -> str:
        """Return a name of the module that is free, and take it."""
        return self._taken.add(preferred)

    @property
    def all(self) -> frozenset[str]:
        """Every name that means something in the module."""
        return self._taken.all

    def of(self, type: Type) -> str:
        """Return the annotation of a type."""
        if isinstance(type, Basic):
            return self._used(CARRIED[type.name])
        if isinstance(type, Named):
            known = standard_types.expression(type.path)
            return self._used(known) if known else f"{OWN}{self.names[type.path]}"
        if isinstance(type, SequenceOf):
            if resolved(self._definitions, type.item) == Basic("octet"):
                return "bytes"
            return f"tuple[{self.of(type.item)}, ...]"
        return self._array(type)

    def of_any(self, type: Type) -> str:
        """Return the annotation of a type that is not carried, so that it may be anything."""
        return "object" if of_type(self._definitions, type) else self.of(type)

    def _used(self, code: str) -> str:
        self.uses.add("Annotated" if code.startswith(OWN) else code.partition(".")[0])
        if code.startswith(OWN) and "Int8" not in self._arrays:
            self._arrays["Int8"] = "Int8"
            self.pending.append(['Int8 = Annotated[int, "int8"]'])
        return code

    def _array(self, type: ArrayOf) -> str:
        item, count = self.of(type.item), 1
        for size in type.sizes:
            count *= size
        if count <= _SPELT_OUT:
            spelt = item
            for size in reversed(type.sizes):
                spelt = f"tuple[{', '.join([spelt] * size)}]"
            if len(spelt) <= _LONGEST:
                return spelt
        key = f"{item}{type.sizes}"
        if key not in self._arrays:
            self._arrays[key] = self._long_array(item, type.sizes)
        return f"{OWN}{self._arrays[key]}"

    def _long_array(self, item: str, sizes: tuple[int, ...]) -> str:
        """Give an array a name, because its items written out would be unreadable."""
        word = next(each for each in _WORD.findall(item) if each not in ("tuple", "rt", "images"))
        stem = word[0].upper() + word[1:] + "Seq" * item.count("...")
        name = self.new_name(stem + "x".join(map(str, sizes)))
        loose = exact = item.replace(OWN, "")
        for size in reversed(sizes):
            loose, exact = f"tuple[{loose}, ...]", f"tuple[({exact},) * {size}]"
        self.uses.add("TYPE_CHECKING")
        self.pending.append(
            ["if TYPE_CHECKING:", f"{INDENT}{name} = {loose}", "else:", f"{INDENT}{name} = {exact}"]
        )
        return name

    def zero(self, type: Type) -> Zero:
        """Return the value of a type with nothing in it."""
        bare = resolved(self._definitions, type)
        if isinstance(bare, Basic):
            return Zero(_ZEROS.get(bare.name, "0"))
        if isinstance(bare, SequenceOf):
            is_bytes = resolved(self._definitions, bare.item) == Basic("octet")
            return Zero('b""' if is_bytes else "()")
        if isinstance(bare, ArrayOf):
            code, is_made = self.zero(bare.item)
            for size in reversed(bare.sizes):
                code = f"({code},) * {size}" if size > 1 else f"({code},)"
            return Zero(code.replace("() *", "(()) *"), is_made)
        return self._zero_of_name(bare.path)

    def _zero_of_name(self, path: Path) -> Zero:
        known = standard_types.expression(path)
        if known:
            member = standard_types.first_member(path)
            return Zero(f"{self._used(known)}.{member}") if member else Zero(f"{known}()", True)
        declared = self._definitions.by_path[path]
        if isinstance(declared, EnumDeclaration):
            return Zero(f"{self.names[path]}.{member_names(declared)[0]}")
        return Zero(f"{self.names[path]}()", True)


def member_names(declared: EnumDeclaration) -> list[str]:
    """Return the names of an enumeration's members in Python."""
    taken = Taken(["mro", "name", "value"])
    return [taken.add(member) for member in declared.members]
