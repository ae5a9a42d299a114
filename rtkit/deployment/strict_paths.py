"""Checks that the ends of connectors state the paths of the components that they name."""

from __future__ import annotations

from rtkit.errors import InvalidDocument
from rtkit.profile.rts_model import DataPortConnector, RtsProfile, ServicePortConnector
from rtkit.profile.words import property_value

PATH_ID = "COMPONENT_PATH_ID"
"""Property of a connector's end: the path of its component."""


def check_paths(profile: RtsProfile) -> None:
    """Refuse connectors whose ends state another path than that of their component.

    Raises:
        InvalidDocument: Names connector, component and both paths.
    """
    paths = {each.instance_name: _bare(each.path_uri) for each in profile.components}
    wires: list[DataPortConnector | ServicePortConnector] = [*profile.data_port_connectors]
    wires += profile.service_port_connectors
    for wire in wires:
        for end in (wire.source, wire.target):
            told = property_value(end.properties, PATH_ID)
            own = paths.get(end.instance_name, "")
            if told and _bare(told) != own:
                raise InvalidDocument(
                    f"connector {wire.connector_id}: {PATH_ID} of {end.instance_name} is {told},"
                    f" but its path is {own}"
                )


def _bare(path: str) -> str:
    return path.strip("/")
