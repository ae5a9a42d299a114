"""Exceptions of CORBA: those that IDL files declare, and those of the system."""

from __future__ import annotations

from typing import Any, ClassVar

from rtkit.openrtm.corba.enumerations import EnumItem


class CorbaException(Exception):
    """Base of all exceptions of CORBA."""


class UserException(CorbaException):
    """Base of exceptions that IDL files declare: members by position or by name."""

    field_names: ClassVar[tuple[str, ...]] = ()

    def __init__(self, *values: Any, **named: Any) -> None:
        members = {**dict(zip(self.field_names, values, strict=False)), **named}
        if len(values) > len(self.field_names) or members.keys() != set(self.field_names):
            wanted = ", ".join(self.field_names)
            raise TypeError(f"{type(self).__name__} takes {wanted or 'nothing'}")
        super().__init__(*values)
        vars(self).update(members)


COMPLETED = {
    name: EnumItem(name, number, "IDL:omg.org/CORBA/completion_status:1.0")
    for number, name in enumerate(("COMPLETED_YES", "COMPLETED_NO", "COMPLETED_MAYBE"))
}
"""The values of ``CORBA::completion_status``."""


class SystemException(CorbaException):
    """Base of exceptions that any operation may raise.

    Attributes:
        minor: A number that tells more.
        completed: Whether the operation was done.
    """

    def __init__(
        self, minor: int = 0, completed: Any = COMPLETED["COMPLETED_NO"], why: str = ""
    ) -> None:
        super().__init__(minor, completed, *filter(None, [why]))
        self.minor = minor
        self.completed = completed


_SYSTEM = """
UNKNOWN BAD_PARAM NO_MEMORY IMP_LIMIT COMM_FAILURE INV_OBJREF NO_PERMISSION INTERNAL MARSHAL
INITIALIZE NO_IMPLEMENT BAD_TYPECODE BAD_OPERATION NO_RESOURCES NO_RESPONSE PERSIST_STORE
BAD_INV_ORDER TRANSIENT FREE_MEM INV_IDENT INV_FLAG INTF_REPOS BAD_CONTEXT OBJ_ADAPTER
DATA_CONVERSION OBJECT_NOT_EXIST TIMEOUT
"""
SYSTEM_EXCEPTIONS: dict[str, type[SystemException]] = {
    name: type(name, (SystemException,), {"__module__": "CORBA"}) for name in _SYSTEM.split()
}
"""The exceptions of the system, by name."""
