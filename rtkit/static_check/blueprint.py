"""Blueprints: the statements of an RTC profile about its type, ready for comparison."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

from rtkit.component.configuration.constraint_check import Declared, declared_type
from rtkit.fast_dataclass import dataclass
from rtkit.profile.constraint_text import format_constraint
from rtkit.profile.ports import declared_interfaces
from rtkit.profile.rtc_model import ConfigurationParameter, DataPortDeclaration, RtcProfile
from rtkit.profile.words import property_value
from rtkit.rtc.connector_properties import canonical
from rtkit.rtc.enums import ExecutionKind, PortType
from rtkit.rtc.port_types import declared_port_type
from rtkit.rtc.profiles import PortInterfaceProfile, TypeProfile

INTERFACE, DATAFLOW, SUBSCRIPTION = "interface_type", "dataflow_type", "subscription_type"
OFFERS = (INTERFACE, DATAFLOW, SUBSCRIPTION)
"""Properties that connectors require of data ports."""
_REMEMBERED = 1024  # the same few texts stand at thousands of ports
_ANYTHING = frozenset(("any", ""))
_LIST_WIDGETS = ("checkbox", "ordered_list")


class DataPortType(NamedTuple):
    """A data port of the type.

    Attributes:
        data_type: As the profile writes it.
        offers: Words by `INTERFACE`, `DATAFLOW` and `SUBSCRIPTION`; none where it leaves that open.
    """

    kind: PortType
    data_type: str
    offers: Mapping[str, frozenset[str]]


class ParameterType(NamedTuple):
    """A configuration parameter of the type."""

    declared: Declared
    default: str


@dataclass(frozen=True, slots=True)
class Blueprint:
    """A component type.

    Attributes:
        source: The file of the profile.
        data_ports: By name; a name may be that of an in and of an out port.
        kind: Of its execution context; None where the profile names a type that may be of any.
        rate: Of its execution context [Hz]; 0 where none is given.
    """

    source: str
    type: TypeProfile
    data_ports: Mapping[str, tuple[DataPortType, ...]]
    service_ports: Mapping[str, tuple[PortInterfaceProfile, ...]]
    parameters: Mapping[str, ParameterType]
    kind: ExecutionKind | None
    rate: float

    def is_same(self, other: Blueprint) -> bool:
        """Return whether another file states the same of the type."""
        return self.contents == other.contents

    @property
    def contents(self) -> tuple[object, ...]:
        """All but the file."""
        ports = (self.data_ports, self.service_ports)
        return (self.type.id, *ports, self.parameters, self.kind, self.rate)


def blueprint(profile: RtcProfile, type: TypeProfile, source: str) -> Blueprint:
    """Return what a profile states of the components of `type`."""
    data: dict[str, tuple[DataPortType, ...]] = {}
    for port in profile.data_ports:
        data[port.name] = (*data.get(port.name, ()), _data_port(port))
    declared = profile.configuration_set
    parameters = declared.configurations if declared is not None else ()
    info = profile.basic_info
    return Blueprint(
        source,
        type,
        data,
        {port.name: declared_interfaces(port) for port in profile.service_ports},
        {each.name: _parameter(each) for each in parameters},
        _context_kind(info.execution_type if info is not None else ""),
        (info.execution_rate if info is not None else None) or 0.0,
    )


@lru_cache(_REMEMBERED)
def words(key: str, text: str | None) -> frozenset[str]:
    """Return the words of a list like ``push,pull``; none where it leaves everything open."""
    return frozenset(canonical(f"dataport.{key}", word) for word in _split(text))


@lru_cache(_REMEMBERED)
def offered(key: str, text: str | None) -> frozenset[str]:
    """Return the words that a connector may use where a port offers these."""
    found, known = _split(text), words(key, text)
    # A port offers within its own process all that it offers to others.
    is_remote = key == INTERFACE and "zenoh" in known
    return found | known | ({"direct"} if is_remote else set())


def _split(text: str | None) -> frozenset[str]:
    found = frozenset(word.lower() for word in re.split(r"[\s,/|]+", (text or "").strip()))
    return frozenset() if found & _ANYTHING else found


def _data_port(port: DataPortDeclaration) -> DataPortType:
    texts = (port.interface_type, port.dataflow_type, port.subscription_type)
    offers = {key: offered(key, text) for key, text in zip(OFFERS, texts, strict=True)}
    return DataPortType(declared_port_type(port.port_type), port.type, offers)


def _parameter(configuration: ConfigurationParameter) -> ParameterType:
    constraint = configuration.constraint
    rule = format_constraint(constraint) if constraint is not None else ""
    widget = property_value(configuration.properties, "__widget__") or ""
    is_list = widget.startswith(_LIST_WIDGETS)
    type = declared_type(configuration.type, configuration.default_value)
    return ParameterType(Declared(type, rule, constraint, is_list), configuration.default_value)


def _context_kind(execution_type: str) -> ExecutionKind | None:
    word = execution_type.strip().lower()
    if word.startswith("periodic"):
        return ExecutionKind.PERIODIC
    return ExecutionKind.EVENT_DRIVEN if word.startswith("eventdriven") else None
