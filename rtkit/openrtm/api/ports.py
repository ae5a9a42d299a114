"""Data ports that are bound to a variable: snapshots at write, fresh objects at read.

With the constants and names of types that components compare what ports return with.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from rtkit.component.ports.in_port import InPort as FrozenInPort
from rtkit.component.ports.options import PortStatus
from rtkit.component.ports.out_port import OutPort as FrozenOutPort
from rtkit.errors import RtkitError
from rtkit.openrtm.absent import refuse
from rtkit.openrtm.api.connector_listeners import ListenedPort
from rtkit.openrtm.api.properties import Properties
from rtkit.openrtm.client_modules import client_module
from rtkit.openrtm.corba.records import ConnectorProfile, PortProfile, name_values
from rtkit.openrtm.corba.references import PortService
from rtkit.openrtm.corba.twins import UNFIT, freezer_of, frozen_class_of, thawer_of


class PortBase(ListenedPort, PortService):
    """Base of all ports.

    Attributes:
        port: The port of rtkit that it stands for.
        owner: The component that it was added to; None before.
    """

    port: Any

    def __init__(self, name: str) -> None:
        self._name = name
        self._objref = self
        self.owner: Any = None

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        raise refuse(f"{type(self).__name__}.{name}")

    def name(self) -> str:
        """Return its name."""
        return self._name

    getName = name

    def setName(self, name: str) -> None:
        """Rename it, before it is added to a component."""
        self._name = self.port.name = name

    def addProperty(self, key: str, value: Any) -> None:
        """Set a property."""
        self.port.properties[key] = str(value)

    def appendProperty(self, key: str, value: Any) -> None:
        """Add to a property, behind a comma where it has a value."""
        present = self.port.properties.get(key, "")
        words = [each for each in present.split(",") if each]
        if str(value) not in words:
            self.port.properties[key] = ",".join([*words, str(value)])

    def properties(self) -> Properties:
        """Return its properties."""
        return Properties(defaults_map=dict(self.port.properties))

    def getProfile(self) -> PortProfile:
        """Describe it."""
        port = self.port.profile
        connectors = [ConnectorProfile("", each, [self], []) for each in self.port.connectors]
        properties = name_values(dict(port.properties))
        return PortProfile(self._name, [], self, connectors, self.owner, properties)

    getPortProfile = get_port_profile = getProfile

    def get_connector_profiles(self) -> list[ConnectorProfile]:
        """Describe its connectors."""
        found: list[ConnectorProfile] = self.getProfile().connector_profiles
        return found

    def getPortRef(self) -> Any:
        """Return the reference to it."""
        return self

    def getOwner(self) -> Any:
        """Return the component that it belongs to."""
        return self.owner

    def init(self, properties: Any) -> None:
        """Accept properties; rtkit has merged them when the port was added."""

    def isConnected(self) -> bool:
        """Return whether it has a connector."""
        return bool(self.port.connectors)

    def connect(self, connector_profile: ConnectorProfile) -> tuple[Any, ConnectorProfile]:
        """Have the ports of a profile connected; return a code, and the profile as it became."""
        code, made = self._in_tree().connect(connector_profile)
        return code, made

    def disconnect(self, connector_id: str) -> Any:
        """Have a connector removed."""
        return self._in_tree().disconnect(connector_id)

    def disconnect_all(self) -> Any:
        """Have all its connectors removed."""
        return self._in_tree().disconnect_all()

    def _in_tree(self) -> Any:
        """Return the port as others see it: the manager makes connectors, not the component."""
        return client_module("far_references").FarPort(self.owner, self._name)


class InPort(PortBase):
    """A port that values arrive at."""

    port: FrozenInPort[Any]
    port_class: ClassVar[type[FrozenInPort[Any]]] = FrozenInPort

    def __init__(self, name: str, value: Any, buffer: Any = None, *_: Any, **__: Any) -> None:
        super().__init__(name)
        self._value = value
        cls = frozen_class_of(value)
        self._thaw = thawer_of(cls)
        self._on_read: Callable[[], Any] | None = None
        self._on_read_convert: Callable[[Any], Any] | None = None
        self.port = self.port_class(cls, name)

    def isNew(self, names: Any = None) -> bool:
        """Return whether a value is there that was not read yet."""
        return self.port.is_new()

    def isEmpty(self, names: Any = None) -> bool:
        """Return whether every value was read."""
        return not self.port.is_new()

    def read(self, name: str | None = None) -> Any:
        """Return the oldest value not read yet, an object of its own; else the last one.

        Before the first value that is the one that the port was made with.
        """
        if self._on_read is not None:
            self._on_read()
        port = self.port
        before = port.read_count
        value = port.read()
        if port.read_count != before:
            self._value = self._thaw(value)
            if self._on_read_convert is not None:
                self._value = self._on_read_convert(self._value)
        return self._value

    def update(self) -> None:
        """Read a value into the bound variable."""
        self.read()

    def setOnRead(self, on_read: Callable[[], Any]) -> None:
        """Have a function called before each read."""
        self._on_read = on_read

    def setOnReadConvert(self, on_read_convert: Callable[[Any], Any]) -> None:
        """Have each value that is read replaced by what a function makes of it."""
        self._on_read_convert = on_read_convert


class OutPort(PortBase):
    """A port that values leave from."""

    port: FrozenOutPort[Any]
    port_class: ClassVar[type[FrozenOutPort[Any]]] = FrozenOutPort

    def __init__(self, name: str, value: Any, buffer: Any = None) -> None:
        super().__init__(name)
        self._value = value
        cls = frozen_class_of(value)
        self._freeze = freezer_of(cls)
        self._on_write: Callable[[Any], Any] | None = None
        self._on_write_convert: Callable[[Any], Any] | None = None
        self._failure = ""
        self.port = self.port_class(cls, name)

    def write(self, value: Any = None) -> bool:
        """Send a value, else what the bound variable holds now; return whether all got it.

        It is False while nobody is connected, and for what cannot be carried, which is logged.
        """
        if not value:
            value = self._value
        if self._on_write is not None:
            self._on_write(value)
        if self._on_write_convert is not None:
            value = self._on_write_convert(value)
        try:
            status = self._send(value)
        except UNFIT as error:
            self._report(value, error)
            return False
        return status is PortStatus.OK and bool(self.port.connectors)

    def _send(self, value: Any) -> PortStatus:
        return self.port.write(self._freeze(value))

    def setOnWrite(self, on_write: Callable[[Any], Any]) -> None:
        """Have a function called with each value before it is sent."""
        self._on_write = on_write

    def setOnWriteConvert(self, on_write_convert: Callable[[Any], Any]) -> None:
        """Have what a function makes of a value sent in its place."""
        self._on_write_convert = on_write_convert

    def getPortDataType(self) -> str:
        """Return the name of its data type."""
        return self.port.data_type.__name__

    def _report(self, value: Any, error: Exception) -> None:
        """Log why a value was not sent, once for each reason."""
        why = str(error) if isinstance(error, RtkitError) else f"{value!r}: {error}"
        if why != self._failure and self.owner is not None:
            self._failure = why
            self.owner.rtkit_component.report(f"port {self._name}: not sent: {why}")


def options_of(properties: Mapping[str, str], name: str) -> dict[str, str]:
    """Return those properties that stand below a name."""
    head = f"{name}."
    return {k.removeprefix(head): v for k, v in properties.items() if k.startswith(head)}


class DataPortStatus:
    """Outcomes of a write or a read, as numbers."""

    (
        PORT_OK, PORT_ERROR, BUFFER_ERROR, BUFFER_FULL, BUFFER_EMPTY, BUFFER_TIMEOUT, SEND_FULL,
        SEND_TIMEOUT, RECV_EMPTY, RECV_TIMEOUT, INVALID_ARGS, PRECONDITION_NOT_MET,
        CONNECTION_LOST, UNKNOWN_ERROR,
    ) = range(14)  # fmt: skip

    @classmethod
    def toString(cls, status: int) -> str:
        """Return the name of an outcome."""
        names = {value: name for name, value in vars(cls).items() if isinstance(value, int)}
        return names.get(status, "")


class PortType:
    """Kinds of data ports."""

    OutPortType, InPortType, PortTypeNum = range(3)


def toTypename(value: Any) -> str:
    """Return the name of the type of a value, as ports have it."""
    return str(value._NP_RepositoryId)  # noqa: SLF001 - as omniORB calls it
