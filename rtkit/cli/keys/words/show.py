"""``rtkeys show``: the certificate that this user shows to others."""

from __future__ import annotations

from rtkit.cli.keys.shown import show
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag


@command(
    "show",
    is_local=True,
    examples=(
        ("rtkeys show", "Who am I for others, and how long?"),
        ("rtkeys show --json", "The same, for another program."),
    ),
    json=("certificate",),
    arguments=(),
)
def main(app: App, is_json: bool = json_flag(), words: tuple[str, ...] = arguments("")) -> None:
    """Show the certificate that commands and services of this user show to others."""
    from rtkit.keys import authority

    if words:
        raise WrongArguments(f"takes no arguments: {words[0]}")
    show(app, [authority.own()], is_json=is_json)
