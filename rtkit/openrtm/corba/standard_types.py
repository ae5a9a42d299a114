"""Names of the module ``RTC``: standard data types, enumerations and records of the RTC model."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from rtkit.component.standard import declared_in, find, names_of
from rtkit.component.values.type_layout import layout_of_hint
from rtkit.component.values.typenames import type_by_name
from rtkit.openrtm.corba.enumerations import ENUMERATIONS, ITEMS
from rtkit.openrtm.corba.twins import AliasOf, descriptor_of, twin_of

_FAMILIES = ("timed", "geometry", "extended", "sensors", "actuators", "navigation")
_DESCRIPTOR = "_d_"
_RECORDS = (
    "ComponentProfile", "ConnectorProfile", "ExecutionContextProfile", "PortInterfaceProfile",
    "PortProfile",
)  # fmt: skip
_OBJECTS = (
    "DataFlowComponent", "ExecutionContext", "ExecutionContextService", "PortService", "RTObject",
)  # fmt: skip


def rtc_value(name: str) -> Any:
    """Return what a name of the module ``RTC`` stands for.

    Raises:
        KeyError: The standard has none of that name.
    """
    if name in ITEMS:
        return ITEMS[name]
    if name in ENUMERATIONS:
        return ENUMERATIONS[name]
    if name in _RECORDS:
        from rtkit.openrtm.corba import records

        return getattr(records, name)
    if name in _OBJECTS:
        from rtkit.openrtm.corba import references

        return getattr(references, name)
    if name.startswith(_DESCRIPTOR):
        return descriptor_of(rtc_value(name.removeprefix(_DESCRIPTOR)))
    declared = find("RTC", name)
    if declared is None:
        return _member(name)
    if declared.kind == "typedef":
        home = import_module(f"rtkit.component.{declared.home}")
        return AliasOf(name, layout_of_hint(getattr(home, name), name))
    cls = type_by_name(f"RTC::{name}")
    assert cls is not None, name
    return twin_of(cls)


def _member(name: str) -> Any:
    """Return the item of that name of a standard enumeration."""
    for family in _FAMILIES:
        for each, declared in declared_in(family).items():
            if declared.kind == "enum" and name in declared.body.replace(",", " ").split():
                items = rtc_value(each)._items  # noqa: SLF001
                return next(item for item in items if str(item) == name)
    raise KeyError(name)


def rtc_names() -> list[str]:
    """Return all names that ``from RTC import *`` gives."""
    return [*ITEMS, *ENUMERATIONS, *_RECORDS, *_OBJECTS, *names_of("RTC")]
