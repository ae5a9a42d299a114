"""``rtstodot``: a system, of a profile or live, as a graph for Graphviz."""

from __future__ import annotations

import sys

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag
from rtkit.cli.shared.system_values import PARAMETERS
from rtkit.cli.system import shared
from rtkit.errors import UsageProblem

_TITLE = "rtsprofile"


@command(
    "rtstodot",
    examples=(
        ("rtstodot robot.xml > robot.dot", "The graph of a system; dot -Tsvg draws it."),
        ("rtcryo | rtstodot", "Of what is saved now; rtstodot --live shows states too."),
    ),
    arguments=("profile",),
)
def main(
    app: App,
    forms: None = shared.READ_FORMS,
    live: bool = flag("--live", "Draw what lives, with colours for states."),
    parameters: None = PARAMETERS,
    files: tuple[str, ...] = arguments("[FILE]"),
) -> int:
    """Write the system of an RTS profile as a graph for Graphviz.

    It is read from FILE, or from stdin. Components are boxes with their ports at both sides,
    connectors arrows, those of services dashed. With --live a manager is asked, else nothing
    needs to run.
    """
    from rtkit.drawing.export import exported

    if live:
        if files or app.form:
            raise UsageProblem("--live draws what lives: no file, no form")
        from rtkit.api.live_scene import live_scene

        scene = live_scene(app)
    else:
        if not files and (sys.stdin is None or sys.stdin.isatty()):
            raise WrongArguments("No file specified; --live draws what lives.")
        from rtkit.cli.system.document import read_as_is
        from rtkit.profile_tools.system_scene import system_scene

        scene = system_scene(read_as_is(app, files).profile)
    terminal.write(exported(scene, "dot", _TITLE).splitlines())
    return app.report_silent_servers("not drawn") if live else 0
