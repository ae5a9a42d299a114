"""Classes of interfaces, servants and exceptions that IDL files declare."""

from __future__ import annotations

from typing import Any, ClassVar

from rtkit.component.defined import DefinedTypes
from rtkit.idl.model import Definitions, InterfaceDeclaration, StructDeclaration
from rtkit.openrtm.exceptions import UserException


class ObjectReference:
    """Base of the classes that stand for interfaces, and of references to objects that have them.

    Attributes:
        declared: The interface; `definitions` and `types` are those of its files.
    """

    declared: ClassVar[InterfaceDeclaration]
    definitions: ClassVar[Definitions]
    types: ClassVar[DefinedTypes]
    _NP_RepositoryId: ClassVar[str] = "IDL:omg.org/CORBA/Object:1.0"
    _nil: ClassVar[None] = None


class Servant:
    """Base of servants: objects of components that do the operations of an interface."""

    declared: ClassVar[InterfaceDeclaration]
    definitions: ClassVar[Definitions]
    types: ClassVar[DefinedTypes]
    _NP_RepositoryId: ClassVar[str] = "IDL:omg.org/CORBA/Object:1.0"

    def _this(self) -> Any:
        return self

    def _default_POA(self) -> Any:
        from rtkit.openrtm.manager import ObjectAdapter

        return ObjectAdapter()


def interface_class(
    declared: InterfaceDeclaration,
    bases: tuple[type, ...],
    definitions: Definitions,
    types: DefinedTypes,
) -> type:
    """Return the class that stands for an interface: consumers and narrowing name it."""
    return _made(declared, bases or (ObjectReference,), definitions, types)


def servant_class(
    declared: InterfaceDeclaration,
    bases: tuple[type, ...],
    definitions: Definitions,
    types: DefinedTypes,
) -> type:
    """Return the class that servants of an interface derive from."""
    return _made(declared, bases or (Servant,), definitions, types)


def _made(
    declared: InterfaceDeclaration,
    bases: tuple[type, ...],
    definitions: Definitions,
    types: DefinedTypes,
) -> type:
    body = {
        "declared": declared,
        "definitions": definitions,
        "types": types,
        "__doc__": declared.doc,
        "_NP_RepositoryId": f"IDL:{'/'.join(declared.path)}:1.0",
    }
    return type(declared.path[-1], bases, body)


def exception_class(
    declared: StructDeclaration, definitions: Definitions, types: DefinedTypes
) -> type:
    """Return the class of an exception: its constructor takes all members in their order."""
    names = tuple(each.name for each in declared.fields)
    body = {
        "field_names": names,
        "declared": declared,
        "types": types,
        "_NP_RepositoryId": f"IDL:{'/'.join(declared.path)}:1.0",
    }
    return type(declared.path[-1], (UserException,), body)
