"""``rtkeys issue``: a key with a certificate for somebody else."""

from __future__ import annotations

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import COUNT, WordChoice, arguments, option, several

_ROLES = ("administrator", "operator", "viewer", "component")


@command(
    "issue",
    is_local=True,
    examples=(
        ("rtkeys issue anna --role viewer", "May look; the folder anna.keys is for her."),
        ("rtkeys issue robot1 --role component --host 10.0.0.7", "May serve at that address."),
    ),
    arguments=("words",),
)
def main(
    app: App,
    role: str = option(
        "--role ROLE",
        "viewer may GET, operator SET too, administrator make and end components; "
        "component SET what rules allow it.",
        WordChoice("role", _ROLES),
        required=True,
    ),
    hosts: tuple[str, ...] = several(
        "--host HOST", "Name or address that it may serve at (repeatable; default none)."
    ),
    days: int = option("--days N", "How long it is good (default 365).", COUNT, default=365),
    output: str = option("-o --output FOLDER", "Folder to make (default NAME.keys)."),
    words: tuple[str, ...] = arguments("NAME"),
) -> None:
    """Make a key and a certificate, in a new folder that is to be handed over.

    NAME is who it is in access rules. The folder holds the key: hand it over on a way that nobody
    else reads, to lie in ~/.config/rtkit/keys there, or where RTKIT_KEYS says; then remove it here.
    """
    from rtkit.keys import authority

    if len(words) != 1:
        raise WrongArguments("takes a name")
    folder = output or f"{words[0]}.keys"
    made = authority.issue(words[0], role, hosts, days, folder)
    terminal.write([f"{folder}  {made.name}  {made.role}  until {made.ends:%Y-%m-%d}"])
