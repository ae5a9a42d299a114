"""Checks data connectors: their directions, data types, and the offers of their ports."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from rtkit.component.options import parse_options, remarks
from rtkit.component.port_matching import ANY_DATA_TYPE
from rtkit.errors import Malformed
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import DataPortConnector
from rtkit.profile.words import property_value
from rtkit.report.finding import ERROR, NOTE, WARNING
from rtkit.rtc.connector_properties import DIRECT, PUSH_INTERVAL, SUBSCRIPTIONS, interface_name
from rtkit.rtc.data_types import scoped_name
from rtkit.rtc.enums import PortType
from rtkit.rtc.port_types import are_reversed, types_fit
from rtkit.static_check.blueprint import DATAFLOW, INTERFACE, OFFERS, SUBSCRIPTION, words
from rtkit.static_check.finding import TOP, ProfileLocation, StaticFinding
from rtkit.static_check.ports import fits_type, type_names
from rtkit.static_check.view import DataEnd, View, kinds_of, property_place

_USUAL = {
    DATAFLOW: frozenset(("push", "pull")),
    SUBSCRIPTION: frozenset(SUBSCRIPTIONS),
}
_RULES = {INTERFACE: "interface-type", DATAFLOW: "dataflow-type", SUBSCRIPTION: "subscription-type"}


def connector_findings(view: View) -> Iterator[StaticFinding]:
    """Yield what is wrong with the data connectors."""
    for number, connector in enumerate(view.profile.data_port_connectors):
        place = TOP.below("data_port_connectors", number)
        source, target = view.data_end(connector.source), view.data_end(connector.target)
        wrong = list(_directions(connector, place, source, target))
        yield from wrong
        if all(each.severity == NOTE for each in wrong):
            yield from _types(connector, place, source, target)
        yield from _properties(connector, place)
        yield from _direct(view, connector, place)
        for key in OFFERS:
            if key != SUBSCRIPTION or _is_pushed(connector):
                yield from _offers(connector, place, key, (source, target))


def _properties(connector: DataPortConnector, place: ProfileLocation) -> Iterator[StaticFinding]:
    """Yield properties that are not known, and values that are refused when it is made."""
    stated_all = list(connector.properties)
    if connector.push_interval and property_value(stated_all, PUSH_INTERVAL) is None:
        stated_all.append(ExtensionProperty(PUSH_INTERVAL, f"{connector.push_interval:g}"))
    for each in stated_all:
        stated = {each.name: each.value or ""}
        odd = [text for text in remarks(stated) if text.startswith("unknown connector property")]
        severity = WARNING
        try:
            parse_options(stated)
        except Malformed as error:
            odd, severity = [str(error)], ERROR
        found = property_place(place, connector.properties, each.name)
        for text in odd:
            where = place.at("push_interval") if found is None else found[0]
            told = f"connector {connector.connector_id}: {text}"
            yield StaticFinding(severity, "connector-property", told, where, each.value or "", "")


def _direct(
    view: View, connector: DataPortConnector, place: ProfileLocation
) -> Iterator[StaticFinding]:
    """Yield that a connector is for ports of one process, and its ends are made in two."""
    for where, value in _stated(connector, place, "interface_type", connector.interface_type):
        ends = [connector.source.instance_name, connector.target.instance_name]
        places = [view.process_of(name) for name in ends]
        if interface_name(value) == DIRECT and None not in places and places[0] != places[1]:
            told = ", ".join(
                f"{name} in {process or 'the manager'}"
                for name, process in zip(ends, places, strict=True)
            )
            text = f"connector {connector.connector_id}: interface type direct joins ports of one"
            yield StaticFinding(ERROR, "interface-type", f"{text} process: {told}", where, value)


def _directions(
    connector: DataPortConnector, place: ProfileLocation, source: DataEnd, target: DataEnd
) -> Iterator[StaticFinding]:
    sources, targets = kinds_of(source.ports), kinds_of(target.ports)
    fitting = [pair for pair in product(sources, targets) if types_fit(pair)]
    if not sources or not targets or not all(map(are_reversed, fitting)):
        return
    if fitting:
        text = (
            f"connector {connector.connector_id} names its in port {source.name} first:"
            f" taken from {target.name} to {source.name}"
        )
        where = place.below("source").at("port_name")
        yield StaticFinding(NOTE, "connector-reversed", text, where, source.name, target.name)
        return
    word = "out" if PortType.OUT in sources else "in"
    names = f"{source.name} and {target.name}"
    text = f"connector {connector.connector_id} joins two {word} ports, {names}"
    end, wanted = ("target", "in") if word == "out" else ("source", "out")
    where = place.below(end).at("port_name")
    found = target.name if word == "out" else source.name
    severity = ERROR if source.is_declared or target.is_declared else WARNING
    yield StaticFinding(severity, "connector-direction", text, where, found, f"an {wanted} port")


def _types(
    connector: DataPortConnector, place: ProfileLocation, source: DataEnd, target: DataEnd
) -> Iterator[StaticFinding]:
    forced = property_value(connector.properties, ANY_DATA_TYPE) or ""
    if forced.strip().upper() == "YES":
        return
    is_known = source.ports and target.ports
    if is_known and not any(fits_type(port.data_type, target.ports) for port in source.ports):
        carried, taken = type_names(source.ports), type_names(target.ports)
        text = (
            f"connector {connector.connector_id}: {source.name} carries {carried},"
            f" {target.name} carries {taken}"
        )
        severity = ERROR if source.is_declared or target.is_declared else WARNING
        where = place.below("target").at("port_name")
        yield StaticFinding(severity, "data-type", text, where, taken, carried)
        return
    for where, type in _stated(connector, place, "data_type", connector.data_type):
        for end in (source, target):
            if type and end.ports and not fits_type(type, end.ports):
                known = type_names(end.ports)
                text = (
                    f"connector {connector.connector_id} is for {scoped_name(type)},"
                    f" but {end.name} carries {known}"
                )
                severity = ERROR if end.is_declared else WARNING
                yield StaticFinding(severity, "data-type", text, where, type, known)
                return


def _offers(
    connector: DataPortConnector, place: ProfileLocation, key: str, ends: tuple[DataEnd, ...]
) -> Iterator[StaticFinding]:
    what = key.replace("_", " ")
    for where, value in _stated(connector, place, key, getattr(connector, key) or ""):
        wanted = words(key, value)
        lacking = [end for end in ends if wanted and not _is_offered(wanted, end.offers(key))]
        if lacking:
            names = " and ".join(end.name for end in lacking)
            verb = "does" if len(lacking) == 1 else "do"
            text = f"connector {connector.connector_id}: {names} {verb} not offer {what} {value}"
            severity = ERROR if any(end.is_declared for end in lacking) else WARNING
            yield StaticFinding(severity, _RULES[key], text, where, value, _common(lacking, key))
        usual = _USUAL.get(key)
        if usual and wanted and not lacking and not wanted & usual:
            text = f"connector {connector.connector_id} has an unusual {what}: {value}"
            yield StaticFinding(WARNING, _RULES[key], text, where, value, ", ".join(sorted(usual)))


def _common(ends: list[DataEnd], key: str) -> str:
    """Return what all of these ends offer, else what each does."""
    offers = [end.offers(key) for end in ends]
    both = frozenset.intersection(*offers)
    return ", ".join(sorted(both)) or "; ".join(", ".join(sorted(each)) for each in offers)


def _is_offered(wanted: frozenset[str], offered: frozenset[str]) -> bool:
    return not offered or bool(wanted & offered)


def _stated(
    connector: DataPortConnector, place: ProfileLocation, field: str, attribute: str
) -> list[tuple[ProfileLocation, str]]:
    """Return what is stated and where: by the property, which counts, and by the attribute."""
    told = property_place(place, connector.properties, f"dataport.{field}")
    stated = [] if told is None else [told]
    is_other = told is None or told[1].strip().lower() != attribute.strip().lower()
    return [*stated, (place.at(field), attribute)] if attribute and is_other else stated


def _is_pushed(connector: DataPortConnector) -> bool:
    told = property_value(connector.properties, "dataport.dataflow_type")
    return (told or connector.dataflow_type).strip().lower() in ("push", "")
