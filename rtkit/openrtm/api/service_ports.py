"""Service ports: servants that components provide, and consumers that they call others by."""

from __future__ import annotations

from typing import Any

from rtkit.component.services.service import ServicePort
from rtkit.errors import Malformed, Refused
from rtkit.logs.late import late
from rtkit.openrtm.absent import refuse
from rtkit.openrtm.api.ports import PortBase
from rtkit.openrtm.corba.operations import ServantImplementation, interface_of, proxy_class
from rtkit.openrtm.corba.services import ObjectReference, Servant

_log = late(__name__)


class CorbaConsumer:
    """Calls the provider that a service port is connected with.

    Args:
        interfaceType: The class of the interface; `consumer` is another one to take it from.
    """

    def __init__(self, interfaceType: Any = None, consumer: CorbaConsumer | None = None) -> None:
        self.interface: Any = interfaceType if consumer is None else consumer.interface
        self._port: ServicePort | None = None
        self._object: Any = None
        self._proxy: Any = None

    def call_by(self, port: ServicePort) -> None:
        """Call by a port from now on."""
        self._port = port
        self._proxy = proxy_class(self.interface)(port, interface_of(self.interface).cls)

    def _ptr(self) -> Any:
        """Return what is called: a servant of this process itself; None while nothing is there."""
        if self._object is not None or self._port is None:
            return self._object
        provider = self._port.provider_of(interface_of(self.interface).cls)
        if provider is None:
            return None
        here = getattr(provider, "implementation", None)
        return here.servant if isinstance(here, ServantImplementation) else self._proxy

    getObject = _ptr

    def setObject(self, reference: Any) -> bool:
        """Call another object in place of the provider; return whether it is one."""
        self._object = reference
        return reference is not None

    def releaseObject(self) -> None:
        """Call the provider again."""
        self._object = None


class PatientServicePort(ServicePort):
    """A port whose calls may take long: without rtc.conf's leave CORBA waits for ever."""

    usual_timeout_s = 600.0


class CorbaPort(PortBase):
    """A port whose interfaces are provided or needed."""

    port: ServicePort

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.port = PatientServicePort(name)

    def registerProvider(
        self, instance_name: str, type_name: str, provider: Any, *_: Any, **__: Any
    ) -> bool:
        """Provide an interface by a servant; return whether that is possible."""
        if not isinstance(provider, Servant):
            raise refuse(f"CorbaPort.registerProvider of {provider!r}, which is no servant")
        kind = next(each for each in type(provider).__mro__ if "declared" in vars(each))

        def provide() -> None:
            done_by = ServantImplementation(provider, kind)
            interface = interface_of(kind).cls
            self.port.provide(interface, instance_name, implementation=done_by, type_name=type_name)

        return self._registered(instance_name, provide)

    def registerConsumer(
        self, instance_name: str, type_name: str, consumer: CorbaConsumer, *_: Any, **__: Any
    ) -> bool:
        """Need an interface, which a consumer calls; return whether that is possible."""
        if consumer.interface is None or not issubclass(consumer.interface, ObjectReference):
            raise refuse(f"CorbaConsumer({consumer.interface!r}), which is no interface of IDL")

        def require() -> None:
            interface = interface_of(consumer.interface).cls
            self.port.require(interface, instance_name, type_name=type_name)
            consumer.call_by(self.port)

        return self._registered(instance_name, require)

    def activateInterfaces(self) -> None:
        """Do nothing: they are active while the component lives."""

    deactivateInterfaces = activateInterfaces

    def _registered(self, instance_name: str, register: Any) -> bool:
        try:
            register()
        except (Malformed, Refused) as error:
            _log().error("port %s: %s: %s", self._name, instance_name, error)
            return False
        if self.owner is not None:
            self.port.belong_to(self.owner.rtkit_component)
            self.owner.rtkit_component.show_changes()
        return True
