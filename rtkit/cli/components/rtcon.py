"""``rtcon``: connect ports."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, option, several, strict_option
from rtkit.errors import Malformed, Refused, UsageProblem, from_kind

if TYPE_CHECKING:
    from rtkit.deployment.facts import Snapshot
    from rtkit.rtc.names import Path
    from rtkit.rtc.profiles import ConnectorProfile
    from rtkit.tree.client import Tree
    from rtkit.tree.wiring import ResolvedPort


@command(
    "rtcon",
    examples=(
        (
            "rtcon /localhost/Sensor0.rtc:range /localhost/Control0.rtc:range",
            "Connect an out port to an in port.",
        ),
        (
            "rtcon -p dataport.subscription_type=flush Sensor0.rtc:range Control0.rtc:range",
            "Have values sent within the writer's call.",
        ),
        (
            "rtcon -d -i range Sensor0.rtc:range Control0.rtc:range",
            "With an id of one's own, and never twice.",
        ),
    ),
    arguments=("port", "fitting"),
    values={"-i": "", "-p": "connector-property"},
)
def main(
    app: App,
    connector_id: str = option("-i --id ID", "Id of the connector.", default=""),
    name: str = option("-n --name NAME", "Name of the connector.", default=""),
    texts: tuple[str, ...] = several("-p --property KEY=VALUE", "Connector property."),
    no_duplicates: bool = flag("-d --no-duplicates", "Fail if such a connection exists."),
    strict: None = strict_option(),
    force: bool = flag("--force", "Connect ports of different data types."),
    paths: tuple[str, ...] = arguments("PORT PORT..."),
) -> None:
    """Connect the first port to each of the others.

    A port is COMPONENT:NAME; which of a data connection's ports is the out port does not matter.
    A connector joins two ports: with three ports or more there is one for each port after the
    first, and the id given with -i gets the suffix -2 for the second of them, and so on. Either
    all are made or none. Properties, and values of them, that nothing here knows are warned of.
    """
    from rtkit.component.ports.options import remarks
    from rtkit.component.ports.port_matching import ANY_DATA_TYPE
    from rtkit.rtc.far_ends import host_of, named_by, peer_of
    from rtkit.tree.expecting import expected
    from rtkit.tree.wiring import find_ends_at, in_order, make_connector

    given = _properties(app, texts) | ({ANY_DATA_TYPE: "YES"} if force else {})
    app.warn(remarks(given))
    ports = _port_paths(app, paths)
    snapshots, (first, *others) = find_ends_at(app.tree_at, ports)
    wanted: list[tuple[Tree, ConnectorProfile]] = []
    expecting: list[tuple[Tree, ConnectorProfile]] = []
    for other, each_id in zip(others, _ids(connector_id, len(others)), strict=True):
        connector = make_connector(first, other, each_id, name, given)
        out, into = in_order(first, other)
        tree = app.tree_at(out.path)
        if host_of(peer_of(connector)):
            expecting.append((app.tree_at(into.path), named_by(connector, out.manager)))
        if no_duplicates:  # the id may be in use at quite other ports
            known = tree.snapshot() if connector_id else snapshots[out.manager]
            _check_new(known, first, other, connector, name)
        wanted.append((tree, connector))
    present = {each.connector_id for s in snapshots.values() for each in s.connectors}
    with expected(expecting):
        _make(app, wanted, present)


def _properties(app: App, texts: Sequence[str]) -> dict[str, str]:
    given: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or not key:
            raise UsageProblem(f"Bad property format: {text} (it is KEY=VALUE)")
        if key in given:
            app.report(f"{app.name}: warning: property {key} is given twice, the last value holds")
        given[key] = value
    return given


def _port_paths(app: App, typed: Sequence[str]) -> list[Path]:
    if not typed:
        raise Malformed("No ports specified.")
    paths = [app.path(typed[0]), *map(app.beside, typed[1:])]
    if paths[0].port is None:
        raise Malformed("No source port specified.")
    if len(paths) < 2 or any(path.port is None for path in paths[1:]):
        raise Malformed("No destination port specified.")
    return paths


def _ids(wished: str, count: int) -> list[str]:
    if wished:
        return [wished, *(f"{wished}-{number}" for number in range(2, count + 1))]
    from uuid import uuid4

    return [str(uuid4()) for _ in range(count)]


def _check_new(
    snapshot: Snapshot, one: ResolvedPort, other: ResolvedPort, wanted: ConnectorProfile, name: str
) -> None:
    from rtkit.tree.wiring import between

    connector_id = wanted.connector_id
    if between(snapshot.connectors, wanted.ports[0], [wanted.ports[1]]):
        raise Refused(
            "An identical connection already exists between"
            f" {one.path.typed} and {other.path.typed}"
        )
    for connector in snapshot.connectors:
        if connector.connector_id == connector_id:
            raise Refused(f"A connection with ID {connector_id} already exists")
        if name and connector.name == name and not set(wanted.ports).isdisjoint(connector.ports):
            raise Refused(f"A connection with name {name} already exists at these ports")


def _make(app: App, wanted: Sequence[tuple[Tree, ConnectorProfile]], present: set[str]) -> None:
    from itertools import groupby

    from rtkit.deployment.actions import Connect, Disconnect

    made: list[tuple[Tree, str]] = []
    for tree, group in groupby(wanted, lambda each: each[0]):
        connectors = [connector for _, connector in group]
        results = tree.apply([Connect(connector) for connector in connectors])
        done = zip(connectors, results, strict=False)
        made += [(tree, connector.connector_id) for connector, result in done if result.ok]
        last = results[-1]
        if not last.ok:
            for maker, connector_id in made:
                if connector_id not in present:
                    maker.apply([Disconnect(connector_id)])
            raise from_kind(last.kind, f"Failed to make connection: {last.code.value} ({last.why})")
    for _, connector in wanted:
        app.verbose(f"{connector.ports[0]} -> {connector.ports[1]}: {connector.connector_id}")
