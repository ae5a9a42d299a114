"""Records of the RTC and SDO models that components make and read: all fields by position."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rtkit.openrtm.corba.twins import StructBase


class Record(StructBase):
    """Base of records: a constructor with all fields in order, also by name."""

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    def __init__(self, *values: Any, **named: Any) -> None:
        given = {**dict(zip(self.field_names, values, strict=False)), **named}
        if len(values) > len(self.field_names) or given.keys() != set(self.field_names):
            wanted = ", ".join(self.field_names)
            raise TypeError(f"{type(self).__name__} takes {wanted}")
        vars(self).update(given)


class NameValue(Record):
    """A name and a value of any kind."""

    field_names = ("name", "value")
    _NP_RepositoryId = "IDL:org.omg/SDOPackage/NameValue:1.0"


class ConnectorProfile(Record):
    """A connector between ports."""

    field_names = ("name", "connector_id", "ports", "properties")
    _NP_RepositoryId = "IDL:omg.org/RTC/ConnectorProfile:1.0"


class PortInterfaceProfile(Record):
    """An interface of a service port."""

    field_names = ("instance_name", "type_name", "polarity")
    _NP_RepositoryId = "IDL:omg.org/RTC/PortInterfaceProfile:1.0"


class PortProfile(Record):
    """A port as others see it."""

    field_names = ("name", "interfaces", "port_ref", "connector_profiles", "owner", "properties")
    _NP_RepositoryId = "IDL:omg.org/RTC/PortProfile:1.0"


class ComponentProfile(Record):
    """A component as others see it."""

    field_names = (
        "instance_name", "type_name", "description", "version", "vendor", "category",
        "port_profiles", "parent", "properties",
    )  # fmt: skip
    _NP_RepositoryId = "IDL:omg.org/RTC/ComponentProfile:1.0"


class ExecutionContextProfile(Record):
    """An execution context as others see it."""

    field_names = ("kind", "rate", "owner", "participants", "properties")
    _NP_RepositoryId = "IDL:omg.org/RTC/ExecutionContextProfile:1.0"


def name_values(texts: dict[str, str]) -> list[NameValue]:
    """Return properties as a list of names and values."""
    return [NameValue(name, text) for name, text in texts.items()]
