"""``rtls``: list what is known at a place of the tree."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import MayWatch, arguments, flag, json_flag, watch_option
from rtkit.cli.shared.watch import WatchedScreen
from rtkit.cli.tree.service_listing import ServiceListing, above_services, no_service_at, service_at
from rtkit.errors import Malformed, Unreachable
from rtkit.tree.resolve import entry
from rtkit.tree.view import NodeKind, TreeNode, once

if TYPE_CHECKING:
    from rtkit.rtc.names import Path

_Show = Callable[[list[TreeNode]], Iterable[str]]
_BLANK = ("-", "-", "-", "-", "-")
_STYLES = {
    NodeKind.HOST: "directory",
    NodeKind.DIRECTORY: "directory",
    NodeKind.MANAGER: "manager",
    NodeKind.ZOMBIE: "zombie",
}


@command(
    "rtls",
    cls=MayWatch,
    examples=(
        ("rtls -l /localhost", "State, ports and connections of what runs here."),
        ("rtls -R /", "Everything."),
        ("rtls -l --watch=0.5 /localhost", "Look again twice a second."),
        ("rtls -R --json /", "Everything, for another program."),
        ("rtls -l robot", "The properties of an object that rtserve serves."),
    ),
    json=("entry",),
    arguments=("anything",),
)
def main(
    app: App,
    is_long: bool = flag("-l", "State, ports and connections of each entry."),
    recurse: bool = flag("-R --recurse", "List directories below, one block each."),
    unique: bool = flag("-u --unique", "Each component once, not also below its managers."),
    is_single: bool = flag("-1", "One name a line (as when not on a terminal)."),
    is_json: bool = json_flag(),
    period_s: float | None = watch_option(
        "List again whenever something has changed, after a second or --watch=SECONDS at least."
    ),
    paths: tuple[str, ...] = arguments("[PATH]"),
) -> int:
    """List directories, managers and components of the tree.

    Without a path: the working directory (RTKIT_CWD). A zombie, an entry with nobody behind it, has
    a * before its name. With -l each line tells the state, then ports and how many of them are
    connected (all, in, out, service), then the name and in brackets what else to know. Of a served
    object (rtserve): its properties; with -l type, access, unit, quality, name, value. Managers and
    services that talk with other hosts without TLS (--insecure) are told on standard error by each
    -l. Managers that do not answer, whose entries are missing, are told, and the status is 1 then.
    Watched, it is written again only when it has changed, on a terminal in place of what was.
    """
    check_at_most_one(paths, "path")
    typed = paths[0] if paths else "."
    path = app.path(typed)
    if path.port is not None:
        raise Malformed("Cannot list ports.")
    gap = "" if is_json else "\n"
    service = service_at(typed)
    if service is not None:
        if is_long:
            _show_insecure(app)
        listing = ServiceListing(app, service, is_long, recurse, is_json, is_single)
        if period_s is None:
            terminal.write(listing.look())
        else:
            from rtkit.cli.tree.service_watch import watch_service

            watch_service(listing, WatchedScreen(period_s, gap))
        return 0
    path = app.path(above) if (above := above_services(typed)) else path
    show = _json if is_json else _long if is_long else _short(is_single)

    def look() -> tuple[TreeNode, TreeNode]:
        try:
            root, hostname = app.root(path, is_deep=recurse or is_long)
        except Unreachable as error:
            raise no_service_at(typed) or error from None
        return root, entry(root, path, hostname)

    def lines(node: TreeNode) -> Iterable[str]:
        if not node.is_directory:
            return show([node])
        below = list(node.walk())[1:] if recurse else node.entries()
        kept = once(below) if unique else below
        return _blocks(node, ".", set(kept), show) if recurse and not is_json else show(kept)

    if is_long:
        _show_insecure(app)
    if period_s is None:
        root, node = look()
        terminal.write(lines(node))
        return app.report_silent(root, node.walk() if recurse else (), "listed")
    _watch(app, path, lambda: lines(look()[1]), WatchedScreen(period_s, gap))
    return 0


def _show_insecure(app: App) -> None:
    """Tell what of this user other hosts reach without TLS."""
    from rtkit.link import insecure

    for address in insecure.noted():
        app.fail(f"insecure: {address} (rtserve and rtproxy --insecure: without TLS)")


def _watch(app: App, path: Path, look: Callable[[], Iterable[str]], sight: WatchedScreen) -> None:
    """Show again when something has changed."""
    from rtkit.api.observers import Observers
    from rtkit.cli.shared.signals import resizing
    from rtkit.deployment.delta import TREE
    from rtkit.tree.subscription import SubscriptionEnded

    is_wide = len(path.elements) < 2
    with (
        Observers(app, (TREE,), is_wide=is_wide) as subscriptions,
        resizing(terminal.is_terminal()) as wakeup,
    ):
        for events in subscriptions.listen(None, (wakeup.fileno(),), sight.due):
            if wakeup.take():
                sight.forget()
            for each in events:
                if isinstance(each.event, SubscriptionEnded):
                    app.fail(f"{each.event.why}; waiting for it to come back")
                sight.stale()
            if not sight.is_due or "" not in subscriptions.subscriptions:
                continue
            try:
                sight.show(look)
            except Unreachable as error:  # it is ending: the subscriptions report that
                app.verbose(str(error))


def _blocks(node: TreeNode, title: str, kept: Container[TreeNode], show: _Show) -> Iterator[str]:
    yield f"{terminal.printable(title)}:"
    yield from show([child for child in node.entries() if child in kept])
    yield ""
    for child in node.entries():
        if child.is_directory and (child.children or child.kind is not NodeKind.DIRECTORY):
            yield from _blocks(child, f"{title}/{child.name}", kept, show)


def _short(is_single: bool) -> _Show:
    if is_single or not terminal.is_terminal():
        return lambda nodes: [_label(node, "/")[1] for node in nodes]

    return lambda nodes: terminal.columns([_label(node, "/") for node in nodes])


def _long(nodes: list[TreeNode]) -> list[str]:
    rows = [_cells(node) for node in nodes]
    widths = [max(map(len, column)) + 2 for column in zip(*rows, strict=True)]
    show_state = terminal.state if terminal.has_colour() else str.ljust
    lines = []
    for node, (state, *counts) in zip(nodes, rows, strict=True):
        cells = "".join(map(str.ljust, counts, widths[1:]))
        line = show_state(state, widths[0]) + cells + _label(node, "")[1]
        remark = node.remark
        lines.append(f"{line}  ({terminal.printable(remark)})" if remark else line)
    return lines


def _json(nodes: list[TreeNode]) -> Iterator[str]:
    for node in nodes:
        yield json_records.line("entry", entry_record(node))


def entry_record(node: TreeNode) -> dict[str, object]:
    """Return the record of an entry in a listing, for JSON."""
    row = {} if node.row is None else node.row._asdict()
    if node.kind is NodeKind.ZOMBIE:
        row["state"] = None  # the last known state is that of a dead process
    kind = node.kind.name.lower()
    return {"path": node.path, "kind": kind, **row, "remark": node.remark}


def _label(node: TreeNode, slash: str) -> tuple[str, str]:
    star = "*" if node.kind is NodeKind.ZOMBIE else ""
    text = terminal.printable(star + node.name + (slash if node.is_directory else ""))
    return text, terminal.styled(text, terminal.STYLES.get(_STYLES.get(node.kind, "")))


def _cells(node: TreeNode) -> tuple[str, ...]:
    row = node.row
    if row is None or node.kind is NodeKind.ZOMBIE:
        return _BLANK
    ports = row.ins + row.outs + row.services
    connected = row.ins_connected + row.outs_connected + row.services_connected
    return (
        terminal.printable(row.state),
        f"{ports}/{connected}",
        f"{row.ins}/{row.ins_connected}",
        f"{row.outs}/{row.outs_connected}",
        f"{row.services}/{row.services_connected}",
    )
