"""Repairs that only RTS profiles need; the general ones are in `rtkit.profile.normalise`.

Elements are lxml's, typed loosely because this room does not import lxml before it reads.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rtkit.profile.findings import Findings
from rtkit.profile.xmlnames import NAMESPACES, clark, split

NO_DATE = "1970-01-01T00:00:00"
"""Date of a profile without any."""

ORDERS = (
    "StartUp",
    "ShutDown",
    "Activation",
    "Deactivation",
    "Resetting",
    "Initializing",
    "Finalizing",
)
OLD_VERSIONS = ("0.1", "1.0")
PRESENT_VERSION = "0.2"
_OWN = ("", NAMESPACES["rts"], NAMESPACES["rtc"])
_REF = ("rts:componentId", "rts:instanceName")


def position_among_siblings(element: Any, found: Findings) -> str:
    """Number an element that has no id of its own: 0 for the first of its kind."""
    return str(found.number(element))


def other_date(element: Any, _: Findings) -> str:
    """Take the other of the two dates, or `NO_DATE`."""
    for name, value in element.items():
        if split(name)[1] in ("creationDate", "updateDate") and value.strip():
            return str(value)
    return NO_DATE


def property_or_empty(option: str) -> Callable[[Any, Findings], str]:
    """Look for an absent connector attribute among the options in its properties."""

    def find(connector: Any, _: Findings) -> str:
        for item in connector.iterchildren(clark("rtsExt:Properties")):
            if item.get(clark("rtsExt:name")) == f"dataport.{option}":
                return item.get(clark("rtsExt:value")) or ""
        return ""

    return find


def precondition(condition: Any, found: Findings) -> None:
    """Give a target without precondition the one that waits for nothing; refuse two."""
    wait = condition.find(clark("rts:WaitTime"))
    preceding = condition.find(clark("rts:Preceding"))
    if wait is not None and preceding is not None:
        text = "rts:WaitTime and rts:Preceding: one of them is allowed"
        found.wrong(condition, "condition", text, seen="both", allowed="one of them")
    elif wait is None and preceding is None:
        text = "target without WaitTime or Preceding: waits 0 ms"
        found.repaired(condition, "condition", text, allowed="one of them")
        condition.insert(0, add(found, condition, "rts:WaitTime", {"rts:waitTime": "0"}))


def add(
    found: Findings, parent: Any, tag: str, attributes: dict[str, str], like: Any = None
) -> Any:
    """Append an element that bears the line number of `like`, or of its parent."""
    made = found.add(parent, clark(tag), parent if like is None else like)
    for name, value in attributes.items():
        made.set(clark(name), value)
    return made


def present_version(root: Any, found: Findings) -> None:
    """Have a document of version 0.1 declare 0.2, the oldest version that has the present form.

    Readers that go by the declared version would look for the old spelling otherwise.
    """
    for name, value in root.items():
        namespace, local = split(name)
        if local == "version" and namespace in _OWN and value in OLD_VERSIONS:
            root.set(name, PRESENT_VERSION)
            text = f"version {value!r} taken as {PRESENT_VERSION!r}, whose form it has now"
            found.repaired(root, "old-form", text, at=name, seen=value, allowed="0.2, 0.3")


def version_0_1(root: Any, found: Findings) -> None:
    """Bring the nested form of version 0.1 to the present one."""
    present_version(root, found)
    components = [c for c in root.iterchildren("{*}*") if split(c.tag)[1] == "Component"]
    if not components:
        return
    for component in components:
        for kind, source, target in (
            ("DataPort", "sourceDataPort", "targetDataPort"),
            ("ServicePort", "sourceServicePort", "targetServicePort"),
        ):
            for port in component.findall(clark(f"rts:{kind}s")):
                for connector in port.findall(clark(f"rts:{kind}Connectors")):
                    text = f"{kind}Connectors moved out of its port"
                    found.repaired(connector, "old-form", text, allowed="below the root")
                    _lift_connector(root, component, port, connector, (source, target), found)
        _lift_orders(root, component, found)
    _add_unlisted(root, components, found)


def _lift_connector(
    root: Any, component: Any, port: Any, connector: Any, ends: tuple[str, str], found: Findings
) -> None:
    source = connector.find(clark(f"rts:{ends[0]}"))
    if source is None:
        values = {
            "rts:componentId": component.get(clark("rts:id")),
            "rts:instanceName": component.get(clark("rts:instanceName")),
            "rts:portName": port.get(clark("rts:name")),
        }
        known = {name: value for name, value in values.items() if value is not None}
        connector.insert(0, add(found, connector, f"rts:{ends[0]}", known))
    root.append(connector)


def _lift_orders(root: Any, component: Any, found: Findings) -> None:
    for name in ORDERS:
        for nested in component.findall(clark(f"rts:{name}")):
            text = f"{name} moved out of its component"
            found.repaired(nested, "old-form", text, allowed="below the root")
            order = root.find(clark(f"rts:{name}"))
            if order is None:
                order = add(found, root, f"rts:{name}", {}, nested)
            steps = [nested] if nested.get(clark("rts:sequence")) else list(nested)
            for step in steps:
                step.tag = clark("rts:targets")
                if step.find(clark("rts:TargetComponent")) is None:
                    target = {
                        "rts:componentId": component.get(clark("rts:id"), ""),
                        "rts:instanceName": component.get(clark("rts:instanceName"), ""),
                        "rts:id": "0",
                    }
                    add(found, step, "rts:TargetComponent", target)
                order.append(step)
            if nested.getparent() is component:
                component.remove(nested)


def _add_unlisted(root: Any, components: list[Any], found: Findings) -> None:
    listed = {c.get(clark("rts:instanceName")) for c in components}
    after = components[-1]
    for tag in ("rts:targetDataPort", "rts:targetServicePort"):
        for end in root.iter(clark(tag)):
            component_id, name = (end.get(clark(part)) for part in _REF)
            if component_id is None or name is None or name in listed:
                continue
            listed.add(name)
            made = add(
                found,
                root,
                "rts:Components",
                {
                    "rts:id": component_id,
                    "rts:pathUri": "",
                    "rts:instanceName": name,
                    "rts:isRequired": "false",
                },
                end,
            )
            after.addnext(made)
            after = made
            text = f"component {name} is named by a connector only: added"
            found.repaired(end, "unlisted-component", text, at=clark(_REF[1]), seen=name)
