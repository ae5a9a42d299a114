"""Statements of a system profile without its layout, for comparing a file with a saved one.

Port names lose their instance prefix; drawings, dates and rtkit's own properties do not count.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from rtkit.deployment.described import properties_of, sets_of
from rtkit.profile.rts_model import ComponentInstance, RtsProfile, TargetPort
from rtkit.profile.words import strip_instance


class StatedComponent(NamedTuple):
    """Statements about one component; data types of ports are empty where none is stated."""

    id: str
    data_ports: Mapping[str, str]
    service_ports: frozenset[str]
    active_set: str | None
    parameters: Mapping[str, Mapping[str, str]]
    contexts: tuple[tuple[str, str, float | None], ...]


class StatedConnector(NamedTuple):
    """Statements about one connector: name, attributes and ends."""

    name: str
    attributes: tuple[str | None, ...]
    source: tuple[str, str]
    target: tuple[str, str]


class Stated(NamedTuple):
    """Statements of a profile, by instance name and by connector id."""

    components: Mapping[str, StatedComponent]
    connectors: Mapping[str, StatedConnector]


def stated(profile: RtsProfile) -> Stated:
    """Return what a profile states."""
    connectors = {
        connector.connector_id: StatedConnector(
            connector.name,
            (
                connector.data_type,
                connector.interface_type,
                connector.dataflow_type,
                connector.subscription_type,
                f"{connector.push_interval or 0:g}",
            ),
            _end(connector.source),
            _end(connector.target),
        )
        for connector in profile.data_port_connectors
    }
    for service in profile.service_port_connectors:
        connectors[service.connector_id] = StatedConnector(
            service.name, (), _end(service.source), _end(service.target)
        )
    return Stated({c.instance_name: _component(c) for c in profile.components}, connectors)


def _component(component: ComponentInstance) -> StatedComponent:
    instance = component.instance_name
    return StatedComponent(
        component.id,
        {
            strip_instance(port.name, instance): properties_of(port.properties).get(
                "dataport.data_type", ""
            )
            for port in component.data_ports
        },
        frozenset(strip_instance(port.name, instance) for port in component.service_ports),
        component.active_configuration_set,
        sets_of(component.configuration_sets),
        tuple((c.id, c.kind, c.rate) for c in component.execution_contexts),
    )


def _end(end: TargetPort) -> tuple[str, str]:
    return end.instance_name, strip_instance(end.port_name, end.instance_name)
