"""Base of in ports and out ports: their data type, and who listens to their connectors."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from rtkit.component.ports.any_port import Port
from rtkit.component.ports.connector_events import (
    ConnectorEvent,
    ConnectorListener,
    ConnectorListeners,
)
from rtkit.component.ports.options import ConnectorOptions, parse_options
from rtkit.component.ports.port_watch import Watchable
from rtkit.component.values.definition import definition_of
from rtkit.component.values.typenames import type_name
from rtkit.errors import Malformed
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import DEFINITION, ConnectorProfile, PortProfile

T = TypeVar("T")


class DataPort(Port, Watchable[T]):
    """A port that carries values of one type; its connectors can be listened to.

    Attributes:
        is_undecoded: Whether values of other processes stay octets, where they arrive.
        announce: Called with instance name and ``listener`` before listeners are called because a
            connector comes or goes, with two empty texts after that; None while nobody watches.
    """

    announce: Callable[[str, str], object] | None = None
    is_undecoded = False
    _listeners: ConnectorListeners | None = None

    def __init__(
        self,
        data_type: type[T],
        name: str = "",
        properties: Mapping[str, str] | None = None,
        *,
        doc: str = "",
    ) -> None:
        if not isinstance(data_type, type):
            raise Malformed(f"a data type is a class, not {data_type!r}")
        own = {
            "dataport.data_type": type_name(data_type),
            "dataport.interface_type": "zenoh,direct,corba_cdr,data_service",
            "dataport.dataflow_type": "push,pull",
            "dataport.subscription_type": "flush,new,periodic",
        }
        super().__init__(name, {**own, **(properties or {})}, doc=doc)
        self.data_type = data_type
        self._profiles: dict[str, ConnectorProfile] = {}
        self._begin()

    @abstractmethod
    def _begin(self) -> None:
        """Set up what a port of this direction keeps."""

    @property
    def profile(self) -> PortProfile:
        """The port as others see it, with the definition of a data type of one's own."""
        definition = definition_of(self.data_type)
        extra = {DEFINITION: definition} if definition else {}
        return PortProfile(self.name, self.port_type, {**self.properties, **extra})

    def copy(self) -> DataPort[T]:
        """Return a port of the same kind without connectors, for another instance."""
        return type(self)(self.data_type, self.name, self.properties)

    @property
    def connector_profiles(self) -> tuple[ConnectorProfile, ...]:
        """The connectors that are open."""
        return tuple(self._profiles.values())

    def add_listener(self, event: ConnectorEvent, listener: ConnectorListener) -> None:
        """Have a listener called at each event of that kind, after those added before.

        It is given the connector and the value, None where the event is of none, and runs on the
        thread that causes the event: that of the writer, of the reader, or of the one that
        connects. Between two processes a value comes on a thread that takes those of all
        connectors. What it returns takes the place of the value where `ConnectorEvent` says so;
        None leaves it. What it raises is logged.
        """
        with self._lock:
            if self._listeners is None:
                end = 0 if self.port_type is PortType.OUT else 1
                self._listeners = ConnectorListeners(self.name, end, self._fit)
            self._listeners.add(event, listener)
            self._rewire()

    def remove_listener(self, event: ConnectorEvent, listener: ConnectorListener) -> None:
        """Call a listener no more; ignore one that is none."""
        with self._lock:
            if self._listeners is not None:
                self._listeners.remove(event, listener)
                if not self._listeners:
                    self._listeners = None
                self._rewire()

    def _fit(self, connector: ConnectorProfile, value: Any) -> Any:
        """Return the value that readers get for one that a listener returns; raise if none fits."""
        from rtkit.component.values.carried import carried

        return carried(self._type_of(connector), value)

    def _type_of(self, connector: ConnectorProfile) -> type:
        """Return the type of the values that pass the listeners of a connector."""
        return self.data_type

    def _notify(self, event: ConnectorEvent, connector: ConnectorProfile | None) -> None:
        """Tell that a connector came or went; not under the lock, as listeners may use the port."""
        if self._listeners is None or connector is None:
            return
        if self.announce is not None:
            self.announce(self._listeners.owner(connector), "listener")
        self._listeners.notify(event, connector)
        if self.announce is not None:
            self.announce("", "")

    def _enter(self, connector: ConnectorProfile) -> None:
        self._admit(connector.connector_id)
        self._profiles[connector.connector_id] = connector

    def _leave(self, connector_id: str) -> ConnectorProfile | None:
        self._dismiss(connector_id)
        return self._profiles.pop(connector_id, None)

    def _options(self, connector: ConnectorProfile) -> ConnectorOptions:
        defaults = {key: value for key, value in self.properties.items() if ".buffer." in key}
        return parse_options({**defaults, **connector.properties})
