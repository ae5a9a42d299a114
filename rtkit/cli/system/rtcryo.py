"""``rtcryo``: save the live system as a profile."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App
from rtkit.cli.shared.atomic import STDOUT, write_output
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, option
from rtkit.cli.system import shared
from rtkit.errors import NotFound
from rtkit.rtc.names import MANAGER_SUFFIX

if TYPE_CHECKING:
    from rtkit.deployment.facts import Snapshot


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
    a manager of this host, /localhost/m1.mgr: what several of them hold becomes one system. Servers
    of RTKIT_SERVERS that do not answer are told, and the status is 1 then.
    """
    from datetime import datetime

    from rtkit.deployment.capture import SystemHeading, capture
    from rtkit.profile.forms import XML, form_of_name
    from rtkit.profile.write import write_profile

    for text in (abstract, name, system_version, vendor):
        shared.check_text(text)
    if app.finds_managers and any(server.endswith(MANAGER_SUFFIX) for server in servers):
        from rtkit.cli.system.gathering import gather_named

        servers = gather_named(app, servers)
    snapshot = shared.snapshot(app)
    date = datetime.now().replace(microsecond=0).isoformat()
    heading = SystemHeading(date, name, system_version, vendor, abstract)
    hosts = [_host(server, snapshot) for server in servers]
    _report_gaps(app, snapshot)
    profile = capture(snapshot, heading, takes_all=takes_all, hosts=hosts)
    write_output(write_profile(profile, app.form or form_of_name(output) or XML), output)
    return 0 if servers else app.report_silent_servers("not saved")


def _host(server: str, snapshot: Snapshot) -> str:
    from rtkit.rtc.names import LOCAL, is_local_host

    host = server.strip("/")
    if is_local_host(host, snapshot.host):
        return LOCAL
    if not any(n.partition("/")[0] == host for c in snapshot.components for n in c.names):
        raise NotFound(f"No such object: {server}")
    return host


def _report_gaps(app: App, snapshot: Snapshot) -> None:
    """Report parts that could not be saved, or only as they were last reported."""
    for component in snapshot.components:
        if component.zombie:
            app.fail(f"not saved, zombie ({component.zombie}): {component.instance}")
        elif component.trouble:
            app.fail(f"saved as last reported ({component.trouble}): {component.instance}")
