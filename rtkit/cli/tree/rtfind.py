"""``rtfind``: search the tree."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import click

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag, option, several
from rtkit.errors import Malformed, UsageProblem
from rtkit.rtc.names import glob
from rtkit.tree.resolve import present
from rtkit.tree.view import NodeKind, TreeNode, once

if TYPE_CHECKING:
    from re import Pattern

_LETTERS: dict[str, tuple[NodeKind, ...]] = {
    "c": (NodeKind.COMPONENT,),
    "d": (NodeKind.ROOT, NodeKind.HOST, NodeKind.DIRECTORY, NodeKind.MANAGER),
    "m": (NodeKind.MANAGER,),
    "n": (NodeKind.HOST,),
    "z": (NodeKind.ZOMBIE,),
}


@command(
    "rtfind",
    examples=(
        ("rtfind / -t c -n 'Motor*.rtc'", "All components whose name begins with Motor."),
        ("rtfind /localhost -t z", "All zombies of this host."),
        ("rtfind . -m 1 -i 'motor?.rtc'", "In this directory, capitals or not."),
    ),
    json=("entry",),
    arguments=("directory",),
)
def main(
    app: App,
    letters: str = option(
        "-t --type TYPES",
        "Any of c components, d directories (managers and hosts too), m managers, n hosts,"
        " z zombies (default: all).",
        default="".join(_LETTERS),
    ),
    names: tuple[str, ...] = several("-n --name PATTERN", "Name, with * and ?."),
    inames: tuple[str, ...] = several("-i --iname PATTERN", "The same, any case."),
    depth: int = option(
        "-m --maxdepth LEVELS",
        "So many levels below the start; 0, the default: all.",
        click.IntRange(min=0),
        default=0,
    ),
    unique: bool = flag("-u --unique", "Each component once, not also below its managers."),
    is_json: bool = json_flag("One JSON object a line, as rtls --json."),
    starts: tuple[str, ...] = arguments("START"),
) -> int:
    """Search the tree.

    Prints the path of each entry, START among them, that is of one of the types and whose name
    matches one of the patterns. Nothing found is no failure; a manager that does not answer,
    and so could not be searched, is.
    """
    if not starts:
        raise WrongArguments("No start specified.")
    check_at_most_one(starts, "start")
    kinds = _kinds(letters)
    patterns = [glob(each) for each in names]
    patterns += [glob(each, any_case=True) for each in inames]
    root, start = _start(app, starts[0])
    nodes = list(_walk(start, depth or -1))
    found = [node for node in nodes if node.kind in kinds and _matches(node.name, patterns)]
    found = once(found) if unique else found
    if is_json:
        from rtkit.cli.tree.rtls import entry_record

        terminal.write(json_records.lines("entry", map(entry_record, found)))
    else:
        terminal.write(terminal.printable(node.path) for node in found)
    return app.report_silent(root, nodes, "searched")


def _kinds(letters: str) -> set[NodeKind]:
    unknown = [letter for letter in letters if letter not in _LETTERS]
    if unknown:
        raise UsageProblem(f"no type of entry: {unknown[0]} (any of {''.join(_LETTERS)})")
    return {kind for letter in letters for kind in _LETTERS[letter]}


def _matches(name: str, patterns: Sequence[Pattern[str]]) -> bool:
    return not patterns or any(pattern.fullmatch(name) for pattern in patterns)


def _start(app: App, typed: str) -> tuple[TreeNode, TreeNode]:
    """Return the root of the tree and the node from which to search."""
    path = app.path(typed)
    if path.port is not None:
        raise Malformed(f"Not a directory: {path.typed}")
    root, hostname = app.root(path, is_deep=True)
    node = present(root, path, hostname)
    if path.is_directory and not node.is_directory:
        raise Malformed(f"Not a directory: {path.typed}")
    return root, node


def _walk(node: TreeNode, depth: int) -> Iterator[TreeNode]:
    yield node
    for child in node.entries() if depth else ():
        yield from _walk(child, depth - 1)
