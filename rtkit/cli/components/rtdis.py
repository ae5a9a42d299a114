"""``rtdis``: remove connections."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, option
from rtkit.errors import Malformed, NotFound, Partial, from_kind

if TYPE_CHECKING:
    from rtkit.rtc.names import Path
    from rtkit.rtc.profiles import ConnectorProfile


@command(
    "rtdis",
    examples=(
        ("rtdis /localhost/Robot0.rtc", "Remove every connection of a component."),
        ("rtdis -i range /localhost/Sensor0.rtc:range", "Only the one of that id."),
        ("rtdis Sensor0.rtc:range Control0.rtc:range", "Those between two ports."),
    ),
    arguments=("connected", "connected-to"),
)
def main(
    app: App,
    connector_id: str = option("-i --id ID", "Only this connector.", default=""),
    paths: tuple[str, ...] = arguments("COMPONENT|PORT..."),
) -> None:
    """Remove connections.

    Of a component: all of all its ports. Of one port: all of it. With more ports: those of the
    first port with any of the others.
    """
    if not paths:
        raise WrongArguments("No component or port specified.")
    found = [app.path(paths[0]), *map(app.beside, paths[1:])]
    if len(found) > 1:
        _check_ports(found)
    connectors = _connections(app, found)
    if connector_id:
        connectors = [
            connector for connector in connectors if connector.connector_id == connector_id
        ]
        if not connectors:
            raise NotFound(f"No connection from {paths[0]} with ID {connector_id}")
    elif len(found) > 1 and not connectors:
        raise NotFound("No connection found involving the specified ports.")
    _remove(app, connectors)


def _check_ports(paths: Sequence[Path]) -> None:
    for path in paths:
        if path.port is None or path.is_directory:
            raise Malformed(f"Not a port: {path.typed}")


def _connections(app: App, paths: Sequence[Path]) -> list[ConnectorProfile]:
    from rtkit.tree.resolve import component
    from rtkit.tree.wiring import between_paths, of_component

    if paths[0].port is None:
        instance = app.node(component, paths[0]).instance
        return of_component(app.tree.part([instance]), instance)
    return between_paths(app.tree, app.tree_at, app.is_at_tree, paths)


def _remove(app: App, wires: Sequence[ConnectorProfile]) -> None:
    from rtkit.deployment.actions import Disconnect

    if not wires:
        return
    results = app.tree.apply([Disconnect(w.connector_id) for w in wires], is_ordered=False)
    for result in results:
        if result.note:
            app.fail(f"note: {result.note}")
    failures = [
        (connector.connector_id, from_kind(result.kind, f"{result.why}: {connector.connector_id}"))
        for connector, result in zip(wires, results, strict=True)
        # Somebody else removed it in the meantime: the request is fulfilled.
        if not result.ok and result.kind != NotFound.kind
    ]
    if failures:
        raise Partial(f"{len(failures)} of {len(wires)} connections remain", failures)
