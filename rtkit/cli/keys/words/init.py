"""``rtkeys init``: a CA of this user."""

from __future__ import annotations

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, option, several


@command(
    "init",
    is_local=True,
    examples=(
        ("rtkeys init", "For this user, at localhost and the name of this host."),
        ("rtkeys init --name anna --host 192.168.1.2", "Other hosts know this one by an address."),
    ),
    arguments=(),
)
def main(
    app: App,
    name: str = option("--name NAME", "Name of this user in rules (default the user name)."),
    hosts: tuple[str, ...] = several("--host HOST", "Name or address of this host (repeatable)."),
    words: tuple[str, ...] = arguments(""),
) -> None:
    """Make a private CA, and a certificate of this user with the role administrator.

    Keys that are there already are never overwritten. The key of the CA stays where it is made: its
    holder can let others in.
    """
    import getpass

    from rtkit.keys import authority, folder
    from rtkit.link.places import host_name

    if words:
        raise WrongArguments(f"takes no arguments: {words[0]}")
    here = dict.fromkeys(("localhost", "127.0.0.1", "::1", host_name(), *hosts))
    authority.init(name or getpass.getuser(), [*here])
    app.verbose(f"the CA is in {folder.path()}")
