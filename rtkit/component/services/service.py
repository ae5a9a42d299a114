"""Service ports: provide interfaces to other components, or require them.

::

    class MyService(Protocol):
        def echo(self, text: str) -> str: ...

    class Provider(Component):
        service = ServicePort.provided(MyService, "myservice0")

        def echo(self, text: str) -> str:
            return text

    class Consumer(Component):
        service = ServicePort.required(MyService, timeout_s=0.5)

        def on_execute(self, context):
            self.service.client.echo("hi")

A provider in the same process is called directly, on the caller's thread. One in another process is
called on a thread of the connector there; arguments and result travel as CDR, and the caller waits
at most for the time-out. Both check what is passed, and pass exceptions, alike. Several callers may
be inside a provider at once.

Components of one process that call each other could wait for each other for ever: the call that
closes such a circle runs on a thread of its own and is bounded by the time-out, too.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from copy import copy
from threading import Lock
from typing import Any, ClassVar, Generic, NamedTuple, Protocol, Self, TypeVar, cast

from rtkit.component.configuration.kinds import read_float
from rtkit.component.ports.any_port import Port
from rtkit.component.ports.options import DEFAULT_TIMEOUT_S
from rtkit.component.services.interface import Interface, InterfaceMethod
from rtkit.component.services.invocation import CallTarget, ProvidedInterface, Remote
from rtkit.errors import Malformed, NotFound, Refused, Unreachable
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.profiles import DEFINITION, ConnectorProfile, PortInterfaceProfile, PortProfile

_definitions: dict[tuple[Interface, ...], str] = {}
S = TypeVar("S")
TIMEOUT = "service.timeout"
"""Property of a port, or of a connector, which wins: bound on a call [s]."""


class PortOwner(Protocol):
    """The component that a port belongs to."""

    instance: str

    def stir(self) -> None:
        """Note that a service was called."""


class _Use(NamedTuple):
    """One interface of a port: provided by `implementation`, or required."""

    interface: Interface
    profile: PortInterfaceProfile
    implementation: object = None


class _Link(NamedTuple):
    """Targets of an open connector, by type name of the interface, and its time-out."""

    timeout_s: float
    targets: Mapping[str, CallTarget]


class ServicePort(Port):
    """A port whose interfaces are offered or needed.

    Attributes:
        usual_timeout_s: Bound on a call where neither port nor connector has one [s].
    """

    port_type = PortType.SERVICE
    usual_timeout_s: ClassVar[float] = DEFAULT_TIMEOUT_S

    def __init__(
        self,
        name: str = "",
        interfaces: tuple[PortInterfaceProfile, ...] = (),
        properties: Mapping[str, str] | None = None,
        *,
        doc: str = "",
    ) -> None:
        super().__init__(name, properties, doc=doc)
        self._described = tuple(interfaces)
        self._uses: tuple[_Use, ...] = ()
        self._owner: PortOwner | None = None
        self._links: dict[str, _Link] = {}

    @classmethod
    def provided(
        cls,
        interface: Callable[..., object],
        instance_name: str = "",
        *,
        implementation: object = None,
        name: str = "",
        type_name: str = "",
        doc: str = "",
    ) -> ServicePort:
        """Return a port that offers one interface, done by the component itself or another object.

        Raises:
            Malformed: The interface cannot be carried; names method and parameter.
        """
        return ServicePort(name, doc=doc).provide(
            interface, instance_name, implementation=implementation, type_name=type_name
        )

    @classmethod
    def required(
        cls,
        interface: Callable[..., S],
        instance_name: str = "",
        *,
        timeout_s: float | None = None,
        name: str = "",
        type_name: str = "",
        doc: str = "",
    ) -> RequiredPort[S]:
        """Return a port that needs one interface; each call waits at most `timeout_s` [s].

        Within a process a provider runs on the thread of its caller, and only a call that closes a
        circle is bounded.

        Raises:
            Malformed: The interface cannot be carried; names method and parameter.
        """
        properties = {} if timeout_s is None else {TIMEOUT: f"{timeout_s:g}"}
        port: RequiredPort[S] = RequiredPort(name, properties=properties, doc=doc)
        return port.require(interface, instance_name, type_name=type_name)

    def provide(
        self,
        interface: Callable[..., object],
        instance_name: str = "",
        *,
        implementation: object = None,
        type_name: str = "",
    ) -> Self:
        """Offer a further interface; without implementation the component itself does it.

        A class as implementation is instantiated once for each component, with that component
        where its constructor takes an argument.
        """
        return self._add(interface, instance_name, type_name, Polarity.PROVIDED, implementation)

    def require(
        self, interface: Callable[..., object], instance_name: str = "", *, type_name: str = ""
    ) -> Self:
        """Need a further interface; `client_of` gives what calls it."""
        return self._add(interface, instance_name, type_name, Polarity.REQUIRED, None)

    @property
    def interfaces(self) -> tuple[PortInterfaceProfile, ...]:
        """Its interfaces as others see them."""
        own = (
            use.profile
            if use.profile.instance_name
            else PortInterfaceProfile(self.name, use.profile.type_name, use.profile.polarity)
            for use in self._uses
        )
        return (*self._described, *own)

    @property
    def profile(self) -> PortProfile:
        """The port as others see it."""
        properties = dict(self.properties)
        if self._uses:
            properties[DEFINITION] = self._definition
        return PortProfile(self.name, self.port_type, properties, self.interfaces)

    @property
    def _definition(self) -> str:
        """The IDL of its interfaces, written once for all ports that have the same."""
        used = tuple(use.interface for use in self._uses)
        known = _definitions.get(used)
        if known is None:
            from rtkit.component.services.interface_definition import definition_of

            known = _definitions[used] = definition_of(used)
        return known

    @property
    def is_connected(self) -> bool:
        """Return whether there is a provider for every interface that is needed."""
        needed = [u for u in self._uses if u.profile.polarity is Polarity.REQUIRED]
        return all(self._find(use.interface.name) is not None for use in needed)

    def copy(self) -> Self:
        """Return a port of the same kind without connectors, for another instance."""
        made = copy(self)
        made.properties = dict(self.properties)
        made._lock = Lock()  # noqa: SLF001 - it is of this class
        return made

    def belong_to(self, owner: PortOwner) -> None:
        """Set the owner of the port; it implements interfaces without another implementation.

        Raises:
            Refused: An implementation lacks methods of its interface; names them.
        """
        self._owner = owner
        self._uses = tuple(self._implemented(use, owner) for use in self._uses)

    def client_of(self, interface: Callable[..., S], timeout_s: float | None = None) -> S:
        """Return the client that calls the provider of a needed interface.

        Raises:
            NotFound: The port does not need that interface.
        """
        for use in self._uses:
            if use.profile.polarity is Polarity.REQUIRED and use.interface.cls is interface:
                return cast(S, use.interface.client(self, timeout_s))
        raise NotFound(f"service port {self.name} does not need {interface}")

    def provider_of(self, interface: Callable[..., object]) -> CallTarget | None:
        """Return what does a needed interface; None while nobody is connected that provides it."""
        names = [use.interface.name for use in self._uses if use.interface.cls is interface]
        found = self._find(names[0]) if names else None
        return None if found is None else found.targets[names[0]]

    def call(
        self,
        method: InterfaceMethod,
        type_name: str,
        arguments: tuple[Any, ...],
        named: Mapping[str, Any],
        timeout_s: float | None,
    ) -> Any:
        """Call a method of the provider connected first; clients use this.

        Raises:
            Malformed: The arguments, or the result, are not what the interface says.
            Refused: The provider raised an exception; the message names it.
            Unreachable: Nobody is connected, there was no answer in time, or the provider ended.
        """
        found = self._provider(type_name)
        bound_s = found.timeout_s if timeout_s is None else timeout_s
        return found.targets[type_name].call(method, arguments, named, bound_s)

    def pass_on(self, type_name: str, call: bytes, timeout_s: float) -> bytes:
        """Send a call that another process has encoded; return the reply, encoded.

        Raises:
            Unreachable: Nobody is connected, there was no answer in time, or the provider ended.
            Refused: The provider is in this process, where nothing is encoded.
        """
        target = self._provider(type_name).targets[type_name]
        if not isinstance(target, Remote):
            raise Refused(f"{self._label}: the provider of {type_name} is in this process")
        return target.pass_on(call, timeout_s)

    @property
    def served(self) -> tuple[ProvidedInterface, ...]:
        """The interfaces that it offers, ready to be called."""
        owner = self._owner
        if owner is None:
            return ()
        return tuple(
            ProvidedInterface(use.interface, use.implementation, self._label, owner.stir)
            for use in self._uses
            if use.profile.polarity is Polarity.PROVIDED
        )

    @property
    def own_operations(self) -> tuple[str, ...]:
        """The operations that the component itself is to implement."""
        own = (
            use.interface.methods
            for use in self._uses
            if use.profile.polarity is Polarity.PROVIDED and use.implementation is None
        )
        return tuple(name for names in own for name in names)

    @property
    def needed(self) -> tuple[Interface, ...]:
        """The interfaces that it needs."""
        uses = (use for use in self._uses if use.profile.polarity is Polarity.REQUIRED)
        return tuple(use.interface for use in uses)

    def attach(
        self, connector: ConnectorProfile, targets: Mapping[str, CallTarget] | None = None
    ) -> None:
        """Open a connector to `targets`, by type name of the interface.

        A connector that is open already gets further targets.

        Raises:
            Refused: The port takes no more.
            Malformed: Its time-out cannot be read.
        """
        connector_id = connector.connector_id
        timeout_s = self._timeout(connector)
        with self._lock:
            if connector_id not in self._connectors:
                self._admit(connector_id)
            known = self._links.get(connector_id)
            both = {**(known.targets if known else {}), **(targets or {})}
            self._links = {**self._links, connector_id: _Link(timeout_s, both)}

    def detach(self, connector_id: str) -> None:
        """Close a connector; a call that is under way comes to its own end."""
        with self._lock:
            self._dismiss(connector_id)
            self._links = {id: each for id, each in self._links.items() if id != connector_id}

    @property
    def _label(self) -> str:
        return f"{self._owner.instance}.{self.name}" if self._owner else self.name

    def _provider(self, type_name: str) -> _Link:
        found = self._find(type_name)
        if found is None:
            raise Unreachable(f"{self._label}: no provider of {type_name} is connected")
        return found

    def _find(self, type_name: str) -> _Link | None:
        return next((each for each in self._links.values() if type_name in each.targets), None)

    def _timeout(self, connector: ConnectorProfile) -> float:
        text = connector.properties.get(TIMEOUT, "") or self.properties.get(TIMEOUT, "")
        timeout_s = read_float(text) if text.strip() else self.usual_timeout_s
        if not 0 < timeout_s < float("inf"):
            raise Malformed(f"{TIMEOUT}={text}: not a positive number of seconds")
        return timeout_s

    def _add(
        self,
        interface: Callable[..., object],
        instance_name: str,
        type_name: str,
        polarity: Polarity,
        implementation: object,
    ) -> Self:
        read = Interface(interface, type_name)
        profile = PortInterfaceProfile(instance_name, read.name, polarity)
        self._uses = (*self._uses, _Use(read, profile, implementation))
        return self

    def _implemented(self, use: _Use, owner: PortOwner) -> _Use:
        if use.profile.polarity is Polarity.REQUIRED:
            return use
        done_by = use.implementation
        if done_by is None:
            done_by = owner
        elif isinstance(done_by, type):
            done_by = done_by(owner) if _takes_argument(done_by) else done_by()
        use.interface.check_methods(done_by, f"{owner.instance}.{self.name}")
        return use._replace(implementation=done_by)


def _takes_argument(cls: type) -> bool:
    """Return whether the constructor of a class takes an argument: the component it works for."""
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    try:
        wanted = inspect.signature(cls).parameters.values()
    except ValueError:
        return False  # a class that is not written in Python
    return any(each.kind in kinds and each.default is each.empty for each in wanted)


class RequiredPort(ServicePort, Generic[S]):
    """A service port that needs one interface."""

    @property
    def client(self) -> S:
        """The client of the provider; each method raises as `ServicePort.call` says."""
        return cast(S, self._uses[0].interface.client(self, None))

    def within(self, timeout_s: float) -> S:
        """Return a client whose calls wait at most so long [s]."""
        return cast(S, self._uses[0].interface.client(self, timeout_s))
