"""``rtprofile graph``: draw a system or a component, without running it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, either, flag, option
from rtkit.cli.shared.system_values import PARAMETERS
from rtkit.errors import Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import RtsProfile


@command(
    "graph",
    examples=(
        ("rtprofile graph robot.xml -o robot.svg", "A picture of a system."),
        ("rtprofile graph --live --text", "What lives, in its processes, as text."),
        ("rtprofile graph robot.xml -o robot.mmd", "For a page that draws Mermaid itself."),
    ),
)
def main(
    app: App,
    form: str | None = either(
        option("--svg", "Write SVG (default).", flag_value="svg"),
        option("--dot", "Write the input of Graphviz.", flag_value="dot"),
        option("--mermaid", "Write a flowchart of Mermaid.", flag_value="mermaid"),
        option("--text", "Write text, at most 80 columns.", flag_value="text"),
    ),
    output: str = option("-o --output FILE", "Where to write it.", default="-"),
    title: str | None = option("--title TEXT", "What stands above it (default: the id)."),
    live: bool = flag("--live", "Draw what lives, with states, processes and rates."),
    without_rates: bool = flag("--no-rates", "Do not measure rates, which takes a second."),
    parameters: None = PARAMETERS,
    files: tuple[str, ...] = arguments("[FILE]"),
) -> int:
    """Draw a system, or a component type, without running it.

    Data flow from left to right as far as they can; service connectors are dashed, composites are
    frames around their members. With --live managers are asked: each component shows its state and
    the rate of its cycles, each wire the rate of its values; managers, where there are several, and
    processes are frames, too. The end of the output says which form is meant: .svg, .dot, .gv,
    .mmd or .txt.
    """
    from rtkit.drawing.export import exported, form_of
    from rtkit.link.atomic import write_output

    chosen = form or form_of(output)
    if live:
        from rtkit.api.live_scene import live_scene

        if files:
            raise UsageProblem("--live draws what lives: no file")
        heading = "what lives" if title is None else title
        scene = live_scene(app, has_rates=not without_rates)
        write_output(exported(scene, chosen, heading).encode(), output)
        return app.report_silent_servers("not drawn")
    from rtkit.cli.profiles.document import read_resolved_document

    check_at_most_one(files, "file")
    profile = read_resolved_document(app, *files).profile
    write_output(_drawn(profile, title, chosen).encode(), output)
    return 0


def _drawn(profile: RtcProfile | RtsProfile, title: str | None, form: str) -> str:
    from rtkit.profile.rts_model import RtsProfile

    if not isinstance(profile, RtsProfile):
        if form != "svg":
            raise Refused(f"{form} is for systems; a component type is drawn as SVG only")
        from rtkit.drawing.component import component_svg
        from rtkit.profile_tools.component_scene import component_name, component_pins

        return component_svg(component_name(profile), component_pins(profile))
    from rtkit.drawing.export import exported
    from rtkit.profile_tools.system_scene import system_scene

    return exported(system_scene(profile), form, profile.id if title is None else title)
