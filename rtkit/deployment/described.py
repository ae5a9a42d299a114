"""Descriptions of components in system profiles: types, ports, sets, contexts, scripted values.

The identity of a type is ``RTC:vendor:category:name:version``; old profiles write
``RTC:vendor.category.name:version``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from rtkit.deployment import extension
from rtkit.errors import Malformed
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import ComponentInstance, ConfigurationSet, InstancePort, OwnedContext
from rtkit.profile.words import strip_instance
from rtkit.rtc.enums import ExecutionKind, Polarity, PortType
from rtkit.rtc.pattern import ContextPattern
from rtkit.rtc.port_types import stated_port_type
from rtkit.rtc.profiles import PortInterfaceProfile, PortProfile, TypeProfile

DATA_ATTRIBUTES = (
    "dataport.data_type",
    "dataport.interface_type",
    "dataport.dataflow_type",
    "dataport.subscription_type",
)
"""Properties of a data connector that its profile states as attributes."""
_INTERFACE_KEY = r"(.+)\.port\.(.+)\.(provided|required)\.(.+)\.([^.]+)"


def properties_of(items: Iterable[ExtensionProperty]) -> dict[str, str]:
    """Return properties as a table; a later one of the same name wins."""
    return {item.name: item.value or "" for item in items}


def is_run_time(key: str, value: str) -> bool:
    """Return whether a property refers to an object of a past run: never saved or replayed."""
    return key.endswith(("_ior", "_ref")) or value.startswith("IOR:")


def lasting(properties: Mapping[str, str]) -> dict[str, str]:
    """Return properties without those of a past run."""
    return {key: value for key, value in properties.items() if not is_run_time(key, value)}


def data_port(
    port: InstancePort, instance: str, wired_as: PortType | None, wired_type: str
) -> PortProfile:
    """Return a data port; what the profile leaves open comes from its connections, or its name."""
    name = strip_instance(port.name, instance)
    properties = _live_properties(port)
    is_named_out = name.lower().startswith("out") or name.lower().endswith("out")
    stated = stated_port_type(properties.get("port.port_type", ""))
    kind = stated or wired_as or (PortType.OUT if is_named_out else PortType.IN)
    properties["port.port_type"] = kind.value
    if wired_type and not properties.get("dataport.data_type"):
        properties["dataport.data_type"] = wired_type
    return PortProfile(name, kind, properties)


def service_port(
    port: InstancePort, instance: str, wired: tuple[PortInterfaceProfile, ...]
) -> PortProfile:
    """Return a service port; `wired` are the interfaces that its connections name."""
    properties = _live_properties(port)
    properties["port.port_type"] = PortType.SERVICE.value
    text = properties_of(port.properties).get(extension.INTERFACES, "")
    interfaces = interfaces_from_text(text) if text else wired
    return PortProfile(
        strip_instance(port.name, instance), PortType.SERVICE, properties, interfaces
    )


def stated_interfaces(
    properties: Mapping[str, str],
) -> Iterable[tuple[str, str, PortInterfaceProfile]]:
    """Yield (instance, port, interface) for each interface that a connector's properties name."""
    for key in properties:
        found = re.fullmatch(_INTERFACE_KEY, key) if ".port." in key else None
        if found:
            instance, port, polarity, type_name, name = found.groups()
            yield (
                instance,
                port,
                PortInterfaceProfile(name, type_name, Polarity(polarity.capitalize())),
            )


def interfaces_to_text(interfaces: Iterable[PortInterfaceProfile]) -> str:
    """Return interfaces as the text of the property ``rtkit.interfaces``."""
    return ",".join(f"{i.polarity} {i.type_name} {i.instance_name}" for i in interfaces)


def interfaces_from_text(text: str) -> tuple[PortInterfaceProfile, ...]:
    """Read the property ``rtkit.interfaces``.

    Raises:
        Malformed: An item is not ``Provided|Required TYPE NAME``.
    """
    made = []
    for item in text.split(","):
        words = item.split()
        if len(words) != 3 or words[0] not in ("Provided", "Required"):
            raise Malformed(f"{extension.INTERFACES}: not 'Provided|Required TYPE NAME': {item!r}")
        made.append(PortInterfaceProfile(words[2], words[1], Polarity(words[0])))
    return tuple(made)


def sets_of(sets: Iterable[ConfigurationSet]) -> dict[str, dict[str, str]]:
    """Return configuration sets as tables; missing data are empty text."""
    made: dict[str, dict[str, str]] = {}
    for each in sets:
        made.setdefault(each.id, {}).update((d.name, d.data or "") for d in each.data)
    return made


def contexts_of(contexts: Iterable[OwnedContext]) -> tuple[ContextPattern, ...]:
    """Return execution contexts; one without an id is known by its number."""
    made = []
    for number, context in enumerate(contexts):
        kind = kind_of(context.kind)
        rate = context.rate
        if rate is None:
            rate = ContextPattern().rate if kind is ExecutionKind.PERIODIC else 0.0
        made.append(ContextPattern(context.id or str(number), kind, rate))
    return tuple(made)


def rates_of(contexts: Iterable[OwnedContext]) -> tuple[float, ...]:
    """Return the rates of periodic contexts [Hz]; 0 where none is stated."""
    return tuple(
        (each.rate or 0.0) if kind_of(each.kind) is ExecutionKind.PERIODIC else 0.0
        for each in contexts
    )


def guests_of(component: ComponentInstance) -> tuple[tuple[str, str], ...]:
    """Return context id and instance name of each other component that its contexts drive."""
    return tuple(
        (context.id or str(number), ref.instance_name)
        for number, context in enumerate(component.execution_contexts)
        for ref in context.participants
        if ref.instance_name != component.instance_name
    )


def kind_of(text: str) -> ExecutionKind:
    """Return the kind of a context, also from the name of a context type."""
    word = text.strip().upper().replace("_", "")
    if word in ("PERIODIC", "", "PERIODICEXECUTIONCONTEXT"):
        return ExecutionKind.PERIODIC
    if word in ("EVENTDRIVEN", "EVENTDRIVENEXECUTIONCONTEXT"):
        return ExecutionKind.EVENT_DRIVEN
    return ExecutionKind.OTHER


def script_of(component: ComponentInstance) -> dict[str, tuple[str, ...]]:
    """Return the values that the stand-in's ports transmit: a JSON list each.

    Raises:
        Malformed: A property is no JSON list.
    """
    head = f"{extension.STAND_IN}."
    script = {}
    for item in component.properties:
        if item.name.startswith(head):
            script[item.name.removeprefix(head)] = _values(component.instance_name, item)
    return script


def _values(instance: str, item: ExtensionProperty) -> tuple[str, ...]:
    import json

    try:
        values = json.loads(item.value or "")
    except ValueError as error:
        raise Malformed(f"{instance}: property {item.name} is not JSON: {error}") from error
    if not isinstance(values, list) or not values:
        raise Malformed(f"{instance}: property {item.name} is no list of values: {item.value}")
    return tuple(json.dumps(value) for value in values)


def _live_properties(port: InstancePort) -> dict[str, str]:
    return {
        key: value
        for key, value in lasting(properties_of(port.properties)).items()
        if not key.startswith("rtkit.")
    }


def type_of(id: str) -> TypeProfile:
    """Return the type that an identity names; what cannot be read becomes the type's name."""
    parts = id.split(":")
    if parts[0] == "RTC" and len(parts) == 5:
        _, vendor, category, name, version = parts
        return TypeProfile(name, vendor, category, version)
    if parts[0] == "RTC" and len(parts) == 3 and parts[1].count(".") >= 2:
        vendor, category, name = parts[1].rsplit(".", 2)
        return TypeProfile(name, vendor, category, parts[2])
    return TypeProfile(id.replace(":", ".") or "Unnamed")


def is_same_id(one: str, other: str) -> bool:
    """Return whether two identities name the same type."""
    return one == other or type_of(one) == type_of(other)
