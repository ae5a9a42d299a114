"""Renders components, ports and connections as the lines that ``rtcat`` prints.

`level` tells how much is unfolded: 0 nothing, 1 contexts and ports, 2 everything.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from rtkit.cli.shared import terminal
from rtkit.rtc.names import COMPONENT_SUFFIX, MANAGER_SUFFIX
from rtkit.rtc.profiles import DEFINITION

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts, Snapshot
    from rtkit.rtc.profiles import (
        ConnectorProfile,
        ExecutionContextProfile,
        PortInterfaceProfile,
        PortProfile,
    )

_KINDS = {"PERIODIC": "Periodic", "EVENT_DRIVEN": "Event-driven"}
_REFERENCES = ("inport_ior", "inport_ref", "outport_ior", "outport_ref")


def component_lines(snapshot: Snapshot, facts: ComponentFacts, name: str, level: int) -> list[str]:
    """Describe a component that is shown under `name`."""
    lines = [f"{_bold(name)}  {terminal.state(facts.state)}", *terminal.pairs(_identity(facts))]
    lines += _folded(" ", "Extra properties", _sorted(facts.properties), level > 1)
    for number, context in enumerate(facts.contexts):
        lines += _context_lines(context, number, level)
    for port in facts.ports:
        lines += port_lines(snapshot, facts, port, level)
    return lines + _composition_lines(snapshot, facts, level)


def _kind(facts: ComponentFacts) -> str:
    kind = "Composite" if facts.composite_type else "Monolithic"
    return f"{kind} composite member" if facts.composite else kind


def _composition_lines(snapshot: Snapshot, facts: ComponentFacts, level: int) -> list[str]:
    """Describe a composite's members, and the composite that a component is a member of."""
    lines = []
    if facts.composite_type:
        members = [("Member", _path_of(snapshot, name)) for name in facts.members]
        lines += _composition("Composition", [("ID", facts.instance), *members], level)
    if facts.composite:
        known = [("ID", facts.composite), ("Path", _path_of(snapshot, facts.composite))]
        lines += _composition("Parent composition", known, level)
    return lines


def _composition(title: str, known: list[tuple[str, str]], level: int) -> list[str]:
    head = f"{'-' if level else '+'}{title} {_bold(known[0][1])}"
    return [head, *terminal.pairs(known)] if level else [head]


def _path_of(snapshot: Snapshot, instance: str) -> str:
    facts = snapshot.component(instance)
    return f"/{facts.names[0]}" if facts is not None and facts.names else instance


def _identity(facts: ComponentFacts) -> list[tuple[str, str]]:
    known = [
        ("Category", facts.type.category),
        ("Description", facts.type.description),
        ("Instance name", facts.instance),
        ("Type name", facts.type.type_name),
        ("Vendor", facts.type.vendor),
        ("Version", facts.type.version),
        *((("Parent", facts.composite),) if facts.composite else ()),
        ("Type", _kind(facts)),
    ]
    where = [("Stand-in", "yes")] if facts.is_stand_in else []
    where += [("Cause", facts.cause)] if facts.cause else []
    where += _limits(facts)
    restart_status = facts.restart_status
    told = (
        ("Trouble", facts.trouble or restart_status.trouble),
        ("Restarts", restart_status.again),
        ("Stopped", restart_status.stops),
    )
    where += [each for each in told if each[1]]
    return known + where


def _limits(facts: ComponentFacts) -> list[tuple[str, str]]:
    from rtkit.deployment.extension import LIMIT

    if LIMIT not in facts.create:
        return []
    from rtkit.deployment.limits import limits_in

    limits = limits_in(facts.create)
    return [("Limits", f"{limits.text} (slave {facts.process})")] if limits else []


def _context_lines(context: ExecutionContextProfile, number: int, level: int) -> list[str]:
    title = f"Execution Context {_bold(str(number))}"
    if level < 1:
        return [f"+{title}"]
    rows = [
        ("State", "Running" if context.is_running else "Stopped"),
        ("Kind", _KINDS.get(context.kind, "Other")),
        ("Rate", str(context.rate)),
        ("Owner", context.owner),
    ]
    lines = [f"-{title}", *terminal.pairs(rows)]
    members = [(name, "") for name in context.participants]
    lines += _folded(" ", "Participants", members, level > 1)
    return lines + _folded(" ", "Extra properties", _sorted(context.properties), level > 1)


def port_lines(
    snapshot: Snapshot, facts: ComponentFacts, port: PortProfile, level: int
) -> list[str]:
    """Describe a port of a component, with its connections."""
    title = f"{port.port_type.value}: {_bold(port.name)}"
    if level < 1:
        return [f"+{title}"]
    from rtkit.deployment.shown_ports import OwnEnds
    from rtkit.rtc.profiles import PortRef

    shown = {name: value for name, value in port.properties.items() if name != DEFINITION}
    lines = [f"-{title}", *terminal.pairs(_sorted(shown))]
    for interface in port.interfaces:
        lines += _interface_lines(interface)
    unresolved = 0
    own = OwnEnds.of(snapshot).end(PortRef(facts.instance, port.name))
    for connector in snapshot.connectors:
        others = [end for end in connector.ports if end != own]
        if len(others) == len(connector.ports):
            continue
        paths = [path for end in others if (path := port_path(snapshot, end.instance, end.port))]
        if paths or not others:
            lines += _connection_lines(
                connector, paths or [port_path(snapshot, facts.instance, port.name)], level
            )
        else:
            unresolved += 1
    if unresolved:
        from rtkit.report.finding import counted

        lines.append(f" ({counted(unresolved, 'other connection')})")
    return lines


def _interface_lines(interface: PortInterfaceProfile) -> list[str]:
    rows = [
        ("Instance name", interface.instance_name),
        ("Type name", interface.type_name),
        ("Polarity", interface.polarity.value),
    ]
    return ["  Interface:", *terminal.pairs(rows, "    ")]


def _connection_lines(connector: ConnectorProfile, paths: list[str], level: int) -> list[str]:
    mark = "-" if level > 1 else "+"
    head = f" {mark}Connected to  "
    first, *others = [_bold(path) for path in paths]
    lines = [head + first, *(" " * len(head) + other for other in others)]
    if level < 2:
        return lines
    shown = {k: v for k, v in connector.properties.items() if not k.endswith(_REFERENCES)}
    return lines + terminal.pairs(
        [("Name", connector.name), ("ID", connector.connector_id), *_sorted(shown)]
    )


def component_path(snapshot: Snapshot, facts: ComponentFacts) -> str:
    """Return where a component is found: its first name, else the place below its manager."""
    if facts.names:
        return "/" + facts.names[0]
    usual = f"localhost/{snapshot.manager}{MANAGER_SUFFIX}"
    manager = snapshot.names[0] if snapshot.names else usual
    return f"/{manager}/{facts.instance}{COMPONENT_SUFFIX}"


def port_path(snapshot: Snapshot, instance: str, port: str) -> str:
    """Return the path of a port; empty when nobody knows its component."""
    facts = snapshot.component(instance)
    return "" if facts is None else f"{component_path(snapshot, facts)}:{port}"


def _bold(text: str) -> str:
    return terminal.styled(text, terminal.STYLES["name"])


def _folded(indent: str, title: str, rows: list[tuple[str, str]], is_unfolded: bool) -> list[str]:
    if not rows:
        return []
    if not is_unfolded:
        return [f"{indent}+{title}"]
    return [f"{indent}-{title}", *terminal.pairs(rows)]


def _sorted(properties: Mapping[str, str]) -> list[tuple[str, str]]:
    return sorted(properties.items())
