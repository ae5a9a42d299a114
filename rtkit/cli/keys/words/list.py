"""``rtkeys list``: which certificates were issued, and which are good."""

from __future__ import annotations

from rtkit.cli.keys.shown import show
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag


@command(
    "list",
    is_local=True,
    examples=(
        ("rtkeys list", "Name, role, serial number, from, until, whether it is good."),
        ("rtkeys list --json", "The same, for another program."),
    ),
    json=("certificate",),
    arguments=(),
)
def main(app: App, is_json: bool = json_flag(), words: tuple[str, ...] = arguments("")) -> None:
    """List the certificates that the CA issued; warn of those that end within 30 days."""
    from rtkit.keys import authority

    if words:
        raise WrongArguments(f"takes no arguments: {words[0]}")
    show(app, authority.issued(), is_json=is_json)
