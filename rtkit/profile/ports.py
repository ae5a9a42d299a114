"""Collects direction and type of a system's data ports, from its ports and connectors."""

from __future__ import annotations

from typing import NamedTuple

from rtkit.profile.rtc_model import ServicePortDeclaration
from rtkit.profile.rts_model import DataPortConnector, RtsProfile, TargetPort
from rtkit.profile.words import normal_data_type, property_value, strip_instance
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.port_types import stated_port_type
from rtkit.rtc.profiles import PortInterfaceProfile


class DataPortKey(NamedTuple):
    """A data port of a system; `port` is its own name, without the instance."""

    component_id: str
    instance_name: str
    port: str


class DataPortFacts(NamedTuple):
    """Facts of a data port.

    Attributes:
        direction: None where neither the port nor a connector tells.
        data_type: ``IDL:module/name:version``; empty where neither does.
    """

    direction: PortType | None
    data_type: str


def data_port_facts(profile: RtsProfile) -> dict[DataPortKey, DataPortFacts]:
    """Collect direction and type of every listed data port; the port's own word comes first."""
    facts: dict[DataPortKey, DataPortFacts] = {}
    for component in profile.components:
        for port in component.data_ports:
            name = strip_instance(port.name, component.instance_name)
            direction = stated_port_type(property_value(port.properties, "port.port_type") or "")
            data_type = property_value(port.properties, "dataport.data_type") or ""
            key = DataPortKey(component.id, component.instance_name, name)
            facts[key] = DataPortFacts(direction, _known_type(data_type))
    for connector in profile.data_port_connectors:
        _learn(facts, connector, connector.source, PortType.OUT)
        _learn(facts, connector, connector.target, PortType.IN)
    return facts


def declared_interfaces(port: ServicePortDeclaration) -> tuple[PortInterfaceProfile, ...]:
    """Return the interfaces that a component profile declares of a service port."""
    return tuple(
        PortInterfaceProfile(
            each.instance_name or each.name,
            each.type,
            Polarity.PROVIDED if each.direction == Polarity.PROVIDED else Polarity.REQUIRED,
        )
        for each in port.service_interfaces
    )


def _known_type(text: str) -> str:
    normal = normal_data_type(text)
    return "" if normal.lower() == "any" else normal


def _learn(
    facts: dict[DataPortKey, DataPortFacts],
    connector: DataPortConnector,
    end: TargetPort,
    direction: PortType,
) -> None:
    port = strip_instance(end.port_name, end.instance_name)
    key = DataPortKey(end.component_id, end.instance_name, port)
    known = facts.get(key)
    if known is not None:
        facts[key] = DataPortFacts(
            known.direction or direction, known.data_type or _known_type(connector.data_type)
        )
