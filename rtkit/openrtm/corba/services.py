"""Classes of interfaces, servants and exceptions that IDL files declare."""

from __future__ import annotations

from typing import Any, ClassVar

from rtkit.idl.model import InterfaceDeclaration, StructDeclaration
from rtkit.openrtm.corba.exceptions import UserException
from rtkit.openrtm.corba.object_broker import ObjectAdapter


class Declared:
    """Base of classes that are made of the declaration of an interface.

    Attributes:
        declared: The interface.
        declarations: All that the files declare where it stands (`rtkit.openrtm.corba.declared`).
    """

    declared: ClassVar[InterfaceDeclaration]
    declarations: ClassVar[Any]
    _NP_RepositoryId: ClassVar[str] = "IDL:omg.org/CORBA/Object:1.0"


class ObjectReference(Declared):
    """Base of the classes of interfaces, and of references to objects that have them."""

    _nil: ClassVar[None] = None

    def _narrow(self, kind: type) -> Any:
        return self if isinstance(self, kind) else None

    def _is_a(self, repository_id: str) -> bool:
        return any(
            repository_id == vars(each).get("_NP_RepositoryId") for each in type(self).__mro__
        )

    def _is_equivalent(self, other: object) -> bool:
        return self is other

    def _non_existent(self) -> bool:
        return False


class Servant(Declared):
    """Base of servants: objects of components that do the operations of an interface."""

    def _this(self) -> Any:
        return self

    def _narrow(self, kind: Any) -> Any:
        return self

    def _default_POA(self) -> Any:
        return ObjectAdapter()


def interface_class(
    declared: InterfaceDeclaration, bases: tuple[type, ...], declarations: Any
) -> type:
    """Return the class that stands for an interface: consumers and narrowing name it."""
    return _made(declared, bases or (ObjectReference,), declarations)


def servant_class(
    declared: InterfaceDeclaration, bases: tuple[type, ...], declarations: Any
) -> type:
    """Return the class that servants of an interface derive from."""
    return _made(declared, bases or (Servant,), declarations)


def _made(declared: InterfaceDeclaration, bases: tuple[type, ...], declarations: Any) -> type:
    body = {
        "declared": declared,
        "declarations": declarations,
        "__doc__": declared.doc,
        "_NP_RepositoryId": f"IDL:{'/'.join(declared.path)}:1.0",
    }
    return type(declared.path[-1], bases, body)


def exception_class(declared: StructDeclaration) -> type:
    """Return the class of an exception: its constructor takes all members in their order."""
    body = {
        "field_names": tuple(each.name for each in declared.fields),
        "_NP_RepositoryId": f"IDL:{'/'.join(declared.path)}:1.0",
    }
    return type(declared.path[-1], (UserException,), body)
