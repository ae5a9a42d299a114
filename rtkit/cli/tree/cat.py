"""Renders components, ports, connections and managers as the lines that ``rtcat`` prints.

`level` tells how much is unfolded: 0 nothing, 1 contexts and ports, 2 everything.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from rtkit.cli.shared import terminal
from rtkit.cli.shared.component_paths import port_path
from rtkit.rtc.profiles import DEFINITION

if TYPE_CHECKING:
    from rtkit.cli.shared.offers import Offers
    from rtkit.deployment.facts import ComponentFacts, ProcessFacts, Snapshot
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
    where += [*_limits(facts), *_old_code(facts)]
    restart_status = facts.restart_status
    rows = (
        ("Trouble", facts.trouble or restart_status.trouble),
        ("Input", facts.waits),
        ("Restarts", restart_status.again),
        ("Stopped", restart_status.stops),
    )
    where += [each for each in rows if each[1]]
    return known + where


def _limits(facts: ComponentFacts) -> list[tuple[str, str]]:
    from rtkit.deployment.extension import LIMIT

    if LIMIT not in facts.create:
        return []
    from rtkit.deployment.limits import limits_in

    limits = limits_in(facts.create)
    return [("Limits", f"{limits.text} (slave {facts.process})")] if limits else []


def _old_code(facts: ComponentFacts) -> list[tuple[str, str]]:
    if not facts.code:
        return []
    from rtkit.api.looking import present_code

    file = facts.changed_code(present_code([facts]))
    return [("Code", f"changed since it was loaded ({file})")] if file else []


def _context_lines(context: ExecutionContextProfile, number: int, level: int) -> list[str]:
    title = f"Execution Context {_bold(str(number))}"
    if level < 1:
        return [f"+{title}"]
    rows = [
        ("State", "Running" if context.is_running else "Stopped"),
        ("Kind", _KINDS.get(context.kind, "Other")),
        ("Rate", str(context.rate)),
        *((("Missed periods", str(context.missed)),) if context.missed else ()),
        *((("Trouble", f"runs without {context.trouble}"),) if context.trouble else ()),
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
    lines += [f"{' ' * len(head)}half: {connector.trouble}"] if connector.trouble else []
    if level < 2:
        return lines
    shown = {k: v for k, v in connector.properties.items() if not k.endswith(_REFERENCES)}
    return lines + terminal.pairs(
        [("Name", connector.name), ("ID", connector.connector_id), *_sorted(shown)]
    )


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


_MODULES = (
    ("Load path", "manager.modules.load_path"),
    ("Config path", "manager.modules.config_path"),
    ("Preload", "manager.modules.preload"),
    ("Init function prefix", "manager.modules.init_func_prefix"),
    ("Init function suffix", "manager.modules.init_func_suffix"),
    ("Download allowed", "manager.modules.download_allowed"),
    ("Absolute path allowed", "manager.modules.abs_path_allowed"),
)
_SYSTEM = (
    ("Version", "os.version"),
    ("Architecture", "os.arch"),
    ("Release", "os.release"),
    ("Host name", "os.hostname"),
    ("Name", "os.name"),
)


def manager_lines(snapshot: Snapshot, process: ProcessFacts | None, offers: Offers) -> list[str]:
    """Describe a manager, or a slave of it by the facts of its process."""
    known = snapshot.properties
    name = snapshot.manager if process is None else process.name
    title = known.get("manager.instance_name", name) if process is None else name
    rows = [
        ("Name", known.get("manager.name", name) if process is None else name),
        ("Instance name", title),
        ("Process ID", str(snapshot.pid if process is None else process.pid)),
        ("Naming format", known.get("manager.naming_formats", "")),
        ("Refstring path", known.get("manager.refstring_path", "")),
        ("Components precreate", known.get("manager.components.precreate", "")),
    ]
    shown = _process(snapshot, process)
    if shown is not None and (shown.state != "up" or shown.reason):
        rows += [("State", f"{shown.state} {shown.reason}")]
    lines = _titled(rows)
    lines += ["Modules:", *_titled([(t, known.get(key, "")) for t, key in _MODULES], "  ")]
    lines += ["OS:", *_titled([(t, known.get(key, "")) for t, key in _SYSTEM], "  ")]
    lines += ["Loaded modules:"]
    paths = dict.fromkeys(module.path for module in snapshot.modules)
    lines += _titled([("Filepath", path) for path in paths], "  ")
    return [*lines, "Loadable modules:", *(f"  {terminal.printable(id)}" for id in offers.types)]


def _process(snapshot: Snapshot, slave: ProcessFacts | None) -> ProcessFacts | None:
    """Return the facts of the process that is shown: a slave, else the manager's own."""
    own = (process for process in snapshot.processes if process.pid == snapshot.pid)
    return slave if slave is not None else next(own, None)


def _titled(rows: Iterable[tuple[str, str]], indent: str = "") -> list[str]:
    return [f"{indent}{title}: {terminal.printable(text)}".rstrip() for title, text in rows]


def manager_record(
    snapshot: Snapshot, process: ProcessFacts | None, offers: Offers
) -> dict[str, Any]:
    """Return the facts of a manager, or of a slave of it, for JSON."""
    from rtkit.rtc.serde import encode

    shown = _process(snapshot, process)
    return {
        "name": snapshot.manager if process is None else process.name,
        "pid": snapshot.pid if process is None else process.pid,
        "state": "up" if process is None else process.state,
        "reason": shown.reason if shown is not None else "",
        "version": snapshot.version,
        "modules": [encode(module) for module in snapshot.modules],
        "loadable": [{"type": id, "module": file} for id, file in offers.types.items()],
        "properties": dict(snapshot.properties),
    }
