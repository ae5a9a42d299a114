"""Model of IDL declarations as plain data: every name resolved, every constant computed.

A path is a scoped name in parts: ``("SimpleService", "MyService")``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

Path = tuple[str, ...]


class SourceLine(NamedTuple):
    """A line of a file."""

    file: str
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


class Direction(StrEnum):
    """Direction of a parameter."""

    IN = "in"
    OUT = "out"
    INOUT = "inout"


class BasicKind(StrEnum):
    """Kind of a declaration known by name only; none of these can be carried as a value."""

    UNION = "union"
    VALUETYPE = "valuetype"
    NATIVE = "native"
    FORWARD = "forward declaration"
    MISSING = "name that nothing defines"
    BROKER = "type of the CORBA broker itself"


class Basic(NamedTuple):
    """A type of the language itself: ``long``, ``unsigned short``, ``string``."""

    name: str


class Named(NamedTuple):
    """A type by its full name."""

    path: Path


class SequenceOf(NamedTuple):
    """A sequence; without `bound` of any length."""

    item: Type
    bound: int | None = None


class ArrayOf(NamedTuple):
    """An array with the size of each dimension, the outer one first."""

    item: Type
    sizes: tuple[int, ...]


Type = Basic | Named | SequenceOf | ArrayOf


class EnumValue(NamedTuple):
    """A member of an enumeration, as the value of a constant."""

    path: Path
    name: str


Value = bool | int | float | str | EnumValue


class Field(NamedTuple):
    """A member of a structure or an exception."""

    name: str
    type: Type
    doc: str = ""


@dataclass(frozen=True, slots=True)
class Declaration:
    """Base of all declarations.

    Attributes:
        doc: The comment before it, or behind it on its line, without the marks of comments.
    """

    path: Path
    place: SourceLine
    doc: str = field(default="", kw_only=True)

    @property
    def name(self) -> str:
        """The full name, ``SimpleService::MyService``."""
        return "::".join(self.path)


@dataclass(frozen=True, slots=True)
class StructDeclaration(Declaration):
    """A structure, or an exception."""

    fields: tuple[Field, ...]
    is_exception: bool = False


@dataclass(frozen=True, slots=True)
class EnumDeclaration(Declaration):
    """An enumeration.

    Attributes:
        values: The number of each member, where annotations say others than 0, 1, 2…
    """

    members: tuple[str, ...]
    values: tuple[int, ...] = ()

    @property
    def numbers(self) -> dict[str, int]:
        """The number of each member."""
        return dict(zip(self.members, self.values or range(len(self.members)), strict=True))


@dataclass(frozen=True, slots=True)
class Typedef(Declaration):
    """Another name for a type."""

    type: Type


@dataclass(frozen=True, slots=True)
class Constant(Declaration):
    """A constant with its value."""

    type: Type
    value: Value


@dataclass(frozen=True, slots=True)
class Opaque(Declaration):
    """A declaration that is known by name only."""

    kind: BasicKind


class OperationParameter(NamedTuple):
    """A parameter of an operation."""

    direction: Direction
    name: str
    type: Type


class Operation(NamedTuple):
    """An operation of an interface; `result` is None for ``void``."""

    name: str
    result: Type | None
    parameters: tuple[OperationParameter, ...] = ()
    raises: tuple[Path, ...] = ()
    doc: str = ""


class Attribute(NamedTuple):
    """An attribute of an interface."""

    name: str
    type: Type
    is_readonly: bool = False
    doc: str = ""


@dataclass(frozen=True, slots=True)
class InterfaceDeclaration(Declaration):
    """An interface; inherited operations are in its bases only."""

    bases: tuple[Path, ...] = ()
    operations: tuple[Operation, ...] = ()
    attributes: tuple[Attribute, ...] = ()


@dataclass(frozen=True, slots=True)
class Definitions:
    """All that a file and those that it includes declare.

    Attributes:
        by_path: Every declaration, in the order of the text.
        missing: Included files that were not found, as they are written.
    """

    by_path: Mapping[Path, Declaration]
    missing: tuple[str, ...] = ()

    def find(self, name: str) -> Declaration | None:
        """Return the declaration of that full name, ``SimpleService::MyService``."""
        return self.by_path.get(tuple(part for part in name.split("::") if part))

    def interface(self, name: str) -> InterfaceDeclaration | None:
        """Return the interface of that full name."""
        found = self.find(name)
        return found if isinstance(found, InterfaceDeclaration) else None
