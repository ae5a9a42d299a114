"""``rtls``: list what is known at a place of the tree."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rtkit.cli import _out
from rtkit.cli._app import App, WrongArguments, command
from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.tree.view import Node

_BLANK = ("-", "-", "-", "-", "-")


@command("rtls")
@click.option("-l", "is_long", is_flag=True, help="State, ports and connections of each entry.")
@click.option("-R", "--recurse", is_flag=True, help="List directories below, one block each.")
@click.option("-1", "is_single", is_flag=True, help="One name a line (as when not on a terminal).")
@click.option("--json", "is_json", is_flag=True, help="One JSON object a line.")
@click.argument("paths", nargs=-1, metavar="[PATH]")
def main(
    app: App,
    paths: tuple[str, ...],
    is_long: bool,
    recurse: bool,
    is_single: bool,
    is_json: bool,
) -> None:
    """List directories, managers and components of the tree.

    Zombies have a * before their name; with -l follow the state, then ports and how many of them
    are connected: all, in, out, service.
    """
    from rtkit.tree.resolve import entry
    from rtkit.tree.view import build

    if len(paths) > 1:
        raise WrongArguments
    path = app.path(paths[0] if paths else ".")
    if path.port is not None:
        raise Malformed("Cannot list ports.")
    listing = app.tree.listing()
    node = entry(build(listing), path, listing.host)
    show = _Printer(is_long, is_single or not _out.is_terminal(), is_json)
    if recurse and node.is_directory:
        show.blocks(node, ".")
    else:
        show.entries([*node.children.values()] if node.is_directory else [node])


class _Printer:
    def __init__(self, is_long: bool, is_single: bool, is_json: bool) -> None:
        self._is_long = is_long
        self._is_single = is_single
        self._is_json = is_json

    def blocks(self, node: Node, title: str) -> None:
        if not self._is_json:
            click.echo(f"{title}:")
        self.entries([*node.children.values()])
        if not self._is_json:
            click.echo()
        for child in node.children.values():
            if child.is_directory:
                self.blocks(child, f"{title}/{child.name}")

    def entries(self, nodes: list[Node]) -> None:
        if self._is_json:
            self._print_json(nodes)
        elif self._is_long:
            self._print_long(nodes)
        elif self._is_single:
            for node in nodes:
                click.echo(_label(node)[1])
        else:
            import shutil

            width = shutil.get_terminal_size().columns
            for line in _out.columns([_label(node) for node in nodes], width):
                click.echo(line)

    def _print_json(self, nodes: list[Node]) -> None:
        import json

        for node in nodes:
            record = {"schema": "rtkit.ls/1", "path": node.path, "kind": node.kind.name.lower()}
            if node.row is not None:
                row = node.row._asdict()
                del row["names"]
                record.update(row)
            click.echo(json.dumps(record))

    def _print_long(self, nodes: list[Node]) -> None:
        table = [(_cells(node), node) for node in nodes]
        widths = [max((len(cells[i]) for cells, _ in table), default=0) + 2 for i in range(5)]
        for cells, node in table:
            counts = "".join(
                f"{cell:<{width}}" for cell, width in zip(cells[1:], widths[1:], strict=True)
            )
            click.echo(_out.state(cells[0], widths[0]) + counts + _label(node, has_slash=False)[1])


def _label(node: Node, has_slash: bool = True) -> tuple[str, str]:
    from rtkit.tree.view import Kind

    slash = "/" if has_slash and node.is_directory else ""
    star = "*" if node.kind is Kind.ZOMBIE else ""
    text = star + node.name + slash
    if node.row is not None:
        text += _remark(node)
    style = {
        Kind.HOST: "directory",
        Kind.DIRECTORY: "directory",
        Kind.MANAGER: "manager",
        Kind.ZOMBIE: "zombie",
    }.get(node.kind, "")
    return text, _out.styled(text, _out.STYLES.get(style))


def _remark(node: Node) -> str:
    return ""


def _cells(node: Node) -> tuple[str, ...]:
    from rtkit.tree.view import Kind

    row = node.row
    if row is None or node.kind is Kind.ZOMBIE:
        return _BLANK
    ports = row.ins + row.outs + row.services
    connected = row.ins_connected + row.outs_connected + row.services_connected
    return (
        row.state,
        f"{ports}/{connected}",
        f"{row.ins}/{row.ins_connected}",
        f"{row.outs}/{row.outs_connected}",
        f"{row.services}/{row.services_connected}",
    )
