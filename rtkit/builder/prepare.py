"""Prepares the generation of a component: settles names, types and values of its RTC profile."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields

from rtkit.builder import standard_types
from rtkit.builder.identifiers import Taken, attribute_name, class_name, cut, module_name, type_name
from rtkit.builder.machine_of_profile import machine_of
from rtkit.builder.obstacles import of_interface, of_type
from rtkit.builder.settings import settings_of, unused
from rtkit.builder.source_text import one_line, width
from rtkit.builder.subject import (
    Callback,
    GeneratedComponent,
    GeneratedInterface,
    GeneratedPort,
    GeneratedServicePort,
    GeneratedStateMachine,
    StateClass,
)
from rtkit.builder.types_code import TypesCode
from rtkit.component.base import Component
from rtkit.component.contexts.owned_contexts import PERIODIC, kind_named
from rtkit.component.fsm import FsmComponent, State
from rtkit.component.state_table import lineage
from rtkit.errors import Refused
from rtkit.idl.model import Definitions, InterfaceDeclaration, Named, Path
from rtkit.profile.rtc_model import (
    Actions,
    BasicInfo,
    DataPortDeclaration,
    RtcProfile,
    ServiceInterface,
    ServicePortDeclaration,
)
from rtkit.rtc.names import near_port_name

NOTHING = Definitions({})
EVENT_PORT = "EventPort"
_KINDS = {"DataInPort": "InPort", "DataOutPort": "OutPort", EVENT_PORT: EVENT_PORT}
_HELP = "-I DIR tells where IDL files are"
_WIDEST_METHOD = 28
_IN_CLASS = ("ClassVar", "TYPE_CHECKING", "I", "O", "idl", "images", "l", "rt", "super")


@dataclass(slots=True)
class Sources:
    """Inputs of the generation besides the profile.

    Attributes:
        stem: Name of the profile's file, for one that does not say whom it describes.
        definitions: Declarations of its IDL files.
        drawn: States of its machine, where a drawing is at hand.
    """

    stem: str = "Component"
    definitions: Definitions = NOTHING
    drawn: Mapping[str, Mapping[str, str]] | None = None


def idl_files(profile: RtcProfile) -> Iterator[str]:
    """Yield the IDL files that the profile names for types that rtkit does not know already."""
    for port in profile.data_ports:
        path = standard_types.path_of(port.type)
        if path and path not in standard_types.KNOWN and port.idl_file:
            yield port.idl_file
    for service in profile.service_ports:
        for each in service.service_interfaces:
            if each.idl_file:
                yield each.idl_file


def undefined(profile: RtcProfile, definitions: Definitions) -> list[str]:
    """Return the types that ports and services name, and that nothing known declares."""
    services = (each for port in profile.service_ports for each in port.service_interfaces)
    texts = [*_data_types(profile), *(each.type for each in services)]
    return [text for text in dict.fromkeys(texts) if not is_declared(text, definitions)]


def _data_types(profile: RtcProfile) -> Iterator[str]:
    """Yield the types of all data ports and events, as the profile names them."""
    for port in profile.data_ports:
        yield port.type
        yield from (event.type or "" for event in port.events)


def is_declared(text: str, definitions: Definitions) -> bool:
    """Return whether a type, as profiles name it, is declared or built in; "" is any type."""
    path = standard_types.path_of(text)
    return not path or path in standard_types.KNOWN or bool(_full(path, definitions))


def prepare(profile: RtcProfile, sources: Sources) -> tuple[GeneratedComponent, TypesCode]:
    """Return the component to generate for a profile, and its types."""
    return _Preparation(profile, sources).run()


@dataclass(slots=True)
class _Preparation:
    profile: RtcProfile
    sources: Sources
    notes: list[str] = field(default_factory=list)
    classes: set[str] = field(default_factory=set)
    event_port: DataPortDeclaration | None = None
    names: set[str] = field(default_factory=set)
    methods: set[str] = field(default_factory=set)
    types: TypesCode = field(init=False)
    taken: Taken = field(init=False)

    def run(self) -> tuple[GeneratedComponent, TypesCode]:
        profile = self.profile
        info = profile.basic_info or _unnamed(self.sources.stem)
        if profile.basic_info is None:
            self.notes.append(f"a fragment: it is called {info.name} after its file")
        own = self._type_name(info)
        self.types = TypesCode(self.sources.definitions, self._wanted())
        self.classes.add(class_name(own))
        machine = self._machine()
        self.taken = Taken([*_attributes(machine is not None), *_IN_CLASS, class_name(own)])
        self.names |= {machine.port} if machine else set()
        ports, services = tuple(self._ports()), tuple(self._services())
        subject = GeneratedComponent(
            profile=profile,
            info=info,
            type_name=own,
            module=module_name(own),
            class_name=class_name(own),
            description=one_line(info.description),
            execution_type=self._execution_type(info),
            rate=self._rate(info),
            ports=ports,
            services=services,
            settings=settings_of(profile, self.taken, self.notes.append),
            callbacks=tuple(_callbacks(profile.actions, machine is not None)),
            machine=machine,
            has_types=_uses_types(ports, services, machine),
            notes=tuple(dict.fromkeys(self.notes)),
        )
        return subject, self.types

    def _type_name(self, info: BasicInfo) -> str:
        name = type_name(info.name, class_name(self.sources.stem))
        if name != info.name:
            self.notes.append(f"{info.name!r} can be no name of a type; it is called {name}")
        self.notes += cut("type", name, class_name(name))
        return name

    def _wanted(self) -> Iterator[Path]:
        """Yield the needed declarations of the interface definitions that rtkit can carry."""
        definitions = self.sources.definitions
        for text in _data_types(self.profile):
            path = self._declared(text)
            if path and not of_type(definitions, Named(path)):
                yield path
        for service in self.profile.service_ports:
            for each in service.service_interfaces:
                found = self._interface(each)
                if found is not None and not of_interface(definitions, found):
                    yield found.path

    def _declared(self, text: str) -> Path:
        """Return the path of a data type that the interface definitions declare."""
        path = standard_types.path_of(text)
        if not path or path in standard_types.KNOWN:
            return ()
        return _full(path, self.sources.definitions)

    def _interface(self, each: ServiceInterface) -> InterfaceDeclaration | None:
        path = _full(standard_types.path_of(each.type), self.sources.definitions)
        found = self.sources.definitions.by_path.get(path)
        return found if isinstance(found, InterfaceDeclaration) else None

    def _execution_type(self, info: BasicInfo) -> str:
        name = info.execution_type.strip()
        try:
            kind_named(name or PERIODIC)
        except Refused as error:
            self.notes.append(f"{error}; it is {PERIODIC}")
            return PERIODIC
        return name or PERIODIC

    def _rate(self, info: BasicInfo) -> float:
        rate = info.execution_rate or 0.0
        if rate < 0:
            self.notes.append(f"a rate of {rate:g} Hz is none; it is left out")
        return max(rate, 0.0)

    def _machine(self) -> GeneratedStateMachine | None:
        """Return the machine of the first event port that has one."""
        for port in self._event_ports():
            found = machine_of(
                port,
                self.sources.drawn,
                lambda text: self._type(text, "an event")[0],
                self.notes.append,
            )
            if found is not None:
                self.event_port = port
                return found._replace(classes=tuple(self._state_classes(found)))
        return None

    def _state_classes(self, machine: GeneratedStateMachine) -> Iterator[StateClass]:
        states = [reversed(list(lineage(state))) for state in machine.states]
        for state in dict.fromkeys(each for line in states for each in line):
            taken = Taken([*dir(State), "component", *_IN_CLASS])
            moves = tuple(
                (taken.add(_method_name(event)), event, target)
                for event, target in machine.states.get(state, {}).items()
            )
            yield StateClass(state, unused(class_name(state), self.classes, ""), moves)

    def _event_ports(self) -> list[DataPortDeclaration]:
        return [each for each in self.profile.data_ports if each.port_type == EVENT_PORT]

    def _ports(self) -> Iterator[GeneratedPort]:
        for each in self.profile.data_ports:
            if each is self.event_port:
                continue
            name, attribute = self._port_name(each)
            text = "" if each.port_type == EVENT_PORT else each.type
            type, type_name = self._type(text, f"port {name}")
            yield GeneratedPort(attribute, name, _KINDS[each.port_type], type, type_name, each)

    def _port_name(self, each: DataPortDeclaration | ServicePortDeclaration) -> tuple[str, str]:
        """Return the name that a port has, and that of its attribute."""
        allowed = near_port_name(each.name)
        name = unused(allowed or "port", self.names)
        if name != each.name:
            why = "its name is taken" if each.name else "it has no name"
            if allowed != each.name:
                why = "no port may be called so"
            self.notes.append(f"port {each.name!r} is called {name}: {why}")
        attribute = self.taken.add(attribute_name(name, "port"))
        self.notes += cut("port", name, attribute)
        return name, attribute

    def _type(self, text: str, where: str) -> tuple[str, str]:
        """Return the expression of a data type, and the name that its values travel under."""
        path = standard_types.path_of(text)
        if not path:
            return "bytes", "any"
        full = self._declared(text) or path
        name = f"IDL:{'/'.join(full)}:1.0"
        known = standard_types.expression(path)
        if known:
            return known, name
        why = of_type(self.sources.definitions, Named(full))
        if not why:
            return f"idl.{self.types.name(full)}", name
        help = "" if is_declared(text, self.sources.definitions) else f" ({_HELP})"
        self.notes.append(f"{where}: {why}; values of that type pass as bytes{help}")
        return "bytes", name

    def _services(self) -> Iterator[GeneratedServicePort]:
        for each in self.profile.service_ports:
            name, attribute = self._port_name(each)
            offers = tuple(self._offer(offer, name) for offer in each.service_interfaces)
            yield GeneratedServicePort(attribute, name, offers, each)

    def _offer(self, each: ServiceInterface, port: str) -> GeneratedInterface:
        is_provided = each.direction == "Provided"
        name, type_name = each.name, "::".join(standard_types.path_of(each.type))
        found = self._interface(each)
        file = (each.idl_file or "").replace("\\", "/").rpartition("/")[2]
        why = f"{file} was not found" if file else "no IDL file declares it"
        why += f" ({_HELP})"
        if found is not None:
            why = of_interface(self.sources.definitions, found)
        if found is None or why:
            self.notes.append(f"port {port}: {type_name or '(no type)'}: {why}; described only")
            return GeneratedInterface(name, type_name or "Unknown", is_provided)
        methods = tuple(self.types.methods(found.path)) if is_provided else ()
        servant = ""
        if any(method.name in self.taken or method.name in self.methods for method in methods):
            preferred = f"{class_name(port)}{class_name(found.path[-1])}"
            servant = unused(preferred, self.classes, "")
        else:
            self.methods |= {self.taken.add(method.name) for method in methods}
        protocol = f"idl.{self.types.name(found.path)}"
        return GeneratedInterface(
            name, "::".join(found.path), is_provided, protocol, methods, servant
        )


def _uses_types(
    ports: tuple[GeneratedPort, ...],
    services: tuple[GeneratedServicePort, ...],
    machine: GeneratedStateMachine | None,
) -> bool:
    expressions = [port.type for port in ports]
    expressions += [event.type for event in machine.events] if machine else []
    expressions += [offer.protocol for service in services for offer in service.offers]
    return any(each.startswith("idl.") for each in expressions)


def _method_name(event: str) -> str:
    """Return the name of the method for an event; short, because marks have it behind a class."""
    name = attribute_name(event, "event")
    while width(name) > _WIDEST_METHOD:
        name = name[:-1]
    return name.rstrip("_") or "event"


def _unnamed(stem: str) -> BasicInfo:
    return BasicInfo(stem, "STATIC", "PERIODIC", "DataFlowComponent", "", "", "", PERIODIC, "", "")


def _attributes(has_machine: bool) -> set[str]:
    """Return the names that every component has."""
    if not has_machine:
        return set(dir(Component("x")))
    one = type("Any", (FsmComponent,), {"states": {"A": {}}})
    return set(dir(one("x")))


def _callbacks(actions: Actions | None, has_machine: bool) -> Iterator[Callback]:
    for each in fields(Actions):
        status = getattr(actions, each.name) if actions is not None else None
        if each.name in ("foreign", "on_mode_changed") or status is None or not status.implemented:
            continue
        if each.name != "on_action" or has_machine:
            yield Callback(each.name, status)


def _full(path: Path, definitions: Definitions) -> Path:
    """Return the path that a name stands for; one without module may be that of any module."""
    if path in definitions.by_path:
        return path
    if len(path) != 1:
        return ()
    matches = [each for each in definitions.by_path if each[-1:] == path]
    return matches[0] if len(matches) == 1 else ()
