"""Requirements of the components of a system profile, and the profile with their places."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from rtkit.deployment.described import properties_of
from rtkit.deployment.extension import PLACE
from rtkit.deployment.placement.requirements import (
    FREE,
    Requirements,
    check_named,
    read_requirements,
)
from rtkit.deployment.system import BadComponent
from rtkit.errors import Malformed
from rtkit.fast_dataclass import replace
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import (
    ComponentInstance,
    DataPortConnector,
    RtsProfile,
    ServicePortConnector,
    TargetPort,
)
from rtkit.profile.words import PATH_ID

Wire = TypeVar("Wire", DataPortConnector, ServicePortConnector)


def has_requirements(profile: RtsProfile) -> bool:
    """Return whether a component has a requirement, or a path whose host is open."""
    return any(
        is_free(each) or any(item.name.startswith(PLACE) for item in each.properties)
        for each in profile.components
    )


def is_free(component: ComponentInstance) -> bool:
    """Return whether the host of a component is to be chosen."""
    return _bare(component).partition("/")[0] == FREE


def _bare(component: ComponentInstance) -> str:
    return (component.path_uri or "").strip().lstrip("/")


def requirements_of(profile: RtsProfile) -> dict[str, Requirements]:
    """Return the requirements of each component.

    Raises:
        BadComponent: Those of one make no sense.
    """
    names = {each.instance_name for each in profile.components}
    found = {}
    for position, each in enumerate(profile.components):
        try:
            required = read_requirements(properties_of(each.properties))
            check_named(each.instance_name, required, names)
        except Malformed as error:
            text = f"{each.instance_name}: {error}"
            raise BadComponent(position, text) from error
        found[each.instance_name] = required
    return found


def with_places(profile: RtsProfile, places: Mapping[str, str]) -> RtsProfile:
    """Return a profile in which the paths that are open begin with these places, by component."""
    paths = {
        each.instance_name: f"{places[each.instance_name]}{_bare(each)[len(FREE) :]}"
        for each in profile.components
        if is_free(each) and each.instance_name in places
    }
    return with_paths(profile, paths)


def with_paths(profile: RtsProfile, paths: Mapping[str, str]) -> RtsProfile:
    """Return a profile in which some components have other paths, also at ends of connectors."""

    def end(target: TargetPort) -> TargetPort:
        path = paths.get(target.instance_name)
        if path is None:
            return target
        items = (
            ExtensionProperty(item.name, path) if item.name == PATH_ID else item
            for item in target.properties
        )
        return replace(target, properties=tuple(items))

    def wired(wires: tuple[Wire, ...]) -> tuple[Wire, ...]:
        return tuple(replace(w, source=end(w.source), target=end(w.target)) for w in wires)

    components = tuple(
        replace(each, path_uri=paths.get(each.instance_name, each.path_uri))
        for each in profile.components
    )
    return replace(
        profile,
        components=components,
        data_port_connectors=wired(profile.data_port_connectors),
        service_port_connectors=wired(profile.service_port_connectors),
    )
