"""``rthost remove``: forget a host."""

from __future__ import annotations

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments
from rtkit.errors import Unreachable


@command(
    "remove",
    examples=(
        ("rthost remove robot1", "Forget it, and end the link to it."),
        ("rthost remove robot1 -v", "So, and tell whether it was linked."),
    ),
    arguments=("known-host",),
)
def main(app: App, words: tuple[str, ...] = arguments("NAME")) -> None:
    """Remove a host from the inventory of the user, and end the link to it.

    Its manager runs on: rtmgr stop --host NAME ends it before.
    """
    from rtkit.hosts import inventory
    from rtkit.link import host_links
    from rtkit.tree.connect import connect

    if len(words) != 1:
        raise WrongArguments("takes the name of a host")
    (name,) = words
    inventory.remove(name)
    if not host_links.is_linked(name):
        return
    try:
        with connect(host_links.read(name).manager, app.timeout_s) as tree:
            tree.set("unlink_host", name)
    except Unreachable as error:  # without its manager there is no link
        app.verbose(str(error))
