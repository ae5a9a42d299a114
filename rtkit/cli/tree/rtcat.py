"""``rtcat``: describe a component, a port or a manager."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag, option
from rtkit.errors import Malformed, NotFound, Refused

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts, ProcessFacts, Snapshot
    from rtkit.rtc.names import Path
    from rtkit.rtc.profiles import PortProfile
    from rtkit.tree.view import TreeNode


@command(
    "rtcat",
    examples=(
        ("rtcat /localhost/Robot0.rtc", "Identity, state and ports of a component."),
        ("rtcat -ll /localhost/Robot0.rtc:velocity", "A port with all of its connections."),
        ("rtcat /localhost/manager.mgr", "A manager and the modules that it loaded."),
    ),
    json=("component", "port", "manager"),
    arguments=("anything:",),
)
def main(
    app: App,
    level: int = option("-l", "Unfold contexts and ports; twice: everything.", count=True),
    is_json: bool = json_flag("One JSON object."),
    paths: tuple[str, ...] = arguments("PATH"),
) -> None:
    """Describe a component, a port or a manager.

    A + marks what is there but not shown; -l and -ll unfold it.
    """
    from rtkit.cli.tree.cat import component_lines, port_lines

    if not paths:
        raise Malformed("Cannot cat a directory.")
    check_at_most_one(paths, "path")
    path = app.path(paths[0])
    node = app.node(_node, path)
    snapshot = app.tree.part([node.instance])
    facts = snapshot.component(node.instance)
    if node.is_directory:
        kind = "manager"
        lines, record = _manager(app, snapshot, _slave(snapshot, node))
    elif facts is None:
        raise NotFound(f"No such object: {path.typed}")
    elif path.port is None:
        kind = "component"
        lines = component_lines(snapshot, facts, node.name, level)
        record = _component_record(snapshot, facts)
    else:
        kind = "port"
        port = _port(facts, path)
        lines = port_lines(snapshot, facts, port, level)
        record = _port_record(snapshot, facts, port)
    if is_json:
        lines = [json_records.line(kind, {"path": str(path), **record})]
    terminal.write(lines)


def _node(root: TreeNode, path: Path, hostname: str) -> TreeNode:
    from rtkit.tree.resolve import present, zombie
    from rtkit.tree.view import NodeKind

    node = present(root, path, hostname)
    if node.is_directory:
        if path.port is not None:
            raise Refused(f"Not a component: {path.typed}")
        if node.kind is not NodeKind.MANAGER:
            hint = f"it is a directory: rtls {path.typed} lists it"
            raise NotFound(f"No such object: {path.typed} ({hint})")
    elif path.is_directory:
        raise NotFound(f"No such object: {path.typed}")
    elif node.kind is NodeKind.ZOMBIE:
        component = path.typed if path.port is None else path.typed.rpartition(":")[0]
        raise Refused(f"{zombie(node, path)}; rtvlog {component} shows what it logged")
    return node


def _manager(
    app: App, snapshot: Snapshot, process: ProcessFacts | None
) -> tuple[list[str], dict[str, Any]]:
    from rtkit.cli.shared.offers import offers
    from rtkit.cli.tree.cat import manager_lines, manager_record

    found = offers(app.tree, snapshot)
    return manager_lines(snapshot, process, found), manager_record(snapshot, process, found)


def _slave(snapshot: Snapshot, node: TreeNode) -> ProcessFacts | None:
    if not node.is_slave:
        return None
    return next(each for each in snapshot.processes if each.name == node.process)


def _port(facts: ComponentFacts, path: Path) -> PortProfile:
    port = facts.port(path.port or "")
    if port is None:
        from rtkit.tree.resolve import no_port

        raise no_port(path, (each.name for each in facts.ports))
    return port


def _component_record(snapshot: Snapshot, facts: ComponentFacts) -> dict[str, Any]:
    from rtkit.deployment.shown_ports import OwnEnds
    from rtkit.rtc.serde import encode

    connectors = OwnEnds.of(snapshot).connectors(facts, snapshot.connectors)
    return {
        "state": facts.state,
        **encode(facts),
        **({"since": json_records.time_text(int(facts.since * 1e9))} if facts.since else {}),
        "connectors": [encode(connector) for connector in connectors],
    }


def _port_record(snapshot: Snapshot, facts: ComponentFacts, port: PortProfile) -> dict[str, Any]:
    from rtkit.deployment.shown_ports import OwnEnds
    from rtkit.rtc.profiles import PortRef
    from rtkit.rtc.serde import encode

    end = OwnEnds.of(snapshot).end(PortRef(facts.instance, port.name))
    connectors = [encode(connector) for connector in snapshot.connectors if end in connector.ports]
    return {**encode(port), "connectors": connectors}
