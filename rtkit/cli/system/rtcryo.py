"""``rtcryo``: save the live system as a profile."""

from __future__ import annotations

from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, option
from rtkit.cli.system import shared
from rtkit.link.atomic import STDOUT, write_output


@command(
    "rtcryo",
    examples=(
        ("rtcryo -n Robot -o robot.xml", "Save what is running."),
        ("rtcryo --all", "Also components without connections, on stdout."),
    ),
    arguments=("host",),
)
def main(
    app: App,
    abstract: str = option(
        "-a --abstract",
        "What it is (default: RT System created by rtcryo.).",
        default="RT System created by rtcryo.",
    ),
    name: str = option(
        "-n --system-name", "Name of the system (default RTSystem).", default="RTSystem"
    ),
    system_version: str = option(
        "-v --system-version", "Version of the system (default 0).", default="0"
    ),
    vendor: str = option("-e --vendor", "Who made the system (default Me).", default="Me"),
    output: str = option(
        "-o --output FILE", "Where to write it (default -, stdout).", default=STDOUT
    ),
    forms: None = shared.form_options(
        "Write", "; without one of these, as the name of FILE ends, else XML", "xml", "yaml", "json"
    ),
    takes_all: bool = flag("--all", "Also components without connections."),
    servers: tuple[str, ...] = arguments("[SERVER]..."),
) -> int:
    """Save the live system as an RTS profile.

    It says all that rtresurrect needs to make the system again. Components of the manager that is
    asked are saved if they are connected, on the SERVERs named or everywhere. A SERVER may also be
    a manager of this host, /localhost/m1.mgr, or a linked host, /robot1: what several of them hold
    becomes one system. Servers
    of RTKIT_SERVERS that do not answer are told, and the status is 1 then.
    """
    from rtkit.api.capturing import capture
    from rtkit.profile.forms import XML, form_of_name
    from rtkit.profile.write import write_profile

    profile = capture(app, servers, (name, system_version, vendor, abstract), takes_all=takes_all)
    if not profile.components and not takes_all:
        app.fail("note: no component is connected, so none is saved (--all saves them, too)")
    write_output(write_profile(profile, app.form or form_of_name(output) or XML), output)
    return 0 if servers else app.report_silent_servers("not saved")
