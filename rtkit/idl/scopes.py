"""Scopes of IDL: records declared names and resolves names in the text."""

from __future__ import annotations

from collections.abc import Container, Iterator
from typing import NamedTuple

from rtkit.idl.model import BasicKind, Declaration, Opaque, Path, SourceLine, Value
from rtkit.idl.source import InvalidIdl


class ResolvedName(NamedTuple):
    """Meaning of a name: a declaration's path, or the value of a constant."""

    path: Path
    value: Value | None = None


class Scopes:
    """All names so far.

    Attributes:
        declarations: By path, in the order of the text.
        values: Constants and members of enumerations.
    """

    def __init__(self, known: Container[Path]) -> None:
        self._known = known
        self._modules: set[Path] = set()
        self._bases: dict[Path, tuple[Path, ...]] = {}
        self.declarations: dict[Path, Declaration] = {}
        self.values: dict[Path, Value] = {}

    def open_module(self, path: Path, place: SourceLine) -> None:
        """Begin a module, or go on with it."""
        if path in self.declarations:
            raise _twice(path, place, self.declarations[path])
        self._modules.add(path)

    def inherit(self, path: Path, bases: tuple[Path, ...]) -> None:
        """Let the names of its bases be known inside an interface."""
        self._bases[path] = bases

    def declare(self, declared: Declaration) -> None:
        """Add a declaration; one that was only announced is replaced.

        Raises:
            InvalidIdl: The name is taken.
        """
        path = declared.path
        known = self.declarations.get(path)
        if is_forward(declared) and known is not None:
            return
        if known is not None and not is_forward(known):
            raise _twice(path, declared.place, known)
        if path in self._modules or path in self.values:
            raise InvalidIdl(f"{declared.place}: {declared.name} is used already")
        # Behind what its own members declared: in the order of its end, where it is complete.
        self.declarations.pop(path, None)
        self.declarations[path] = declared

    def define(self, path: Path, value: Value, place: SourceLine) -> None:
        """Give a name a value.

        Raises:
            InvalidIdl: The name is taken.
        """
        if path in self.values:
            raise InvalidIdl(f"{place}: {'::'.join(path)} is used already")
        self.values[path] = value

    def find(self, name: Path, scope: Path, *, is_absolute: bool) -> ResolvedName | None:
        """Return the meaning of a name inside `scope`, None when it has none."""
        for outer in [()] if is_absolute else _outwards(scope):
            for place in self._inheritance(outer):
                path = (*place, *name)
                if path in self.values:
                    return ResolvedName(path, self.values[path])
                if path in self.declarations or path in self._known:
                    return ResolvedName(path)
                inherited = self._member(path)
                if inherited is not None:
                    return inherited
        return None

    def _member(self, path: Path) -> ResolvedName | None:
        """Return the meaning of a qualified name where a base of the interface defines it."""
        for base in list(self._inheritance(path[:-1]))[1:]:
            inner = (*base, path[-1])
            if inner in self.declarations or inner in self.values:
                return ResolvedName(inner, self.values.get(inner))
        return None

    def _inheritance(self, scope: Path) -> Iterator[Path]:
        yield scope
        for base in self._bases.get(scope, ()):
            yield from self._inheritance(base)


def is_forward(declared: Declaration) -> bool:
    """Return whether a declaration only announces a name."""
    return isinstance(declared, Opaque) and declared.kind is BasicKind.FORWARD


def _outwards(scope: Path) -> Iterator[Path]:
    for length in range(len(scope), -1, -1):
        yield scope[:length]


def _twice(path: Path, place: SourceLine, known: Declaration) -> InvalidIdl:
    return InvalidIdl(f"{place}: {'::'.join(path)} is declared already ({known.place})")
