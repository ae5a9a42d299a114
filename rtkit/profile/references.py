"""Checks references inside an RTS profile: each must name something that is there."""

from __future__ import annotations

from itertools import islice
from typing import Any

from rtkit.profile.findings import Findings
from rtkit.profile.normalise import set_type
from rtkit.profile.rts_rules import add
from rtkit.profile.words import strip_instance
from rtkit.profile.xmlnames import clark, short, split

_ID, _INSTANCE = clark("rts:id"), clark("rts:instanceName")
_COMPONENT_ID, _PORT_NAME = clark("rts:componentId"), clark("rts:portName")
_NAME, _CONNECTOR_ID = clark("rts:name"), clark("rts:connectorId")
_KINDS = {
    clark("rts:DataPortConnectors"): (clark("rts:DataPorts"), "Data"),
    clark("rts:ServicePortConnectors"): (clark("rts:ServicePorts"), "Service"),
}
_MOST_NAMED = 50
"""So many components are named as those that might have been meant."""

_NAMING = tuple(
    clark(f"rts:{tag}")
    for tag in ("Participant", "Members", "TargetComponent", "PrecedingComponents")
)


def check_references(root: Any, found: Findings) -> None:
    """Check ids and references, repairing what may be repaired."""
    components = _components(root, found)
    # Names in included profiles are known when they are read: `resolve` looks at all of them.
    is_whole = root.find(clark("rtkit:Include")) is None
    _connectors(root, components, found, is_whole)
    _others(root, components, found, is_whole)


def _components(root: Any, found: Findings) -> dict[tuple[str, str], Any]:
    components: dict[tuple[str, str], Any] = {}
    instances: dict[str, Any] = {}
    for component in root.iterchildren(clark("rts:Components")):
        key = (component.get(_ID), component.get(_INSTANCE))
        if None in key:
            continue
        first = components.setdefault(key, component)
        if not key[1].strip():
            text = "component without a name: rts:instanceName is empty"
            found.wrong(component, "component-name", text, at=_INSTANCE, seen=key[1])
        elif first is not component:
            found.wrong(
                component,
                "repeated-component",
                f"component {key[1]} ({key[0]}) is listed twice; "
                f"it is first listed on line {found.line(first)}",
            )
        elif key[1] in instances:
            line = found.line(instances[key[1]])
            text = f"instance name {key[1]} is also used on line {line}"
            found.remark(component, "shared-name", text, at=_INSTANCE, seen=key[1])
        instances.setdefault(key[1], component)
    return components


def _connectors(
    root: Any, components: dict[tuple[str, str], Any], found: Findings, is_whole: bool
) -> None:
    ports = _Ports()
    connectors = [item for item in root.iterchildren() if item.tag in _KINDS]
    taken = {item.get(_CONNECTOR_ID) for item in connectors}
    seen: set[str] = set()
    numbers: dict[str, int] = {}
    for connector in connectors:
        connector_id = connector.get(_CONNECTOR_ID)
        if connector_id in seen:
            connector_id = _other_id(connector, taken, numbers, found)
        seen.add(connector_id)
        for end in connector.iterchildren():
            local = split(end.tag)[1]
            if not (local.startswith(("source", "target")) and local.endswith("Port")):
                continue
            if is_whole or (end.get(_COMPONENT_ID), end.get(_INSTANCE)) in components:
                _end(end, connector, components, ports, found)


class _Ports:
    """The ports that components list, and where more of them go.

    Attributes:
        names: Ports that each component lists, with their kind.
    """

    def __init__(self) -> None:
        self.names: dict[tuple[str, str], set[str]] = {}
        self._last: dict[tuple[Any, str], Any] = {}

    def place(self, component: Any, made: Any) -> None:
        """Move an appended port behind its like, or to where its like would begin."""
        last = self._last.get((component, made.tag))
        if last is not None:
            last.addnext(made)
        else:
            before = (clark("rts:DataPorts"), made.tag)
            places = [n for n, item in enumerate(component, 1) if item.tag in before]
            places.remove(len(component))
            component.insert(max(places, default=0), made)
        self._last[component, made.tag] = made


def _other_id(connector: Any, taken: set[str], numbers: dict[str, int], found: Findings) -> str:
    was = connector.get(_CONNECTOR_ID)
    number = numbers.get(was, 2)
    while f"{was}_{number}" in taken:
        number += 1
    numbers[was] = number + 1
    new = f"{was}_{number}"
    taken.add(new)
    connector.set(_CONNECTOR_ID, new)
    text = f"connector id {was!r} is used before: taken as {new!r}"
    found.repaired(
        connector,
        "repeated-connector",
        text,
        at=_CONNECTOR_ID,
        seen=was,
        allowed="an id that no other connector has",
    )
    return new


def _end(
    end: Any, connector: Any, components: dict[tuple[str, str], Any], ports: _Ports, found: Findings
) -> None:
    key = (end.get(_COMPONENT_ID), end.get(_INSTANCE))
    port = end.get(_PORT_NAME)
    if None in key or port is None:
        return
    component = components.get(key)
    if component is None:
        text = f"{short(end.tag)} names component {key[1]} ({key[0]}), which is not listed"
        found.wrong(end, "unknown-component", text, seen=key[1], allowed=_names(components))
        return
    if key not in ports.names:
        ports.names[key] = {
            f"{split(item.tag)[1]} {strip_instance(item.get(_NAME) or '', key[1])}"
            for item in component.iterchildren(*(tag for tag, _ in _KINDS.values()))
        }
    tag, kind = _KINDS[connector.tag]
    wanted = f"{kind}Ports {strip_instance(port, key[1])}"
    if wanted in ports.names[key]:
        return
    ports.names[key].add(wanted)
    ports.place(component, _add_port(component, tag, end, connector, found))


def _add_port(component: Any, tag: str, end: Any, connector: Any, found: Findings) -> Any:
    """List a port that only a connector names; its direction is the connector's."""
    name = end.get(_PORT_NAME)
    is_source = split(end.tag)[1].startswith("source")
    properties = {"port.port_type": "CorbaPort"}
    if tag == clark("rts:DataPorts"):
        properties = {
            "port.port_type": "DataOutPort" if is_source else "DataInPort",
            "dataport.data_type": connector.get(clark("rts:dataType")) or "",
        }
    made = add(found, component, short(tag), {"rts:name": name}, end)
    set_type(made, "rtsExt:dataport_ext" if "Data" in tag else "rtsExt:serviceport_ext", found)
    for key, value in properties.items():
        if value:
            add(found, made, "rtsExt:Properties", {"rtsExt:name": key, "rtsExt:value": value})
    text = f"port {name} of {end.get(_INSTANCE)} is named by a connector only: added"
    found.repaired(end, "unlisted-port", text, at=_PORT_NAME, seen=name)
    return made


def _others(
    root: Any, components: dict[tuple[str, str], Any], found: Findings, is_whole: bool
) -> None:
    by_instance: dict[str, list[str]] = {}
    for component_id, instance in components:
        by_instance.setdefault(instance, []).append(component_id)
    for item in root.iter(*_NAMING):
        component_id, instance = item.get(_COMPONENT_ID), item.get(_INSTANCE)
        if component_id is None or instance is None or (component_id, instance) in components:
            continue
        known = by_instance.get(instance, [])
        if len(known) == 1:
            item.set(_COMPONENT_ID, known[0])
            text = f"rts:componentId {component_id!r} taken as {known[0]!r}"
            details = {"at": _COMPONENT_ID, "seen": component_id, "allowed": known[0]}
            found.repaired(item, "component-id", text, **details)
        elif is_whole:
            tag = short(item.tag)
            text = f"{tag} names component {instance} ({component_id}), which is not listed"
            found.wrong(item, "unknown-component", text, seen=instance, allowed=_names(components))


def _names(components: dict[tuple[str, str], Any]) -> str:
    named = [f"{instance} ({id})" for id, instance in islice(components, _MOST_NAMED)]
    more = len(components) - len(named)
    return ", ".join(named) + (f" and {more} more" if more else "")
