"""Checks service ports: interfaces and polarity at connectors, and consumers without provider."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtkit.deployment.described import stated_interfaces
from rtkit.profile.rts_model import ServicePortConnector
from rtkit.profile.words import strip_instance
from rtkit.report.finding import ERROR, WARNING
from rtkit.rtc.data_types import is_same_type
from rtkit.rtc.enums import Polarity
from rtkit.rtc.port_types import interfaces_fit, provides, shared_interfaces
from rtkit.rtc.profiles import PortInterfaceProfile
from rtkit.static_check.finding import TOP, ProfileLocation, StaticFinding
from rtkit.static_check.view import CheckedComponent, ServiceEnd, View

_Interfaces = tuple[PortInterfaceProfile, ...]
_Owner = tuple[tuple[str, str], str]
_Met = dict[_Owner, list[_Interfaces | None]]


def service_findings(view: View) -> Iterator[StaticFinding]:
    """Yield what is wrong with the service connectors, and what is required but not provided."""
    met: _Met = {}
    for number, connector in enumerate(view.profile.service_port_connectors):
        place = TOP.below("service_port_connectors", number)
        source, target = view.service_end(connector.source), view.service_end(connector.target)
        met.setdefault((source.owner, source.port), []).append(target.interfaces)
        met.setdefault((target.owner, target.port), []).append(source.interfaces)
        yield from _match(connector, place, source, target)
        yield from _stated_findings(connector, place, source, target)
    for part in view.parts:
        yield from _unmet(part, met)


def _match(
    connector: ServicePortConnector, place: ProfileLocation, source: ServiceEnd, target: ServiceEnd
) -> Iterator[StaticFinding]:
    if not source.interfaces or not target.interfaces:
        return
    if interfaces_fit(source.interfaces, target.interfaces, is_same_type):
        return
    pairs = shared_interfaces(source.interfaces, target.interfaces, is_same_type)
    which = f"connector {connector.connector_id}"
    if not pairs:
        text = (
            f"{which}: {source.name} has {_words(source.interfaces)},"
            f" {target.name} has {_words(target.interfaces)}"
        )
        found, allowed = _types(target.interfaces), _types(source.interfaces)
        where = place.below("target").at("port_name")
        yield StaticFinding(ERROR, "service-interface", text, where, found, allowed)
    else:
        mine = pairs[0][0]
        verb = mine.polarity.lower()
        text = f"{which}: both {source.name} and {target.name} have {mine.type_name} {verb}"
        where = place.below("target").at("port_name")
        other = Polarity.REQUIRED if mine.polarity is Polarity.PROVIDED else Polarity.PROVIDED
        yield StaticFinding(
            ERROR, "service-polarity", text, where, mine.polarity.value, other.value
        )


def _stated_findings(
    connector: ServicePortConnector, place: ProfileLocation, source: ServiceEnd, target: ServiceEnd
) -> Iterator[StaticFinding]:
    """Yield what properties of the connector state of interfaces that the types do not have."""
    ends = {
        (end.instance_name, strip_instance(end.port_name, end.instance_name)): known
        for end, known in ((connector.source, source), (connector.target, target))
    }
    for number, each in enumerate(connector.properties):
        for instance, port, stated in stated_interfaces({each.name: ""}):
            known = ends.get((instance, port))
            if known is None or not known.interfaces or _has(known.interfaces, stated):
                continue
            text = (
                f"connector {connector.connector_id}: {known.name} has"
                f" {_words(known.interfaces)}, not {stated.type_name} {stated.polarity.lower()}"
            )
            where = place.below("properties", number).at("name")
            rule = "service-interface"
            if any(is_same_type(stated.type_name, own.type_name) for own in known.interfaces):
                rule = "service-polarity"
            found = f"{stated.type_name} {stated.polarity.lower()}"
            yield StaticFinding(ERROR, rule, text, where, found, _words(known.interfaces))


def _has(interfaces: _Interfaces, stated: PortInterfaceProfile) -> bool:
    return any(
        is_same_type(own.type_name, stated.type_name) and own.polarity is stated.polarity
        for own in interfaces
    )


def _unmet(
    part: CheckedComponent, met: Mapping[_Owner, list[_Interfaces | None]]
) -> Iterator[StaticFinding]:
    """Yield the required interfaces that no connected port provides.

    A warning: published systems leave them open where a component can do without.
    """
    blueprint = part.blueprint
    for port, interfaces in blueprint.service_ports.items() if blueprint is not None else ():
        partners = met.get(((part.component.id, part.name), port), [])
        if None in partners:
            continue
        for each in interfaces:
            if each.polarity is not Polarity.REQUIRED or _is_provided(each, partners):
                continue
            why = "is connected to none" if partners else "is connected to nothing"
            text = f"{part.name}.{port} requires a provider of {each.type_name}, but {why}"
            allowed = f"a connector to a provider of {each.type_name}"
            yield StaticFinding(
                WARNING, "unconnected-service", text, _place(part, port), None, allowed
            )


def _is_provided(wanted: PortInterfaceProfile, partners: list[_Interfaces | None]) -> bool:
    return any(provides(each or (), (wanted,), is_same_type) for each in partners)


def _place(part: CheckedComponent, port: str) -> ProfileLocation:
    for number, each in enumerate(part.component.service_ports):
        if strip_instance(each.name, part.name) == port:
            return part.place.below("service_ports", number)
    return part.place


def _types(interfaces: _Interfaces) -> str:
    return ", ".join(each.type_name for each in interfaces)


def _words(interfaces: _Interfaces) -> str:
    return ", ".join(f"{each.type_name} {each.polarity.lower()}" for each in interfaces)
