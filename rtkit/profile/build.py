"""Builds models from trees along the tables of `rtkit.profile.spec`; strict forms by a fast path.

The fast path, for documents that need no repairs and no remarks, takes the same decisions as the
full path, `rtkit.profile.normalise` and the checks after it, or none at all: anything out of the
ordinary is left to the full path, which can name the fault.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from rtkit.profile.common import Foreign, ForeignElement
from rtkit.profile.parse import MAX_DEPTH
from rtkit.profile.rts_rules import OLD_VERSIONS
from rtkit.profile.rts_spec import ORDERS
from rtkit.profile.spec import ElementSpec
from rtkit.profile.words import strip_instance
from rtkit.profile.xmlnames import NAMESPACES, XSI_TYPE, split

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import ComponentInstance, InstancePort, Order, RtsProfile


_One = Callable[[str, str], str]
"""Returns one and the same object for equal texts: profiles say the same things often."""


class NotStrict(Exception):
    """The tree is not in strict form, or has content that a reader has to be told of."""


def build(element: Any, spec: ElementSpec) -> Any:
    """Return the model of `element`, which is valid.

    Raises:
        KeyError: The tree is not valid.
        ValueError: The tree is not valid.
    """
    known: dict[str, str] = {}
    return _built(element, spec, known.setdefault)


def build_strict(element: Any, spec: ElementSpec, depth: int) -> Any:
    """Return the model of `element` if it needs neither repair nor remark; it may yet be invalid.

    Prefixes must be the usual ones. `depth` is how many more levels there may be.

    Raises:
        NotStrict: It does need some.
        KeyError: The tree is not valid.
        ValueError: The tree is not valid.
    """
    known: dict[str, str] = {}
    return _strictly(element, spec, depth, known.setdefault)


def _built(element: Any, spec: ElementSpec, one: _One) -> Any:
    args = spec.blank[:]
    readers = spec.readers
    foreign_attributes: list[tuple[str, str]] = []
    for name, value in element.items():
        reader = readers.get(name)
        if reader is not None:
            place, read = reader
            args[place] = one(value, value) if read is None else read(value)
        elif name != XSI_TYPE:
            foreign_attributes.append((name, value))
    foreign_elements = _children(element, spec, args, one) if len(element) else ()
    if foreign_attributes or foreign_elements:
        args[spec.foreign_place] = Foreign(tuple(sorted(foreign_attributes)), foreign_elements)
    if spec.tag_place is not None:
        args[spec.tag_place] = split(element.tag)[1]
    return spec.make(*args)


def _strictly(element: Any, spec: ElementSpec, depth: int, one: _One) -> Any:
    args = spec.blank[:]
    readers = spec.readers
    seen_type = None
    for name, value in element.items():
        reader = readers.get(name)
        if reader is not None:
            place, read = reader
            args[place] = one(value, value) if read is None else read(value)
        elif name == XSI_TYPE:
            seen_type = value
        else:
            raise NotStrict
    if depth < 0 or (seen_type != spec.xsi_type_text and not _is_extended(seen_type, spec)):
        raise NotStrict
    if len(element):
        slots, last = spec.slots, 0
        for item in element:
            slot = slots.get(item.tag)
            if slot is None or slot[0] < last:
                raise NotStrict
            last, place, inner, is_many = slot
            if inner is not None:
                made = _strictly(item, inner, depth - 1, one)
            elif item.attrib:
                raise NotStrict
            else:
                made = item.text or ""
            if is_many:
                if args[place]:
                    args[place].append(made)
                else:
                    args[place] = [made]
            elif args[place] is None:
                args[place] = made
            else:
                raise NotStrict
        for place in spec.many_places:
            args[place] = tuple(args[place])
    if spec.tag_place is not None:
        args[spec.tag_place] = split(element.tag)[1]
    return spec.make(*args)


def _is_extended(seen_type: str | None, spec: ElementSpec) -> bool:
    return seen_type is not None and seen_type == spec.extended_type


def _children(
    element: Any, spec: ElementSpec, args: list[Any], one: _One
) -> tuple[ForeignElement, ...]:
    slots = spec.slots
    foreign: list[ForeignElement] = []
    for item in element:
        slot = slots.get(item.tag)
        if slot is None:
            foreign.append(_foreign(item, is_top=True))
            continue
        _, place, inner, is_many = slot
        made = _built(item, inner, one) if inner is not None else (item.text or "")
        if not is_many:
            args[place] = made
        elif args[place]:
            args[place].append(made)
        else:
            args[place] = [made]
    for place in spec.many_places:
        args[place] = tuple(args[place])
    return tuple(foreign)


def _foreign(item: Any, *, is_top: bool = False) -> ForeignElement:
    children = tuple(_foreign(below) for below in item)
    text = item.text if not children else _unless_blank(item.text)
    return ForeignElement(
        item.tag,
        tuple(sorted(item.items())),
        text or None,
        children,
        None if is_top else _unless_blank(item.tail),
    )


def _unless_blank(text: str | None) -> str | None:
    return text if text and not text.isspace() else None


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
