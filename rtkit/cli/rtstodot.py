"""``rtstodot``: a system, of a profile or live, as a graph for Graphviz."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import click

from rtkit.cli import _out
from rtkit.cli._app import App, WrongArguments, command
from rtkit.cli.system import shared
from rtkit.errors import UsageProblem

if TYPE_CHECKING:
    from rtkit.profile.rts_model import RtsProfile

_TITLE = "rtsprofile"
_FILLS = {"Active": "palegreen", "Inactive": "lightblue", "Error": "tomato"}
_ZOMBIE = "lightgrey"


@command("rtstodot")
@shared.form_options("Read", "; without -x and -y, as name and content say", "yaml", "xml")
@click.option("--live", is_flag=True, help="Draw what lives, with colours for states.")
@click.argument("files", nargs=-1, metavar="[FILE]")
def main(app: App, files: tuple[str, ...], live: bool) -> int:
    """Write the system of an RTS profile as a graph for Graphviz.

    It is read from FILE, or from stdin. Components are boxes with their ports at both sides,
    connectors arrows, those of services dashed. With --live a manager is asked, else nothing
    needs to run.
    """
    from rtkit.drawing.dot import dot_lines
    from rtkit.profile_tools.system_scene import system_scene

    if live:
        if files or app.form:
            raise UsageProblem("--live draws what lives: no file, no form")
        profile, fills = _living(app)
    else:
        if not files and (sys.stdin is None or sys.stdin.isatty()):
            raise WrongArguments("No file specified; --live draws what lives.")
        from rtkit.cli.system.document import read_document

        profile, fills = read_document(app, files, strict=False).profile, {}
    _out.write(dot_lines(system_scene(profile), _TITLE, fills))
    return app.tell_silent_servers("not drawn") if live else 0


def _living(app: App) -> tuple[RtsProfile, dict[str, str]]:
    """Return what lives as a profile, and the colour of each component."""
    from rtkit.deployment.capture import Heading, capture
    from rtkit.records import replace

    snapshot = shared.snapshot(app)
    drawn = replace(
        snapshot, components=tuple(replace(each, zombie="") for each in snapshot.components)
    )  # a system that is saved has no zombies, a picture shows them
    heading = Heading("1970-01-01T00:00:00", _TITLE, "0", "rtkit", "")
    profile = capture(drawn, heading, takes_all=True)
    fills = {
        each.instance: _ZOMBIE if each.zombie else _FILLS.get(each.state, "")
        for each in snapshot.components
    }
    return profile, fills
