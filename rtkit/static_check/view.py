"""View of a system profile for the rules: components with their types, ports with their offers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from rtkit.deployment.described import properties_of
from rtkit.deployment.extension import CREATE
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import ComponentInstance, RtsProfile, TargetPort
from rtkit.profile.words import strip_instance
from rtkit.rtc.create import FRESH_SLAVE, CreateString, readable_create
from rtkit.rtc.enums import PortType
from rtkit.rtc.port_types import stated_port_type
from rtkit.rtc.profiles import PortInterfaceProfile
from rtkit.static_check.blueprint import OFFERS, Blueprint, DataPortType, offered
from rtkit.static_check.catalogue import Catalogue, Match
from rtkit.static_check.finding import TOP, ProfileLocation


class CheckedComponent(NamedTuple):
    """A component of the system; `match` is None where no RTC profile is known."""

    component: ComponentInstance
    place: ProfileLocation
    match: Match | None

    @property
    def blueprint(self) -> Blueprint | None:
        """Return the blueprint of its type, as far as that is known."""
        return self.match.blueprint if self.match is not None else None

    @property
    def name(self) -> str:
        """Its instance name."""
        return self.component.instance_name

    @property
    def create(self) -> CreateString:
        """Its create string; one without a type where none is stated, or it cannot be read."""
        return readable_create(properties_of(self.component.properties).get(CREATE, ""))

    @property
    def is_composite(self) -> bool:
        """Return whether it shows ports of its members."""
        kind = self.component.composite_type or "None"
        return kind != "None" or bool(self.component.participants)


class DataEnd(NamedTuple):
    """A data port at the end of a connector.

    Attributes:
        ports: Allowed names behind the colon; none where nobody knows.
        is_declared: An RTC profile states it, not only the system profile.
        stated: Offers of the port by the system profile.
    """

    name: str
    ports: tuple[DataPortType, ...]
    is_declared: bool
    stated: Mapping[str, frozenset[str]]

    def offers(self, key: str) -> frozenset[str]:
        """Return the words that a connector may use; none where everything is left open."""
        declared = [port.offers[key] for port in self.ports if key in port.offers]
        if declared and all(declared):
            return frozenset[str]().union(*declared)
        return self.stated.get(key, frozenset())


class ServiceEnd(NamedTuple):
    """A service port at the end of a connector; `interfaces` is None where nobody knows them."""

    name: str
    owner: tuple[str, str]
    port: str
    interfaces: tuple[PortInterfaceProfile, ...] | None


class _Stated(NamedTuple):
    """Statements of a system profile about a data port itself."""

    ports: tuple[DataPortType, ...]
    offers: Mapping[str, frozenset[str]]


_NOTHING = _Stated((), {})


class View:
    """A system profile and the types of its components.

    Attributes:
        parts: Its components, in the order of the profile.
    """

    def __init__(self, profile: RtsProfile, catalogue: Catalogue) -> None:
        self.profile = profile
        self.catalogue = catalogue
        self.parts = tuple(
            CheckedComponent(
                component, TOP.below("components", number), catalogue.find(component.id)
            )
            for number, component in enumerate(profile.components)
        )
        self._parts = {(each.component.id, each.name): each for each in self.parts}
        self._by_name = {each.name: each for each in reversed(self.parts)}
        self._stated = dict(self._statements())

    def data_end(self, end: TargetPort) -> DataEnd:
        """Return what is known of a data port that a connector joins."""
        name = strip_instance(end.port_name, end.instance_name)
        shown = f"{end.instance_name}.{name}"
        stated = self._stated.get((end.component_id, end.instance_name, name), _NOTHING)
        owner, port = self._resolved(end)
        known = owner.blueprint.data_ports.get(port) if owner and owner.blueprint else None
        if known is not None:
            return DataEnd(shown, known, True, stated.offers)
        return DataEnd(shown, stated.ports, False, stated.offers)

    def service_end(self, end: TargetPort) -> ServiceEnd:
        """Return what is known of a service port that a connector joins."""
        shown = f"{end.instance_name}.{strip_instance(end.port_name, end.instance_name)}"
        owner, port = self._resolved(end)
        if owner is None:
            return ServiceEnd(shown, (end.component_id, end.instance_name), port, None)
        key = (owner.component.id, owner.name)
        if owner.blueprint is None:
            return ServiceEnd(shown, key, port, None)
        return ServiceEnd(shown, key, port, owner.blueprint.service_ports.get(port))

    def process_of(self, name: str) -> str | None:
        """Return the slave in which a component is made, empty for the manager; None if unknown."""
        part = self._by_name.get(name)
        if part is None or not part.create.implementation_id:
            return None
        place = part.create.place
        return f"a slave of its own ({name})" if place == FRESH_SLAVE else place

    def has_port(self, part: CheckedComponent, name: str) -> bool:
        """Return whether a composite shows a port of this name, which is one of a member."""
        return part.is_composite and self._member(name)[0] is not None

    def _statements(self) -> Iterator[tuple[tuple[str, str, str], _Stated]]:
        """Yield what the system profile states of data ports itself."""
        for part in self.parts:
            for port in part.component.data_ports:
                stated = {each.name: each.value or "" for each in port.properties}
                kind = stated_port_type(stated.get("port.port_type", ""))
                type = stated.get("dataport.data_type", "")
                offers = {key: offered(key, stated.get(f"dataport.{key}")) for key in OFFERS}
                ports = (DataPortType(kind, type, {}),) if kind is not None else ()
                name = strip_instance(port.name, part.name)
                yield (part.component.id, part.name, name), _Stated(ports, offers)

    def _resolved(self, end: TargetPort) -> tuple[CheckedComponent | None, str]:
        """Return whose port it is, which for a port that a composite shows is its member."""
        part = self._parts.get((end.component_id, end.instance_name))
        port = strip_instance(end.port_name, end.instance_name)
        if part is None or not part.is_composite:
            return part, port
        if part.blueprint is not None and _has(part.blueprint, port):
            return part, port
        member, own = self._member(port)
        return (member, own) if member is not None else (part, port)

    def _member(self, name: str) -> tuple[CheckedComponent | None, str]:
        """Return the component and port that ``INSTANCE.PORT`` names, through nested composites."""
        part: CheckedComponent | None = None
        while "." in name:
            instance, _, rest = name.partition(".")
            found = self._by_name.get(instance)
            if found is None:
                break
            part, name = found, rest
        return part, name


def _has(blueprint: Blueprint, port: str) -> bool:
    return port in blueprint.data_ports or port in blueprint.service_ports


def kinds_of(ports: tuple[DataPortType, ...]) -> set[PortType]:
    """Return the directions that a name stands for."""
    return {port.kind for port in ports}


def property_place(
    place: ProfileLocation, properties: Sequence[ExtensionProperty], name: str
) -> tuple[ProfileLocation, str] | None:
    """Return where a property is written and its value; None where it is missing or empty."""
    for number, each in enumerate(properties):
        if each.name == name:
            found = place.below("properties", number).at("value")
            return (found, each.value) if each.value else None
    return None
