"""``rtprofile show``: summarise a profile for a person to read."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag
from rtkit.cli.shared.system_values import PARAMETERS

if TYPE_CHECKING:
    from rich.tree import Tree

    from rtkit.profile_tools.outline import Outline


@command(
    "show",
    is_local=True,
    examples=(
        ("rtprofile show robot.xml", "What is in it."),
        ("rtprofile show --json robot.xml", "The same for another program."),
    ),
)
def main(
    app: App,
    is_json: bool = json_flag("All that the profile holds, as one object."),
    parameters: None = PARAMETERS,
    files: tuple[str, ...] = arguments("[FILE]"),
) -> None:
    """Show what a profile says.

    Of a component identity, ports and parameters, of a system components, connectors and orders. A
    tree on a terminal, indented lines elsewhere. Hidden configuration sets (__widget__ and the
    like) are left out, and what only editors need.
    """
    from rtkit.cli.profiles.document import read_resolved_document

    check_at_most_one(files, "file")
    profile = read_resolved_document(app, *files).profile
    if is_json:
        import json

        from rtkit.profile.write import plain_profile

        click.echo(json.dumps(plain_profile(profile), ensure_ascii=False))
        return
    from rtkit.profile_tools.summary import summary

    outline = _printable(summary(profile))
    if terminal.is_terminal():
        _show_tree(outline)
    else:
        from rtkit.profile_tools.outline import outline_lines

        terminal.write(outline_lines([outline], terminal.display_width))


def _printable(outline: Outline) -> Outline:
    return outline._replace(
        cells=tuple(map(terminal.printable, outline.cells)),
        children=tuple(map(_printable, outline.children)),
    )


def _show_tree(outline: Outline) -> None:
    from rich.console import Console
    from rich.text import Text
    from rich.tree import Tree

    tree = Tree(Text("  ".join(outline.cells), "bold"), guide_style="dim")
    _grow(tree, outline)
    Console(no_color=not terminal.has_colour(), highlight=False).print(tree)


def _grow(tree: Tree, outline: Outline) -> None:
    from rich.text import Text

    from rtkit.profile_tools.outline import aligned

    lines = aligned(outline.children, terminal.display_width)
    for child, line in zip(outline.children, lines, strict=True):
        name = len(child.cells[0])
        text = Text.assemble((line[:name], "bold" if child.children else "cyan"), line[name:])
        _grow(tree.add(text), child)
