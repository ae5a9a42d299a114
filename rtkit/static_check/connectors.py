"""Checks data connectors: their directions, data types, and the offers of their ports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import product

from rtkit.component.ports.options import parse_options, remarks
from rtkit.component.ports.port_matching import ANY_DATA_TYPE
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

_USUAL = {DATAFLOW: frozenset(("push", "pull")), SUBSCRIPTION: frozenset(SUBSCRIPTIONS)}
_UNKNOWN = "unknown connector property"
_At = tuple[ProfileLocation, str]  # and what stands there


def connector_findings(view: View) -> Iterator[StaticFinding]:
    """Yield what is wrong with the data connectors."""
    for number, connector in enumerate(view.profile.data_port_connectors):
        place = TOP.below("data_port_connectors", number)
        yield from _CheckedConnector(view, connector, place).findings()


class _CheckedConnector:
    """A data connector with what is known of its ends."""

    def __init__(self, view: View, connector: DataPortConnector, place: ProfileLocation) -> None:
        self._view = view
        self._connector = connector
        self._place = place
        self._id = f"connector {connector.connector_id}"
        self._ends = (view.data_end(connector.source), view.data_end(connector.target))

    def findings(self) -> Iterator[StaticFinding]:
        wrong = list(self._directions())
        yield from wrong
        if all(each.severity == NOTE for each in wrong):
            yield from self._types()
        yield from self._properties()
        yield from self._direct()
        for key in OFFERS:
            if key != SUBSCRIPTION or self._is_pushed():
                yield from self._offers(key)

    def _found(
        self, rule: str, text: str, at: _At, allowed: str = "", by: Iterable[DataEnd] = ()
    ) -> StaticFinding:
        """Return a finding: an error where an RTC profile states what one of these ends is like."""
        severity = ERROR if any(end.is_declared for end in by) else WARNING
        return StaticFinding(severity, rule, f"{self._id}{text}", *at, allowed)

    def _port(self, number: int) -> _At:
        """Return where the port at one end is named, and its name."""
        where = self._place.below(("source", "target")[number]).at("port_name")
        return where, self._ends[number].name

    def _properties(self) -> Iterator[StaticFinding]:
        """Yield properties that are not known, and values that are refused when it is made."""
        connector = self._connector
        stated_all = list(connector.properties)
        if connector.push_interval and property_value(stated_all, PUSH_INTERVAL) is None:
            stated_all.append(ExtensionProperty(PUSH_INTERVAL, f"{connector.push_interval:g}"))
        for each in stated_all:
            value = each.value or ""
            odd = [t for t in remarks({each.name: value}) if t.startswith(_UNKNOWN)]
            severity = WARNING
            try:
                parse_options({each.name: value})
            except Malformed as error:
                odd, severity = [str(error)], ERROR
            stated = property_place(self._place, connector.properties, each.name)
            at = self._place.at("push_interval") if stated is None else stated[0], value
            for text in odd:
                found = self._found("connector-property", f": {text}", at)
                yield found._replace(severity=severity)

    def _direct(self) -> Iterator[StaticFinding]:
        """Yield that it is for ports of one process, and its ends are made in two."""
        for at in self._stated(INTERFACE):
            ends = [self._connector.source.instance_name, self._connector.target.instance_name]
            places = [self._view.process_of(name) for name in ends]
            if interface_name(at[1]) == DIRECT and None not in places and places[0] != places[1]:
                known = [place or "the manager" for place in places]
                where = ", ".join(map("{} in {}".format, ends, known))
                text = f": interface type direct joins ports of one process: {where}"
                yield self._found("interface-type", text, at)._replace(severity=ERROR)

    def _directions(self) -> Iterator[StaticFinding]:
        source, target = self._ends
        sources, targets = kinds_of(source.ports), kinds_of(target.ports)
        fitting = [pair for pair in product(sources, targets) if types_fit(pair)]
        if not sources or not targets or not all(map(are_reversed, fitting)):
            return
        if fitting:
            from_to = f"taken from {target.name} to {source.name}"
            text = f" names its in port {source.name} first: {from_to}"
            found = self._found("connector-reversed", text, self._port(0), target.name)
            yield found._replace(severity=NOTE)
            return
        is_out = PortType.OUT in sources
        word, other = ("out", "in") if is_out else ("in", "out")
        text = f" joins two {word} ports, {source.name} and {target.name}"
        at, allowed = self._port(is_out), f"an {other} port"
        yield self._found("connector-direction", text, at, allowed, self._ends)

    def _types(self) -> Iterator[StaticFinding]:
        source, target = self._ends
        forced = property_value(self._connector.properties, ANY_DATA_TYPE) or ""
        if forced.strip().upper() == "YES":
            return
        is_known = source.ports and target.ports
        if is_known and not any(fits_type(port.data_type, target.ports) for port in source.ports):
            carried, taken = type_names(source.ports), type_names(target.ports)
            text = f": {source.name} carries {carried}, {target.name} carries {taken}"
            yield self._found("data-type", text, (self._port(1)[0], taken), carried, self._ends)
            return
        for at in self._stated("data_type"):
            for end in self._ends:
                if (type := at[1]) and end.ports and not fits_type(type, end.ports):
                    known = type_names(end.ports)
                    text = f" is for {scoped_name(type)}, but {end.name} carries {known}"
                    yield self._found("data-type", text, at, known, [end])
                    return

    def _offers(self, key: str) -> Iterator[StaticFinding]:
        what, rule = key.replace("_", " "), key.replace("_", "-")
        for at in self._stated(key):
            wanted = words(key, at[1])
            offers = [(end, end.offers(key)) for end in self._ends if wanted]
            lacking = [end for end, each in offers if each and not wanted & each]
            if lacking:
                names = " and ".join(end.name for end in lacking)
                verb = "does" if len(lacking) == 1 else "do"
                text = f": {names} {verb} not offer {what} {at[1]}"
                yield self._found(rule, text, at, _common(lacking, key), lacking)
            usual = _USUAL.get(key)
            if usual and wanted and not lacking and not wanted & usual:
                text = f" has an unusual {what}: {at[1]}"
                yield self._found(rule, text, at, ", ".join(sorted(usual)))

    def _stated(self, field: str) -> list[_At]:
        """Return what is stated and where: by the property, which counts, and by the attribute."""
        attribute = getattr(self._connector, field) or ""
        found = property_place(self._place, self._connector.properties, f"dataport.{field}")
        stated = [] if found is None else [found]
        is_other = found is None or found[1].strip().lower() != attribute.strip().lower()
        return [*stated, (self._place.at(field), attribute)] if attribute and is_other else stated

    def _is_pushed(self) -> bool:
        stated = property_value(self._connector.properties, "dataport.dataflow_type")
        return (stated or self._connector.dataflow_type).strip().lower() in ("push", "")


def _common(ends: list[DataEnd], key: str) -> str:
    """Return what all of these ends offer, else what each does."""
    offers = [end.offers(key) for end in ends]
    both = frozenset.intersection(*offers)
    return ", ".join(sorted(both)) or "; ".join(", ".join(sorted(each)) for each in offers)
