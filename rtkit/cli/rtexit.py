"""``rtexit``: finalise a component and end it."""

from __future__ import annotations

import click

from rtkit.cli._app import App, check_at_most_one, command
from rtkit.errors import Malformed


@command("rtexit")
@click.argument("paths", nargs=-1, metavar="COMPONENT")
def main(app: App, paths: tuple[str, ...]) -> None:
    """Finalise a component and end it.

    Its connections and names go with it. Returns when it has ended.
    """
    from rtkit.deployment.actions import Delete
    from rtkit.tree.resolve import component
    from rtkit.tree.view import build

    if not paths:
        raise Malformed("No component specified.")
    check_at_most_one(paths, "component")
    path = app.path(paths[0])
    listing = app.tree.listing()
    node = component(build(listing), path, listing.host)
    app.tree.perform(Delete(node.instance))
