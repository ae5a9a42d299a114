"""``rtkeys revoke``: a certificate counts no longer."""

from __future__ import annotations

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments


@command(
    "revoke",
    is_local=True,
    examples=(
        ("rtkeys revoke anna", "All certificates of that name."),
        ("rtkeys revoke 2f0c61", "The one with this serial number, as rtkeys list shows it."),
    ),
    arguments=("words",),
)
def main(app: App, words: tuple[str, ...] = arguments("NAME|SERIAL")) -> None:
    """Revoke certificates.

    Services of this folder of keys let them in no longer, and end their connections within a
    second. Other hosts do so when they are given the new revoked.crl.
    """
    from rtkit.keys import authority

    if len(words) != 1:
        raise WrongArguments("takes a name or a serial number")
    for each in authority.revoke(words[0]):
        app.verbose(f"revoked: {each.name} {each.role} {each.serial}")
