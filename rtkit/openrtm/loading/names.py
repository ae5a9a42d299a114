"""Modules that every component written for OpenRTM-aist may import, and where their names are."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

from rtkit.openrtm.absent import absent
from rtkit.openrtm.client_modules import CLIENTS, client_module
from rtkit.openrtm.corba.lazy_module import LazyModule

_ROOM = "rtkit.openrtm"
_HOME = {
    "api.component_listeners": """
        ConfigurationParamListener ConfigurationParamListenerType ConfigurationSetListener
        ConfigurationSetListenerType ConfigurationSetNameListener ConfigurationSetNameListenerType
        PostComponentActionListener PostComponentActionListenerType PreComponentActionListener
        PreComponentActionListenerType
    """,
    "api.composites": "PeriodicECOrganization PeriodicECSharedComposite addCallback setCallback",
    "api.connector_listeners": """
        ConnectorDataListener ConnectorDataListenerT ConnectorDataListenerType ConnectorInfo
        ConnectorListener ConnectorListenerStatus ConnectorListenerType
    """,
    "csp.manager": "CSPManager",
    "csp.ports": "CSPInPort CSPOutPort",
    "api.clock": "Time TimeMeasure TimeValue setTimestamp",
    "api.logger": "Logger",
    "api.manager": "Delete Manager",
    "api.parameters": "ConfigAdmin",
    "api.ports": "DataPortStatus InPort OutPort PortBase PortType toTypename",
    "api.properties": "Properties",
    "api.ring_buffer": "BufferStatus RingBuffer",
    "api.service_ports": "CorbaConsumer CorbaPort",
    "api.rtobject": "DataFlowComponentBase RTObject_impl",
    "api.string_util": """
        eraseBlank eraseBothEndsBlank eraseHeadBlank eraseTailBlank escape flatten includes
        isAbsolutePath isEscaped isURL normalize otos parseArgs replaceEnv replaceString split
        stringTo stringToStrVec toArgv toBool unescape unique_sv urlparam2map
    """,
    "api.tasks": """
        Async_ref_t Async_ref_tInvoker Async_t Async_tInvoker PeriodicTask ScopedLock Task
    """,
    "corba.twins": "instantiateDataType",
}
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names.split()}
_SUBMODULES = {
    "CSPEventPort": "csp.events",
    "CSPMachine": "csp.events",
    "CORBA_SeqUtil": "api.sequence_util",
    "EventPort": "api.event_port",
    "EventPort_pyfsm": "api.event_port",
    "NVUtil": "api.name_values",
    "StaticFSM": "api.static_fsm",
    "StaticFSM_pyfsm": "api.static_fsm",
    "StringUtil": "api.string_util",
}
_RENAMED = {"instantiateDataType": "default_of"}
_OF_OMNIORB = ("CORBA", "PortableServer")
_CORBA = {
    "omniORB.CORBA": "corba_name",
    "omniORB.PortableServer": "portable_server_name",
    "CORBA": "corba_name",
    "PortableServer": "portable_server_name",
    "SDOPackage": "sdo_name",
    "SDOPackage__POA": "sdo_name",
    "OpenRTM": "openrtm_name",
    "OpenRTM__POA": "openrtm_name",
    "CosNaming": "naming_name",
}
"""Function of `rtkit.openrtm.corba.names` that finds the names of each module."""


_OWN_FILES = (
    *("BasicDataType", "ComponentObserver", "DataPort", "ExtendedDataTypes"),
    *("InterfaceDataTypes", "OpenRTM", "RTC", "SDOPackage"),
)
"""IDL files of OpenRTM itself whose names are in `RTC`, `OpenRTM` and `SDOPackage`."""


def own_stub(name: str) -> ModuleType | None:
    """Return a module such as ``BasicDataType_idl``, which brings no names; None for others."""
    file = name.removesuffix("_idl").removesuffix("_OpenRTM")
    return ModuleType(name) if name.endswith("_idl") and file in _OWN_FILES else None


@cache
def shared_module(name: str) -> ModuleType | None:
    """Return a module of that name that is the same for all components; None for others."""
    if name == "OpenRTM_aist":
        return LazyModule(name, _openrtm_name, lambda: [*_MODULE_OF, *CLIENTS, *_SUBMODULES])
    outer, _, last = name.partition(".")
    if outer == "OpenRTM_aist":
        return _submodule(last)
    if name == "omniORB":
        return LazyModule(name, _omniorb_name)
    if name not in _CORBA:
        return None
    corba = import_module(f"{_ROOM}.corba.names")
    return LazyModule(name, getattr(corba, _CORBA[name]))


def _omniorb_name(name: str) -> Any:
    from rtkit.openrtm.corba.names import omniorb_name

    return shared_module(name) if name in _OF_OMNIORB else omniorb_name(name)


def _openrtm_name(name: str) -> Any:
    if name in _SUBMODULES:
        return _submodule(name)
    if name == "RTC":
        from rtkit.openrtm.corba.standard_types import rtc_names, rtc_value

        return LazyModule("RTC", rtc_value, rtc_names)
    if name in CLIENTS:
        return getattr(client_module(CLIENTS[name]), name)
    home = _MODULE_OF.get(name)
    if home is None:
        if name.startswith("_"):
            raise KeyError(name)
        return absent(f"OpenRTM_aist.{name}")
    return getattr(import_module(f"{_ROOM}.{home}"), _RENAMED.get(name, name))


@cache
def _submodule(name: str) -> ModuleType:
    """Return ``OpenRTM_aist.NAME``: one with functions, or that of the class of its name."""
    home = _SUBMODULES.get(name)
    if home is None:
        return LazyModule(f"OpenRTM_aist.{name}", _openrtm_name)
    module = import_module(f"{_ROOM}.{home}")
    return LazyModule(f"OpenRTM_aist.{name}", lambda each: vars(module)[each], lambda: vars(module))
