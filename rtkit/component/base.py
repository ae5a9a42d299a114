"""The base class of components."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar

from rtkit.component.configuration.config import DEFAULT, Configuration
from rtkit.component.configuration.kinds import kind_of
from rtkit.component.configuration.parameter import Parameter, declared_parameters
from rtkit.component.contexts.callbacks import Callbacks, Failure, attempt
from rtkit.component.contexts.context import ExecutionContext
from rtkit.component.contexts.owned_contexts import PERIODIC, wanted_contexts
from rtkit.component.ports.any_port import Port
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.out_port import OutPort
from rtkit.component.services.service import ServicePort
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.enums import ExecutionKind
from rtkit.rtc.names import check_instance_name, check_port_name
from rtkit.rtc.pattern import ContextPattern
from rtkit.rtc.profiles import PortInterfaceProfile, TypeProfile

if TYPE_CHECKING:
    from logging import Logger

T = TypeVar("T")
AnyPort = TypeVar("AnyPort", bound=Port)
ACTIVE_SET = "configuration.active_config"
_PORT_KINDS = ("inport", "outport", "service")


class Manager(Protocol):
    """The argument of a module's init function: registers component types."""

    def register_factory(self, component: type[Component]) -> object:
        """Make a component type available."""


_FOR_CONTAINERS = frozenset([
    "context_rate", "finalize", "has_changes", "initialize", "keep_failure", "leave",
    "own_attributes", "parameters_declared", "participation", "read_count", "stir", "take_part",
    "takes_settings_from",
])  # fmt: skip


class Component(Callbacks):
    """A component: ports, configuration and callbacks, driven by execution contexts.

    Derive from it, declare ports and parameters as class attributes, override callbacks. The
    docstring of the class is its description.

    Attributes:
        vendor: Name of the type's maker.
        category: Name of the group of types that it belongs to.
        version: Version of the type.
        type_name: Name of the type; the name of the class when empty.
        execution_type: Type of the execution context it owns when nothing else is asked for:
            ``PeriodicExecutionContext``, ``EventDrivenExecutionContext`` or
            ``ExtTrigExecutionContext``.
        rate: Of that context if it is periodic [Hz].
        composite_type: Name of this kind of composite in profiles; empty where it is none.
        has_machine: Whether it is a `rtkit.component.fsm.FsmComponent`.
        own_attributes: Names of the attributes that the base class keeps on each instance.
        is_made_late: Whether it has ports and parameters from on_initialize on, not before.
        is_stand_in: Whether it has the outside of another component and no code of its own.
        configuration_class: Class of its configuration.
        instance: Its name.
        type: Identity of its type.
        ports: Its ports by name, in order of declaration.
        configuration: Its configuration sets.
        contexts: The execution contexts it owns, by id.
        participations: All contexts it takes part in, own ones first.
        composite: The composite that it is a member of, None for most.
        member_components: Its members, if it is a composite itself.
        is_alive: Whether it is initialised and not yet finalised.
        cause: The failure that put it into Error, one line; empty otherwise.
        report: Called with one line about a failure that is survived; logs it by default.
    """

    vendor: ClassVar[str] = ""
    category: ClassVar[str] = ""
    version: ClassVar[str] = ""
    type_name: ClassVar[str] = ""
    execution_type: ClassVar[str] = PERIODIC
    rate: ClassVar[float] = 1000.0
    composite_type: ClassVar[str] = ""
    has_machine: ClassVar[bool] = False
    is_made_late: ClassVar[bool] = False
    is_stand_in: ClassVar[bool] = False
    configuration_class: ClassVar[type[Configuration]] = Configuration
    own_attributes: ClassVar[tuple[str, ...]] = (
        "cause", "composite", "configuration", "contexts", "instance", "is_alive",
        "member_components", "options", "participations", "ports", "report", "type",
    )  # fmt: skip
    _declared: ClassVar[Mapping[str, Port]] = {}
    _parameters: ClassVar[Mapping[str, Parameter[Any]]] = {}

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        if cls.__module__.partition(".")[0] != "rtkit":  # those are made for what they override
            from rtkit.component.collisions import refuse_collisions

            refuse_collisions(cls, cls.own_attributes)
        found = {
            name: value
            for ancestor in reversed(cls.__mro__)
            for name, value in vars(ancestor).items()
        }
        cls._declared = {n: v for n, v in found.items() if isinstance(v, Port)}
        cls._parameters = declared_parameters(cls)

    def __init__(self, instance: str, options: Mapping[str, str] | None = None) -> None:
        self.instance = check_instance_name(instance)
        self.options: Mapping[str, str] = dict(options or {})
        self.type = self.type_profile()
        self.ports: dict[str, Port] = {}
        self.contexts: dict[str, ExecutionContext] = {}
        self.participations: tuple[ExecutionContext, ...] = ()
        self.composite: Component | None = None
        self.member_components: tuple[Component, ...] = ()
        self.is_alive = False
        self.cause = ""
        self.report: Callable[[str], None] = self._log
        self.configuration = self.configuration_class(lambda text: self.report(text))
        for attribute, declared in self._declared.items():
            setattr(self, attribute, self._add(declared.copy()))
        self._configure()

    @classmethod
    def type_profile(cls) -> TypeProfile:
        """Return the identity of this type."""
        text = (cls.__doc__ or "").strip().partition("\n\n")[0]
        return TypeProfile(
            type_name=cls.type_name or cls.__name__,
            vendor=cls.vendor,
            category=cls.category,
            version=cls.version,
            description=" ".join(text.split()),
        )

    def __dir__(self) -> list[str]:
        """Return the names that authors use; those that containers call are left out."""
        return [name for name in super().__dir__() if name not in _FOR_CONTAINERS]

    @property
    def parameters_declared(self) -> Mapping[str, Parameter[Any]]:
        """Its parameters, by attribute or name."""
        return self._parameters

    @property
    def logger(self) -> Logger:
        """The logger with this instance's name."""
        import logging

        return logging.getLogger(self.instance)

    def context_rate(self, context: str) -> float:
        """Return the rate of an execution context that calls this component [Hz].

        Raises:
            NotFound: It takes part in none of that id.
        """
        return self.participation(context).rate

    def participation(self, context: str) -> ExecutionContext:
        """Return the context of that id: of an own one, or ``OWNER/ID`` of another's.

        Raises:
            NotFound: It takes part in none of that id.
        """
        for each in self.participations:
            if each.handle_for(self) == context:
                return each
        raise NotFound(f"{self.instance} takes no part in execution context {context}")

    def take_part(self, context: ExecutionContext) -> None:
        """Note a context that took this component in; called by that context."""
        self.participations = (*self.participations, context)
        self._listen()

    def leave(self, context: ExecutionContext) -> None:
        """Forget a context that let this component go; called by that context."""
        self.participations = tuple(each for each in self.participations if each is not context)
        self._listen()

    def takes_settings_from(self, context: object) -> bool:
        """Return whether settings wait that this context is to have it take over."""
        if not self.configuration.is_pending:
            return False
        # One context only, else another would see them change in its cycle.
        running = (each for each in self.participations if each.is_running)
        return next(running, None) is context

    @property
    def has_changes(self) -> bool:
        """Return whether a value waits at some in port."""
        return any(port.is_new() for port in self._in_ports())

    @property
    def read_count(self) -> int:
        """Values that were read from all in ports."""
        return sum(port.read_count for port in self._in_ports())

    def stir(self) -> None:
        """Ask the event-driven contexts that drive this component for a cycle, from any thread."""
        for context in self.participations:
            if context.kind is ExecutionKind.EVENT_DRIVEN:
                context.stir()

    def _listen(self) -> None:
        kinds = [context.kind for context in self.participations]
        listener = self.stir if ExecutionKind.EVENT_DRIVEN in kinds else None
        for port in self._in_ports():
            port.listen(listener)

    def _in_ports(self) -> list[InPort[Any]]:
        """Return its own in ports, not those of members that it shows under other names."""
        return [
            port
            for name, port in self.ports.items()
            if isinstance(port, InPort) and name == port.name
        ]

    def add_in_port(
        self, name: str, data_type: type[T], properties: Mapping[str, str] | None = None
    ) -> InPort[T]:
        """Add an in port.

        Raises:
            Refused: One of that name exists.
        """
        return self._add(InPort(data_type, name, properties))

    def add_out_port(
        self, name: str, data_type: type[T], properties: Mapping[str, str] | None = None
    ) -> OutPort[T]:
        """Add an out port.

        Raises:
            Refused: One of that name exists.
        """
        return self._add(OutPort(data_type, name, properties))

    def add_service_port(
        self,
        name: str,
        interfaces: tuple[PortInterfaceProfile, ...] = (),
        properties: Mapping[str, str] | None = None,
    ) -> ServicePort:
        """Add a service port.

        Raises:
            Refused: One of that name exists.
        """
        return self._add(ServicePort(name, interfaces, properties))

    def initialize(self) -> None:
        """Come alive: own contexts are made, then on_initialize, then they start.

        Raises:
            Refused: on_initialize failed; the message has the exception and the line.
            Malformed: An option cannot be read.
        """
        if self.is_alive:
            raise Refused(f"{self.instance} is initialised already")
        self.contexts = {
            each.id: ExecutionContext(each.id, each.kind, each.rate, self.instance, each.properties)
            for each in self._wanted_contexts()
        }
        failure = attempt(self.on_initialize)
        if failure:
            self.contexts = {}
            raise Refused(f"{self.instance}: on_initialize failed: {failure}") from failure.error
        self.is_alive = True
        for context in self.contexts.values():
            context.add_component(self)
            context.start()

    def finalize(self) -> None:
        """Come to an end: deactivate, stop own contexts, leave all, on_finalize.

        Others that its own contexts drive are deactivated too and let go. No context that drives
        this component may tick meanwhile. Failures are reported.
        """
        if not self.is_alive:
            return
        for context in self.participations:
            if context is self.contexts.get(context.id):
                for participant in context.participants:
                    context.deactivate_component(participant)
                context.stop()
                context.serve_requests()
                for participant in context.participants:
                    context.remove_component(participant)
            else:
                context.remove_component(self)
        failure = attempt(self.on_finalize)
        if failure:
            self.report(f"on_finalize failed: {failure}")
        self.is_alive = False

    def _wanted_contexts(self) -> tuple[ContextPattern, ...]:
        return wanted_contexts(self.options, self.rate, self.execution_type)

    def _add(self, port: AnyPort) -> AnyPort:
        if port.name in self.ports or not port.name:
            reason = "exists already" if port.name else "needs a name"
            raise Refused(f"{self.instance}: port {port.name or repr('')} {reason}")
        check_port_name(port.name)
        self._merge_defaults(port)
        if isinstance(port, ServicePort):
            port.belong_to(self)
        self.ports = {**self.ports, port.name: port}
        self._listen()
        return port

    def _merge_defaults(self, port: Port) -> None:
        is_service = isinstance(port, ServicePort)
        kind = _PORT_KINDS[2 if is_service else isinstance(port, OutPort)]
        for key, value in self.options.items():
            head, _, tail = key.partition(".")
            if head == "dataport" and not is_service:
                port.properties[key] = value
            elif head == "port":
                group, _, rest = tail.partition(".")
                if group not in _PORT_KINDS:
                    port.properties[key] = value
                elif group == kind:
                    own = rest.removeprefix(f"{port.name}.")
                    if own != rest or rest.startswith("dataport."):
                        port.properties[own] = value

    def _configure(self) -> None:
        configuration = self.configuration
        hints: dict[str, dict[str, str]] = {}
        for parameter in self._parameters.values():
            configuration.bind(parameter.name, parameter.default)
            texts = {
                "__widget__": parameter.widget,
                "__constraints__": parameter.constraint,
                "__description__": parameter.description,
                "__type__": kind_of(parameter.default).name,
            }
            for set_id, text in texts.items():
                if text:
                    hints.setdefault(set_id, {})[parameter.name] = text
        for set_id, values in hints.items():
            configuration.declare(set_id, values)
        for parameter in self._parameters.values():
            for set_id, text in parameter.sets.items():
                configuration.declare(set_id, {parameter.name: text})
        self._declare_options()
        configuration.activate(self.options.get(ACTIVE_SET, "") or DEFAULT)
        configuration.update()

    def _declare_options(self) -> None:
        given: dict[str, dict[str, str]] = {}
        for key, value in self.options.items():
            if key.startswith("conf."):
                set_id, _, name = key.removeprefix("conf.").partition(".")
                if set_id and name:
                    given.setdefault(set_id, {})[name] = value
        for set_id, values in given.items():
            self.configuration.declare(set_id, values)
        for set_id, values in given.items():
            why = self.configuration.misfits(set_id, values)
            if why:
                raise Malformed(f"{self.instance}: conf.{set_id}: {why}")

    def keep_failure(self, callback: str, failure: Failure) -> None:
        """Keep and log the failure that led to Error; called by the context that drives it."""
        self.cause = str(failure)
        self.logger.error("%s failed: %s", callback, failure, exc_info=failure.error)

    def _log(self, text: str) -> None:
        self.logger.warning(text)
