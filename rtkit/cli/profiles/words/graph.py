"""``rtprofile graph``: draw a system or a component, without running it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, either, flag, option
from rtkit.errors import Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.drawing.scene import Scene
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import RtsProfile

_DOT_ENDINGS = (".dot", ".gv")


@command(
    "graph",
    examples=(
        ("rtprofile graph robot.xml -o robot.svg", "A picture of a system."),
        ("rtprofile graph robot.xml", "The same as text."),
    ),
)
def main(
    app: App,
    form: str | None = either(
        option("--svg", "Write SVG (default).", flag_value="svg"),
        option("--dot", "Write the input of Graphviz.", flag_value="dot"),
    ),
    output: str = option("-o --output FILE", "Where to write it.", default="-"),
    title: str | None = option("--title TEXT", "What stands above it (default: the id)."),
    live: bool = flag("--live", "Draw what lives, with states and processes."),
    files: tuple[str, ...] = arguments("[FILE]"),
) -> int:
    """Draw a system, or a component type, without running it.

    Data flow from left to right as far as they can; service connectors are dashed, composites are
    frames around their members. With --live a manager is asked, and each component shows its
    state and process. Without Graphviz; for it there is --dot, or an output that ends in .dot or
    .gv.
    """
    from rtkit.link.atomic import write_output

    is_dot = form == "dot" or (form is None and output.lower().endswith(_DOT_ENDINGS))
    if live:
        write_output(_live(app, files, title, is_dot=is_dot).encode(), output)
        return app.report_silent_servers("not drawn")
    from rtkit.cli.profiles.document import read_document

    check_at_most_one(files, "file")
    profile = read_document(app, *files).profile
    write_output(_drawn(profile, title, is_dot=is_dot).encode(), output)
    return 0


def _live(app: App, files: tuple[str, ...], title: str | None, *, is_dot: bool) -> str:
    """Return the drawing of the live system.

    Raises:
        UsageProblem: A file is named, too.
        Unreachable: The manager does not answer.
    """
    from rtkit.cli.system.live_scene import live_scene

    if files:
        raise UsageProblem("--live draws what lives: no file")
    heading = "what lives" if title is None else title
    return _system(live_scene(app, heading), heading, is_dot=is_dot)


def _drawn(profile: RtcProfile | RtsProfile, title: str | None, *, is_dot: bool) -> str:
    from rtkit.profile.rts_model import RtsProfile

    heading = profile.id if title is None else title
    if not isinstance(profile, RtsProfile):
        if is_dot:
            raise Refused("dot is for systems; a component type is drawn as SVG only")
        from rtkit.drawing.component import component_svg
        from rtkit.profile_tools.component_scene import component_name, component_pins

        return component_svg(component_name(profile), component_pins(profile))
    from rtkit.profile_tools.system_scene import system_scene

    return _system(system_scene(profile), heading, is_dot=is_dot)


def _system(scene: Scene, title: str, *, is_dot: bool) -> str:
    if is_dot:
        from rtkit.drawing.dot import dot_lines

        return "\n".join(dot_lines(scene, title)) + "\n"
    from rtkit.drawing.svg import picture

    return picture(scene, title)
