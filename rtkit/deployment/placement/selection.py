"""A system profile with other places for some of its components, and without some of its parts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial

from rtkit.deployment.extension import CREATE
from rtkit.deployment.placement.profiles import with_paths
from rtkit.errors import NotFound, UsageProblem
from rtkit.fast_dataclass import replace
from rtkit.profile.rts_model import ComponentInstance, RtsProfile
from rtkit.profile.words import property_value
from rtkit.profile_tools.system_edits import changed, key_of, removed
from rtkit.rtc.create import parse_create
from rtkit.rtc.names import LOCAL, MANAGER_SUFFIX
from rtkit.rtc.nearest import did_you_mean

ALL_SETS = "*"


def without_parts(profile: RtsProfile, names: Iterable[str]) -> RtsProfile:
    """Return a profile without some of its parts, as if it had never had them.

    Args:
        profile: The profile.
        names: Of components, which take their connectors along, ids of connectors, and
            ``COMPONENT.SET``, ``COMPONENT.SET.PARAMETER``, or ``COMPONENT.*`` for all sets.

    Raises:
        NotFound: There is no such part; names the nearest ones.
    """
    left = set(names)
    components = {each.instance_name: key_of(each) for each in profile.components}
    connectors = {each.connector_id for each in profile.data_port_connectors}
    connectors |= {each.connector_id for each in profile.service_port_connectors}
    settings = {name for each in profile.components for name in _settings(each)}
    for name in names:
        known = [*components, *connectors, *settings]
        if name not in known:
            raise NotFound(f"--without {name}: no such part{did_you_mean(name, known)}")
    gone = [key for name, key in components.items() if name in left]
    rest = removed(profile, gone, connectors & left)
    return replace(rest, components=tuple(_configured(each, left) for each in rest.components))


def _settings(component: ComponentInstance) -> Iterator[str]:
    name = component.instance_name
    yield f"{name}.{ALL_SETS}"
    for each in component.configuration_sets:
        yield f"{name}.{each.id}"
        yield from (f"{name}.{each.id}.{item.name}" for item in each.data)


def _configured(component: ComponentInstance, left: set[str]) -> ComponentInstance:
    """Return a component without the sets and parameters that are left out."""
    name = component.instance_name
    if f"{name}.{ALL_SETS}" in left:
        return replace(component, configuration_sets=(), active_configuration_set=None)
    sets = tuple(
        replace(each, data=tuple(d for d in each.data if f"{name}.{each.id}.{d.name}" not in left))
        for each in component.configuration_sets
        if f"{name}.{each.id}" not in left
    )
    active = component.active_configuration_set
    is_left = f"{name}.{active}" in left
    return replace(
        component,
        configuration_sets=sets,
        active_configuration_set=None if is_left else active,
    )


def with_other_places(profile: RtsProfile, places: Mapping[str, str], usual: str) -> RtsProfile:
    """Return a profile some of whose components are to be elsewhere.

    Args:
        profile: The profile.
        places: ``HOST``, ``HOST/MANAGER.mgr`` or ``HOST/MANAGER.mgr/SLAVE.mgr`` by component; a
            ``/`` before it does no harm. One without a slave leaves that as the profile has it.
        usual: The manager of this host of components whose path names none.

    Raises:
        NotFound: There is no such component; names the nearest ones.
        UsageProblem: A place is not of that form, or nothing tells how to make a component in
            another slave.
    """
    known = {each.instance_name: each for each in profile.components}
    paths = {}
    made = profile
    for name, place in places.items():
        if name not in known:
            hint = did_you_mean(name, known)
            raise NotFound(f"--place {name}={place}: no such component{hint}")
        host, manager, slave = _place(name, place)
        below = "" if manager == usual and host == LOCAL else manager
        registered = (known[name].path_uri or f"{name}.rtc").rpartition("/")[2]
        paths[name] = "/".join([host, *([f"{below}{MANAGER_SUFFIX}"] if below else []), registered])
        if slave:
            made = changed(made, key_of(known[name]), partial(_in_slave, slave))
    return with_paths(made, paths)


def _place(name: str, place: str) -> tuple[str, str, str]:
    host, *managers = place.strip().strip("/").split("/")
    is_named = all(each.endswith(MANAGER_SUFFIX) and each != MANAGER_SUFFIX for each in managers)
    if not host or host.endswith(MANAGER_SUFFIX) or len(managers) > 2 or not is_named:
        raise UsageProblem(
            f"--place {name}={place}: a place is HOST, HOST/MANAGER.mgr"
            " or HOST/MANAGER.mgr/SLAVE.mgr"
        )
    manager, slave = [*(each.removesuffix(MANAGER_SUFFIX) for each in managers), "", ""][:2]
    return host, manager, slave


def _in_slave(slave: str, component: ComponentInstance) -> ComponentInstance:
    create = property_value(component.properties, CREATE)
    if create is None:
        name = component.instance_name
        raise UsageProblem(f"--place {name}: {CREATE} of it is needed for a slave ({slave})")
    text = str(parse_create(create).with_options(manager_name=slave))
    return replace(
        component,
        properties=tuple(
            replace(each, value=text) if each.name == CREATE else each
            for each in component.properties
        ),
    )
