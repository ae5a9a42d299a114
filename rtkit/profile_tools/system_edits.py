"""Edits a system profile: each function returns the profile that comes of it.

All that an edit is not about stays as it is: positions, bend points, content that nobody knows.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import NamedTuple, TypeVar

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.fast_dataclass import replace
from rtkit.profile import rts_model as rts
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.parameters.naming import Reference, renamed, with_references
from rtkit.profile.words import strip_instance
from rtkit.profile_tools.new_system import NewMember, new_component, stated_port, target_port
from rtkit.rtc.enums import PortType
from rtkit.rtc.names import COMPONENT_SUFFIX
from rtkit.rtc.port_types import are_reversed
from rtkit.rtc.profiles import PortProfile

DIRECTIONS = ("RIGHT", "LEFT", "DOWN", "UP")
BEND_POINTS = "BEND_POINT"
"""Property of a connector: ``{1:(x,y),2:(x,y)}``, the corners of its wire [pixel]."""
_INTERFACE, _DATAFLOW = "dataport.interface_type", "dataport.dataflow_type"
_SUBSCRIPTION = "dataport.subscription_type"
_UNSIZED = -1
_Wire = TypeVar("_Wire", rts.DataPortConnector, rts.ServicePortConnector)


class Key(NamedTuple):
    """The identity of a component in its system."""

    component_id: str
    instance_name: str


class PortEnd(NamedTuple):
    """A port that is to be connected."""

    owner: Key
    port: PortProfile


def key_of(component: rts.ComponentInstance) -> Key:
    """Return the identity of a component."""
    return Key(component.id, component.instance_name)


def added(
    profile: rts.RtsProfile, member: NewMember, host: str, place: tuple[int, int] | None
) -> rts.RtsProfile:
    """Return a profile with one component more, at a place [pixel] if one is given.

    Raises:
        Refused: There is one of that name.
        Malformed: It cannot have that name.
    """
    _check_name(profile, member.instance)
    component = new_component(member, host)
    if place is not None:
        component = replace(component, location=_location(None, place))
    return replace(profile, components=(*profile.components, component))


def removed(
    profile: rts.RtsProfile, components: Collection[Key], connectors: Collection[str]
) -> rts.RtsProfile:
    """Return a profile without these components and connectors.

    What names a component that goes, goes too: connectors, members of groups and composites, steps
    of orders.
    """

    def kept(reference: Reference) -> Reference | None:
        return None if Key(reference.component_id, reference.instance_name) in gone else reference

    gone = set(components)
    rest = replace(
        profile, components=tuple(each for each in profile.components if key_of(each) not in gone)
    )
    made: rts.RtsProfile = with_references(rest, kept) if gone else rest
    return replace(
        made,
        data_port_connectors=tuple(
            each for each in made.data_port_connectors if each.connector_id not in connectors
        ),
        service_port_connectors=tuple(
            each for each in made.service_port_connectors if each.connector_id not in connectors
        ),
    )


def with_name(profile: rts.RtsProfile, key: Key, name: str) -> rts.RtsProfile:
    """Return a profile in which a component has another name; what refers to it follows.

    Raises:
        Refused: Another one has that name, or two have the name of before.
        Malformed: It cannot have that name.
    """
    old = key.instance_name
    if name == old:
        return profile
    _check_name(profile, name)
    if sum(each.instance_name == old for each in profile.components) > 1:
        raise Refused(f"two components are named {old}: what refers to them cannot be told apart")
    names = {old: name, f"{old}{COMPONENT_SUFFIX}": f"{name}{COMPONENT_SUFFIX}"}
    made = renamed(profile, lambda each: names.get(each, each))
    # Only components are meant, also where something else has the same name.
    return replace(
        made,
        id=profile.id,
        groups=tuple(
            replace(each, group_id=before.group_id)
            for each, before in zip(made.groups, profile.groups, strict=True)
        ),
        data_port_connectors=tuple(
            replace(each, connector_id=before.connector_id, name=before.name)
            for each, before in zip(
                made.data_port_connectors, profile.data_port_connectors, strict=True
            )
        ),
        service_port_connectors=tuple(
            replace(each, connector_id=before.connector_id, name=before.name)
            for each, before in zip(
                made.service_port_connectors, profile.service_port_connectors, strict=True
            )
        ),
    )


def connected(
    profile: rts.RtsProfile, one: PortEnd, other: PortEnd, properties: Mapping[str, str]
) -> rts.RtsProfile:
    """Return a profile with a connector between two ports that fit; the out port comes first.

    Raises:
        Refused: The ports are connected already.
    """
    is_turned = are_reversed((one.port.port_type, other.port.port_type))
    source, target = (other, one) if is_turned else (one, other)
    for end in (source, target):
        profile = changed(profile, end.owner, partial(_listing, port=end.port))
    ends = (_target(profile, source), _target(profile, target))
    existing: list[rts.DataPortConnector | rts.ServicePortConnector] = [
        *profile.data_port_connectors, *profile.service_port_connectors,
    ]  # fmt: skip
    if any((each.source, each.target) == ends for each in existing):
        raise Refused(f"{ends[0].port_name} and {ends[1].port_name} are connected already")
    number = _free_number({each.connector_id for each in existing})
    name = f"{source.port.name}_{target.port.name}"
    stated = tuple(ExtensionProperty(key, value) for key, value in properties.items())
    if source.port.port_type == PortType.SERVICE:
        service = rts.ServicePortConnector(number, name, *ends, properties=stated)
        return replace(profile, service_port_connectors=(*profile.service_port_connectors, service))
    known = [end.port.data_type for end in (source, target)]
    data_type = next((each for each in known if each.lower() not in ("", "any")), known[0])
    data = rts.DataPortConnector(
        number,
        name,
        data_type,
        properties.get(_INTERFACE, "corba_cdr"),
        properties.get(_DATAFLOW, "push"),
        *ends,
        properties.get(_SUBSCRIPTION, "new"),
        properties=stated,
    )
    return replace(profile, data_port_connectors=(*profile.data_port_connectors, data))


def with_connector_properties(
    profile: rts.RtsProfile, id: str, values: Mapping[str, str | None]
) -> rts.RtsProfile:
    """Return a profile in which a connector states other properties; None states one no more.

    Raises:
        NotFound: There is no such connector.
    """
    data, services = profile.data_port_connectors, profile.service_port_connectors
    ids = {each.connector_id for each in data} | {each.connector_id for each in services}
    if id not in ids:
        raise NotFound(f"No such connector: {id}")
    return replace(
        profile,
        data_port_connectors=tuple(_stating(each, id, values) for each in data),
        service_port_connectors=tuple(_stating(each, id, values) for each in services),
    )


def placed(profile: rts.RtsProfile, places: Mapping[Key, tuple[int, int]]) -> rts.RtsProfile:
    """Return a profile in which components stand at other places [pixel]; sizes stay."""
    return replace(
        profile,
        components=tuple(
            replace(each, location=_location(each.location, places[key_of(each)]))
            if key_of(each) in places
            else each
            for each in profile.components
        ),
    )


def located(
    profile: rts.RtsProfile,
    key: Key,
    at: tuple[int, int],
    *,
    size: tuple[int, int] | None = None,
    direction: str = "",
) -> rts.RtsProfile:
    """Return a profile in which the box of a component has another size or direction.

    Args:
        profile: The profile.
        key: The component.
        at: Where it stands, if the profile does not say so.
        size: Width and height [pixel]; None leaves them.
        direction: Where its out ports point, one of `DIRECTIONS`; empty leaves it.
    """

    def change(component: rts.ComponentInstance) -> rts.ComponentInstance:
        location = component.location
        if location is None or not (location.x or location.y or location.width > 0):
            location = _location(None, at)
        width, height = size or (location.width, location.height)
        turned = direction or location.direction
        location = replace(location, width=width, height=height, direction=turned)
        return replace(component, location=location)

    return changed(profile, key, change)


def bent(profile: rts.RtsProfile, id: str, points: Sequence[tuple[int, int]]) -> rts.RtsProfile:
    """Return a profile in which the wire of a connector has these bend points [pixel]; or none.

    Raises:
        NotFound: There is no such connector.
    """
    text = ",".join(f"{number}:({x},{y})" for number, (x, y) in enumerate(points, 1))
    return with_connector_properties(profile, id, {BEND_POINTS: f"{{{text}}}" if text else None})


def identified(profile: rts.RtsProfile, vendor: str, name: str, version: str) -> rts.RtsProfile:
    """Return a profile with another identity.

    Raises:
        Malformed: A part is empty, or has a colon.
    """
    for what, text in (("vendor", vendor), ("name", name), ("version", version)):
        if not text.strip() or ":" in text:
            raise Malformed(f"{what}: a text without a colon is wanted, not {text!r}")
    return replace(profile, id=f"RTSystem:{vendor}:{name}:{version}")


def identity(profile: rts.RtsProfile) -> tuple[str, str, str]:
    """Return vendor, name and version of a system; an id of another form is its name."""
    parts = profile.id.split(":")
    return (parts[1], parts[2], parts[3]) if len(parts) == 4 else ("", profile.id, "")


def changed(
    profile: rts.RtsProfile,
    key: Key,
    change: Callable[[rts.ComponentInstance], rts.ComponentInstance],
) -> rts.RtsProfile:
    """Return a profile in which one component is changed."""
    return replace(
        profile,
        components=tuple(
            change(each) if key_of(each) == key else each for each in profile.components
        ),
    )


def _stating(wire: _Wire, id: str, values: Mapping[str, str | None]) -> _Wire:
    if wire.connector_id != id:
        return wire
    made = replace(wire, properties=_with_values(wire.properties, values))
    if isinstance(made, rts.DataPortConnector):
        # Three properties are attributes, too: what a connector is said to be is said once.
        made = replace(
            made,
            interface_type=values.get(_INTERFACE) or made.interface_type,
            dataflow_type=values.get(_DATAFLOW) or made.dataflow_type,
            subscription_type=values.get(_SUBSCRIPTION) or made.subscription_type,
        )
    return made


def _check_name(profile: rts.RtsProfile, name: str) -> None:
    if not name.strip() or any(sign in name for sign in "/:"):
        raise Malformed(f"{name!r} cannot be the name of a component")
    if any(each.instance_name == name for each in profile.components):
        raise Refused(f"there is a component named {name}")


def _location(before: rts.Location | None, place: tuple[int, int]) -> rts.Location:
    if before is not None:
        return replace(before, x=place[0], y=place[1])
    return rts.Location(*place, _UNSIZED, _UNSIZED, DIRECTIONS[0])


def _listing(component: rts.ComponentInstance, port: PortProfile) -> rts.ComponentInstance:
    """Return a component that lists a port."""
    is_service = port.port_type == PortType.SERVICE
    listed = component.service_ports if is_service else component.data_ports
    if any(strip_instance(each.name, component.instance_name) == port.name for each in listed):
        return component
    kind = "CorbaPort" if is_service else str(port.port_type)
    made = stated_port(component.instance_name, port.name, kind, port.data_type)
    if is_service:
        return replace(component, service_ports=(*listed, made))
    return replace(component, data_ports=(*listed, made))


def _target(profile: rts.RtsProfile, end: PortEnd) -> rts.TargetPort:
    """Return the end of a connector, with the port named as its component lists it."""
    component = next(each for each in profile.components if key_of(each) == end.owner)
    names = [each.name for each in (*component.data_ports, *component.service_ports)]
    instance = end.owner.instance_name
    listed = (each for each in names if strip_instance(each, instance) == end.port.name)
    return replace(target_port(*end.owner, end.port.name), port_name=next(listed))


def _free_number(taken: Collection[str]) -> str:
    number = len(taken) + 1
    while str(number) in taken:
        number += 1
    return str(number)


def _with_values(
    properties: tuple[ExtensionProperty, ...], values: Mapping[str, str | None]
) -> tuple[ExtensionProperty, ...]:
    kept = [
        replace(each, value=values[each.name]) if each.name in values else each
        for each in properties
        if each.name not in values or values[each.name] is not None
    ]
    known = {each.name for each in properties}
    fresh = (
        ExtensionProperty(name, value)
        for name, value in values.items()
        if name not in known and value is not None
    )
    return (*kept, *fresh)
