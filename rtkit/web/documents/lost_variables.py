"""Tells which texts with variables, ``${wall}``, an edit would replace by plain values."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import DataPortConnector, RtsProfile, ServicePortConnector
from rtkit.profile_tools.system_edits import key_of

_MARK = "${"


def lost_variables(before: RtsProfile, after: RtsProfile) -> list[str]:
    """Return the texts that are gone from what is still there: ``Motor0.default.gain is ${g}``."""
    now = dict(_texts(after))
    kept = {key for key, _ in _owners(after)}
    return [
        f"{key[1]} is {text}"
        for key, text in _texts(before)
        if key[0] in kept and now.get(key) != text
    ]


_Key = tuple[object, str]
_Connector = DataPortConnector | ServicePortConnector


def _owners(profile: RtsProfile) -> Iterator[tuple[object, object]]:
    yield from ((key_of(each), each) for each in profile.components)
    yield from ((each.connector_id, each) for each in _connectors(profile))


def _connectors(profile: RtsProfile) -> Iterable[_Connector]:
    yield from profile.data_port_connectors
    yield from profile.service_port_connectors


def _texts(profile: RtsProfile) -> Iterator[tuple[_Key, str]]:
    for component in profile.components:
        owner, name = key_of(component), component.instance_name
        yield from _stated(owner, name, component.properties)
        for each in component.configuration_sets:
            for item in each.data:
                if _MARK in (item.data or ""):
                    yield (owner, f"{name}.{each.id}.{item.name}"), item.data or ""
    for connector in _connectors(profile):
        id = connector.connector_id
        yield from _stated(id, id, connector.properties)


def _stated(
    owner: object, name: str, properties: Iterable[ExtensionProperty]
) -> Iterator[tuple[_Key, str]]:
    for each in properties:
        if _MARK in (each.value or ""):
            yield (owner, f"{name} {each.name}"), each.value or ""
