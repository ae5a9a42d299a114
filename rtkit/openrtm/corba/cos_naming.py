"""Names of the module ``CosNaming``: how objects are found by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from rtkit.openrtm.corba.enumerations import EnumItem, ItemsOfEnum
from rtkit.openrtm.corba.exceptions import UserException
from rtkit.openrtm.corba.records import Record
from rtkit.openrtm.corba.references import Reference

_ID = "IDL:omg.org/CosNaming"


class NameComponent(Record):
    """One element of a name: ``ConsoleIn0`` of kind ``rtc``."""

    field_names = ("id", "kind")
    _NP_RepositoryId = f"{_ID}/NameComponent:1.0"


class Binding(Record):
    """A name in a context, and whether a further context has it."""

    field_names = ("binding_name", "binding_type")
    _NP_RepositoryId = f"{_ID}/Binding:1.0"


class NameNotFound(UserException):
    """Nothing has a name, from its element `rest_of_name` on."""

    field_names = ("why", "rest_of_name")


class NamingContext(Reference):
    """A place that has names."""

    NotFound: ClassVar[Any] = NameNotFound


class Names:
    """The names that components take from ``CosNaming``."""

    BindingType = ItemsOfEnum(
        f"{_ID}/BindingType:1.0",
        [EnumItem(n, i, f"{_ID}/BindingType:1.0") for i, n in enumerate(("nobject", "ncontext"))],
    )
    nobject, ncontext = BindingType._items  # noqa: SLF001
    NameComponent = NameComponent
    Binding = Binding
    NamingContext = NamingContextExt = NamingContext


def to_name(text: str) -> list[NameComponent]:
    """Return the elements of ``robot.host_cxt/ConsoleIn0.rtc``."""
    pairs = (each.rpartition(".") for each in text.split("/") if each)
    return [NameComponent(id, kind) if dot else NameComponent(kind, "") for id, dot, kind in pairs]


def to_text(name: Sequence[Any]) -> str:
    """Return a name as text."""
    return "/".join(f"{each.id}.{each.kind}" if each.kind else str(each.id) for each in name)
