"""``rtgui``: a panel of a live service in the terminal."""

from __future__ import annotations

import sys

import click

from rtkit.cli.properties.asking import AT
from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import argument, option
from rtkit.errors import Malformed, Refused


@command(
    "rtgui",
    is_local=True,
    examples=(
        ("rtgui robots/r1", "All of a service: sliders, switches, actions, places on a map."),
        ("rtgui robots/r1.arm --as panel", "A part; what its user does is at panel.input."),
        ("rtgui --at 127.0.0.1:2810 robots/r1", "A service behind an endpoint."),
    ),
    arguments=("live",),
)
def main(
    app: App,
    at: str | None = AT,
    name: str = option("--as NAME", "Serve the panel: each widget is a property of NAME."),
    components: str = option(
        "--components SERVICE", "The GUI service, which has components by type (default: gui)."
    ),
    target: str = argument("TARGET"),
) -> None:
    """Show a panel of a live service: see and set its properties.

    TARGET is a service, or a part of one (SERVICE.PART), as of rtget. Tab goes from one widget to
    the next, arrow keys move it, Enter has a value typed or an action started, s stops that; q ends
    the panel. Properties that are away, stale or alarming are marked by words.
    """
    if not (terminal.is_terminal() and sys.stderr.isatty()):  # textual draws on stderr
        raise Refused("a panel needs a terminal; for values as text: rtget, rtlisten")
    try:
        from rtkit.panel.terminal import PanelApp
    except ImportError as error:
        if not (error.name or "").startswith("textual"):
            raise
        from rtkit.extras import how_to_get

        raise Refused(f"a panel needs the package textual: {how_to_get('gui')}") from None
    from rtkit.panel.live import LiveService

    with LiveService(_address(at, app, target), app.timeout_s, components or "gui") as live:
        PanelApp(live, name or "").run()


def _address(at: str | None, app: App, target: str) -> str:
    """Return a target as clients take it: an address where it lies behind an endpoint."""
    if at is None:
        return target
    from rtkit.wires.table import endpoint_of

    try:
        side, place, service = endpoint_of(at)
    except Malformed as error:
        raise click.BadParameter(str(error), param_hint="--at") from None
    root = place if place.startswith(side.prefix) else side.prefix + place
    return "/".join(each for each in (root + side.folder, service, target) if each)
