"""Builds documents in strict form by a fast path: no repairs, no remarks.

It takes the same decisions as the full path, `rtkit.profile.normalise` and the checks after it, or
none at all: anything out of the ordinary is left to the full path, which can name the fault.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from rtkit.profile.build import NotStrict, build_strict
from rtkit.profile.parse import MAX_DEPTH
from rtkit.profile.rts_rules import OLD_VERSIONS
from rtkit.profile.rts_spec import ORDERS
from rtkit.profile.spec import ElementSpec
from rtkit.profile.words import strip_instance
from rtkit.profile.xmlnames import NAMESPACES

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import ComponentInstance, InstancePort, Order, RtsProfile

_Key = tuple[str, str]


def built(root: Any, spec: ElementSpec, scope: dict[str | None, str] | None) -> Any:
    """Return the model of a tree in strict form, not yet validated; None for any other."""
    if scope is None or any(scope.get(p, uri) != uri for p, uri in NAMESPACES.items()):
        return None
    try:
        return build_strict(root, spec, MAX_DEPTH - 1)
    except (NotStrict, KeyError, ValueError):
        return None


def is_plain_component(profile: RtcProfile) -> bool:
    """Return whether a component profile is whole, and no name in it is used twice."""
    names = [port.name for port in profile.data_ports]
    names += [port.name for port in profile.service_ports]
    is_whole = profile.basic_info is not None and profile.actions is not None
    return is_whole and profile.version not in OLD_VERSIONS and len(set(names)) == len(names)


def is_plain_system(profile: RtsProfile) -> bool:
    """Return whether every name used in a system profile is defined exactly once."""
    components = {(item.id, item.instance_name): item for item in profile.components}
    names = {item.instance_name for item in profile.components}
    ids = [item.connector_id for item in profile.data_port_connectors]
    ids += [item.connector_id for item in profile.service_port_connectors]
    return (
        profile.version not in OLD_VERSIONS
        and len(names) == len(profile.components)
        and all(name.strip() for name in names)
        and len(set(ids)) == len(ids)
        and all(key in components for key in _named(profile))
        and _ports_are_listed(profile, components)
    )


def _ports_are_listed(profile: RtsProfile, components: dict[_Key, ComponentInstance]) -> bool:
    data = {key: _own_names(item, item.data_ports) for key, item in components.items()}
    service = {key: _own_names(item, item.service_ports) for key, item in components.items()}
    return all(
        strip_instance(end.port_name, end.instance_name)
        in listed.get((end.component_id, end.instance_name), ())
        for connectors, listed in (
            (profile.data_port_connectors, data),
            (profile.service_port_connectors, service),
        )
        for connector in connectors
        for end in (connector.source, connector.target)
    )


def _own_names(component: ComponentInstance, ports: tuple[InstancePort, ...]) -> set[str]:
    return {strip_instance(port.name, component.instance_name) for port in ports}


def _named(profile: RtsProfile) -> Iterator[_Key]:
    """Yield the components that others name, but for the ends of connectors."""
    refs = [member for group in profile.groups for member in group.members]
    for component in profile.components:
        refs += component.participants
        for context in component.execution_contexts:
            refs += context.participants
    yield from ((ref.component_id, ref.instance_name) for ref in refs)
    for field, _ in ORDERS:
        order: Order | None = getattr(profile, field)
        for step in order.targets if order is not None else ():
            preceding = step.preceding.preceding_components if step.preceding is not None else ()
            for target in (step.target_component, *preceding):
                yield target.component_id, target.instance_name
