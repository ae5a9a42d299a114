"""Base classes that authors derive their components from."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, TypeVar

from rtkit.errors import NotFound, Refused
from rtkit.openrtm.absent import refuse
from rtkit.openrtm.api.adapter import HeldComponent, being_made
from rtkit.openrtm.api.component_listeners import ListenedComponent
from rtkit.openrtm.api.logger import Logger
from rtkit.openrtm.api.parameters import ConfigAdmin
from rtkit.openrtm.api.ports import InPort, OutPort, PortBase
from rtkit.openrtm.api.properties import Properties
from rtkit.openrtm.api.string_util import Convert
from rtkit.openrtm.client_modules import client_module
from rtkit.openrtm.corba.enumerations import ITEMS, OK
from rtkit.openrtm.corba.records import ComponentProfile, name_values
from rtkit.openrtm.corba.references import OwnExecutionContext, RTObject

F = TypeVar("F", bound=Callable[..., Any])


def default_callback(function: F) -> F:
    """Mark a callback that does nothing, so that no context calls it."""
    function.is_default = True  # type: ignore[attr-defined]
    return function


class RTObject_impl(ListenedComponent, RTObject):
    """The object of an author: rtkit's component behind it does what its methods ask for.

    Attributes:
        rtkit_component: That component.
        holder_class: The class of rtkit's component behind it.
    """

    rtkit_component: HeldComponent
    holder_class: ClassVar[type[HeldComponent]] = HeldComponent
    _manager: Any
    _configsets: ConfigAdmin

    def __new__(cls, *_: Any, **__: Any) -> Any:
        """Return an object that knows its component, before any constructor runs."""
        component = being_made.get()
        if component is None or component.servant_class is not cls:
            raise refuse(f"{cls.__name__}(…) outside of Manager.createComponent")
        made = super().__new__(cls)
        made._attach(component)
        return made

    def __init__(self, manager: Any = None, orb: Any = None, poa: Any = None) -> None:
        if manager is not None:
            self._manager = manager

    def _attach(self, component: HeldComponent) -> None:
        self.rtkit_component = component
        self._manager = component.manager
        self._objref = self
        self._is_ending = False
        self._rtcout = Logger(component.instance)
        self._properties = _properties_of(component)
        self._configsets = ConfigAdmin(component.variables)
        self._inports: list[InPort] = []
        self._outports: list[OutPort] = []

    # callbacks

    @default_callback
    def onInitialize(self) -> Any:
        """Prepare: called once, before any other."""
        return OK

    @default_callback
    def onFinalize(self) -> Any:
        """Clean up: called once, last."""
        return OK

    @default_callback
    def onStartup(self, ec_id: int) -> Any:
        """React to the start of an execution context."""
        return OK

    @default_callback
    def onShutdown(self, ec_id: int) -> Any:
        """React to the stop of an execution context."""
        return OK

    @default_callback
    def onActivated(self, ec_id: int) -> Any:
        """Go from Inactive to Active."""
        return OK

    @default_callback
    def onDeactivated(self, ec_id: int) -> Any:
        """Go from Active to Inactive."""
        return OK

    @default_callback
    def onExecute(self, ec_id: int) -> Any:
        """Do the work of one period."""
        return OK

    @default_callback
    def onAborting(self, ec_id: int) -> Any:
        """Enter Error."""
        return OK

    @default_callback
    def onError(self, ec_id: int) -> Any:
        """Wait in Error."""
        return OK

    @default_callback
    def onReset(self, ec_id: int) -> Any:
        """Go from Error to Inactive."""
        return OK

    @default_callback
    def onStateUpdate(self, ec_id: int) -> Any:
        """Publish new state."""
        return OK

    @default_callback
    def onRateChanged(self, ec_id: int) -> Any:
        """React to a new rate."""
        return OK

    # ports

    def addInPort(self, name: str, inport: InPort) -> bool:
        """Add an in port."""
        self._inports.append(inport)
        return self.addPort(inport)

    def addOutPort(self, name: str, outport: OutPort) -> bool:
        """Add an out port."""
        self._outports.append(outport)
        return self.addPort(outport)

    def addPort(self, port: PortBase) -> bool:
        """Add a port; return whether its name was free."""
        port.owner = self
        try:
            self.rtkit_component.add_port(port.port)
        except Refused as error:
            self.rtkit_component.report(str(error))
            return False
        return True

    registerInPort, registerOutPort, registerPort = addInPort, addOutPort, addPort

    def removePort(self, port: PortBase) -> bool:
        """Remove a port without connectors; return whether that was possible."""
        return self.rtkit_component.remove_port(port.port)

    def removeInPort(self, port: InPort) -> bool:
        """Remove an in port."""
        return self._removed(self._inports, port)

    def removeOutPort(self, port: OutPort) -> bool:
        """Remove an out port."""
        return self._removed(self._outports, port)

    def _removed(self, among: list[Any], port: Any) -> bool:
        done = self.removePort(port)
        if done and port in among:
            among.remove(port)
        return done

    deletePort = removePort

    def getInPorts(self) -> list[InPort]:
        """Return its in ports."""
        return self._inports

    def getOutPorts(self) -> list[OutPort]:
        """Return its out ports."""
        return self._outports

    def readAll(self) -> Any:
        """Read a value at each in port."""
        for each in self._inports:
            each.read()
        return OK

    def writeAll(self) -> Any:
        """Write what is bound to each out port."""
        for each in self._outports:
            each.write()
        return OK

    # configuration and identity

    def bindParameter(
        self, param_name: str, var: list[Any], def_val: str, trans: Convert | None = None
    ) -> bool:
        """Bind a parameter to the only element of a list."""
        self._configsets.bindParameter(param_name, var, def_val, trans)
        return True

    def updateParameters(self, config_set: str) -> None:
        """Assign a set to the bound variables."""
        self._configsets.update(config_set)

    def getConfigService(self) -> ConfigAdmin:
        """Return its configuration."""
        return self._configsets

    def getProperties(self) -> Properties:
        """Return its properties."""
        return self._properties

    def setProperties(self, prop: Properties) -> None:
        """Change its properties."""
        self._properties.mergeProperties(prop)

    def getInstanceName(self) -> str:
        """Return its name."""
        return self.rtkit_component.instance

    def getTypeName(self) -> str:
        """Return the name of its type."""
        return self.rtkit_component.type.type_name

    def getDescription(self) -> str:
        """Return the description of its type."""
        return self.rtkit_component.type.description

    def getVersion(self) -> str:
        """Return the version of its type."""
        return self.rtkit_component.type.version

    def getVendor(self) -> str:
        """Return the maker of its type."""
        return self.rtkit_component.type.vendor

    def getCategory(self) -> str:
        """Return the group that its type belongs to."""
        return self.rtkit_component.type.category

    def get_component_profile(self) -> ComponentProfile:
        """Describe it."""
        return ComponentProfile(
            self.getInstanceName(), self.getTypeName(), self.getDescription(), self.getVersion(),
            self.getVendor(), self.getCategory(), [each.getProfile() for each in self.get_ports()],
            None, name_values(self._properties.texts()),
        )  # fmt: skip

    def get_ports(self) -> list[Any]:
        """Return its data ports."""
        return [*self._inports, *self._outports]

    def getObjRef(self) -> Any:
        """Return the reference to it."""
        return self

    # execution contexts

    def get_owned_contexts(self) -> list[OwnExecutionContext]:
        """Return the contexts that it owns."""
        return [OwnExecutionContext(each) for each in self.rtkit_component.contexts.values()]

    def get_participating_contexts(self) -> list[OwnExecutionContext]:
        """Return the contexts of others that it takes part in."""
        component = self.rtkit_component
        own = component.contexts.values()
        return [OwnExecutionContext(each) for each in component.participations if each not in own]

    def get_context(self, ec_id: int) -> OwnExecutionContext | None:
        """Return the context of a number; None where it takes part in none."""
        try:
            return OwnExecutionContext(self.rtkit_component.context_of(ec_id))
        except NotFound:
            return None

    getExecutionContext = get_context

    def get_context_handle(self, cxt: OwnExecutionContext) -> int:
        """Return the number of a context, -1 of one that it takes no part in."""
        component = self.rtkit_component
        for each in component.participations:
            if OwnExecutionContext(each) == cxt:
                return component.context_number(each.handle_for(component))
        return -1

    def getExecutionRate(self, ec_id: int) -> float:
        """Return the rate of a context [Hz]."""
        context = self.get_context(ec_id)
        return context.get_rate() if context is not None else 0.0

    def setExecutionRate(self, ec_id: int, rate: float) -> Any:
        """Change the rate of a context [Hz]."""
        context = self.get_context(ec_id)
        return context.set_rate(rate) if context is not None else ITEMS["RTC_ERROR"]

    def isOwnExecutionContext(self, ec_id: int) -> bool:
        """Return whether it owns a context."""
        return 0 <= ec_id < len(self.rtkit_component.contexts)

    def activate(self, ec_id: int) -> Any:
        """Ask a context to activate it."""
        context = self.get_context(ec_id)
        return context.activate_component(self) if context else ITEMS["RTC_ERROR"]

    def deactivate(self, ec_id: int) -> Any:
        """Ask a context to deactivate it."""
        context = self.get_context(ec_id)
        return context.deactivate_component(self) if context else ITEMS["RTC_ERROR"]

    def reset(self, ec_id: int) -> Any:
        """Ask a context to reset it."""
        context = self.get_context(ec_id)
        return context.reset_component(self) if context else ITEMS["RTC_ERROR"]

    def is_alive(self, exec_context: Any = None) -> bool:
        """Return whether it is initialised and not yet finalised."""
        return self.rtkit_component.is_alive

    def exit(self) -> Any:
        """End it, when the callback that is under way has come back; it is called for no other."""
        if not self._is_ending:
            self._is_ending = True
            for each in self.rtkit_component.participations:
                OwnExecutionContext(each).deactivate_component(self)
            client_module("far_references").end_component(self.getInstanceName())
        return OK

    def _default_POA(self) -> Any:
        return self._manager.getPOA()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in ABSENT_METHODS.split():
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        raise refuse(f"RTObject.{name}")


class DataFlowComponentBase(RTObject_impl):
    """The base class of components with data ports."""


ABSENT_METHODS = """
addSdoServiceProvider addSdoServiceConsumer removeSdoServiceProvider removeSdoServiceConsumer
attach_context detach_context bindContext finalizePorts finalizeContexts createContexts
addPortActionListener
addExecutionContextActionListener addPortConnectListener addPortConnectRetListener
addPreFsmActionListener addPostFsmActionListener addFsmProfileListener addFsmStructureListener
get_owned_organizations get_configuration get_organizations get_service_profiles
setReadAll setWriteAll deletePortByName
"""
"""Methods of OpenRTM that are not there yet: they say so when they are called."""


def _properties_of(component: HeldComponent) -> Properties:
    made = Properties(defaults_map=component.described)
    for key, text in component.options.items():
        made.setProperty(key, text)
    made.setProperty("instance_name", component.instance)
    return made
