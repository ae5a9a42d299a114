"""The names of CORBA that components use beside OpenRTM's own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from rtkit.openrtm.absent import absent
from rtkit.openrtm.corba import exceptions
from rtkit.openrtm.corba.object_broker import ObjectRequestBroker, ORB_init


def is_nil(reference: Any) -> bool:
    """Return whether a reference refers to nothing."""
    return reference is None


def corba_name(name: str) -> Any:
    """Return a name of the module ``CORBA``."""
    if name in exceptions.SYSTEM_EXCEPTIONS:
        return exceptions.SYSTEM_EXCEPTIONS[name]
    if name in exceptions.COMPLETED:
        return exceptions.COMPLETED[name]
    if name in ("TRUE", "FALSE"):
        return int(name == "TRUE")
    known = {
        "Exception": exceptions.CorbaException,
        "SystemException": exceptions.SystemException,
        "UserException": exceptions.UserException,
        "is_nil": is_nil,
        "ORB": ObjectRequestBroker,
        "ORB_ID": "omniORB4",
        "ORB_init": ORB_init,
    }
    return known.get(name) or absent(f"CORBA.{name}")


def _as_it_is(value: Any, *_: Any) -> Any:
    return value  # an ``any`` of CORBA is the value itself


def omniorb_name(name: str) -> Any:
    """Return a name of the module ``omniORB``."""
    from rtkit.openrtm.corba import enumerations, twins

    known = {
        "EnumItem": enumerations.EnumItem,
        "StructBase": twins.StructBase,
        "any": SimpleNamespace(to_any=_as_it_is, from_any=_as_it_is),
    }
    return known.get(name) or absent(f"omniORB.{name}")


def portable_server_name(name: str) -> Any:
    """Return a name of the module ``PortableServer``."""
    if name == "Servant":
        from rtkit.openrtm.corba.services import Servant

        return Servant
    return absent(f"PortableServer.{name}")


def sdo_name(name: str) -> Any:
    """Return a name of the module ``SDOPackage``."""
    if name == "NameValue":
        from rtkit.openrtm.corba.records import NameValue

        return NameValue
    return absent(f"SDOPackage.{name}")


def openrtm_name(name: str) -> Any:
    """Return a name of the module ``OpenRTM``."""
    if name in ("DataFlowComponent", "ExtTrigExecutionContextService"):
        from rtkit.openrtm.corba import references

        return getattr(references, name.removeprefix("ExtTrig"))
    return absent(f"OpenRTM.{name}")


def naming_name(name: str) -> Any:
    """Return a name of the module ``CosNaming``."""
    from rtkit.openrtm.corba import cos_naming

    return vars(cos_naming.Names).get(name) or absent(f"CosNaming.{name}")
