"""Makes what Python code sees of IDL declarations: structures, enumerations, constants, interfaces.

Structures are the mutable twins of frozen data types that all folders of a process share.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from threading import RLock
from typing import Any

from rtkit.builder.standard_types import KNOWN
from rtkit.component.values.defined import DefinedTypes
from rtkit.component.values.type_layout import layout_of_hint
from rtkit.component.values.typenames import is_standard, type_by_name
from rtkit.errors import Malformed
from rtkit.idl.model import (
    Constant,
    Definitions,
    EnumDeclaration,
    EnumValue,
    InterfaceDeclaration,
    Named,
    Path,
    StructDeclaration,
    Typedef,
)
from rtkit.openrtm.corba.definition_files import ReadDefinitions, read_all
from rtkit.openrtm.corba.services import exception_class, interface_class, servant_class
from rtkit.openrtm.corba.twins import AliasOf, twin_of


class Declarations:
    """The declarations of several IDL files as omniORB's modules have them."""

    def __init__(self, folder: str, files: Iterable[str], read: Any) -> None:
        self._folder = folder
        self._files = list(files)
        self._read = read
        self._made: dict[tuple[str, Path], Any] = {}
        self._making = RLock()

    def names(self, scope: Path) -> list[str]:
        """Return the names that a scope has; an enumeration's members stand beside it."""
        found = []
        for path, declared in self.definitions.by_path.items():
            if path[:-1] == scope:
                found.append(path[-1])
                if isinstance(declared, EnumDeclaration):
                    found += declared.members
        inner = {
            path[len(scope)]
            for path in self.definitions.by_path
            if len(path) > len(scope) + 1 and path[: len(scope)] == scope
        }
        return list(dict.fromkeys([*found, *inner]))

    def value(self, path: Path) -> Any:
        """Return what a name of a module stands for.

        Raises:
            KeyError: Nothing declares it.
        """
        return self._once("value", path)

    def servant(self, path: Path) -> Any:
        """Return the base class of the servants of an interface.

        Raises:
            KeyError: No interface is called so.
        """
        return self._once("servant", path)

    def _once(self, kind: str, path: Path) -> Any:
        with self._making:  # two threads that ask at once get one class
            if (kind, path) not in self._made:
                make = self._servant if kind == "servant" else self._value
                self._made[kind, path] = make(path)
            return self._made[kind, path]

    def _servant(self, path: Path) -> Any:
        declared = self.definitions.by_path.get(path)
        if not isinstance(declared, InterfaceDeclaration):
            return self._scope(path, is_servants=True)
        bases = tuple(self.servant(each) for each in declared.bases)
        return servant_class(declared, bases, self)

    def _value(self, path: Path) -> Any:
        declared = self.definitions.by_path.get(path)
        if declared is None or (path in KNOWN and is_standard("::".join(path))):
            return self._standard(path)
        if isinstance(declared, Constant):
            held = declared.value
            return self.value((*held.path[:-1], held.name)) if isinstance(held, EnumValue) else held
        if isinstance(declared, Typedef):
            if isinstance(declared.type, Named):
                return self.value(declared.type.path)
            hint = self.types.hint(declared.type)
            return AliasOf(declared.name, layout_of_hint(hint, declared.name))
        if isinstance(declared, InterfaceDeclaration):
            bases = tuple(self.value(each) for each in declared.bases)
            made = interface_class(declared, bases, self)
            for name in self.names(path):
                setattr(made, name, self.value((*path, name)))
            return made
        if isinstance(declared, StructDeclaration) and declared.is_exception:
            return exception_class(declared)
        made = self.types.of(declared.path)
        if not isinstance(made, type):
            raise Malformed(f"{declared.name} is no structure")
        return twin_of(made)

    def _standard(self, path: Path) -> Any:
        """Return a standard type, a member of an enumeration, or an inner module."""
        if is_standard("::".join(path)):
            cls = type_by_name("::".join(path))
            assert cls is not None
            return twin_of(cls)
        for declared in self.definitions.by_path.values():
            if (
                isinstance(declared, EnumDeclaration)
                and declared.path[:-1] == path[:-1]
                and path[-1] in declared.members
            ):
                items = self.value(declared.path)._items  # noqa: SLF001
                return items[declared.members.index(path[-1])]
        return self._scope(path, is_servants=False)

    def _scope(self, path: Path, *, is_servants: bool) -> Any:
        from rtkit.openrtm.corba.lazy_module import LazyModule

        if not any(each[: len(path)] == path for each in self.definitions.by_path):
            failures = self._declared.failures
            if failures:
                raise AttributeError(f"{'.'.join(path)} is not there: {'; '.join(failures)}")
            raise KeyError(path[-1])
        find = self.servant if is_servants else self.value
        return LazyModule(".".join(path), lambda n: find((*path, n)), lambda: self.names(path))

    @cached_property
    def types(self) -> DefinedTypes:
        """The classes of data types: one for all files that declare a type alike."""
        return DefinedTypes(self.definitions, are_shared=True)

    @property
    def definitions(self) -> Definitions:
        """All declarations; those of a file that cannot be read are missed where they are used."""
        return self._declared.definitions

    @cached_property
    def _declared(self) -> ReadDefinitions:
        return read_all(self._folder, self._files, self._read)
