"""``rtresurrect``: bring up the system that a profile describes."""

from __future__ import annotations

from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import flag, together
from rtkit.cli.system import shared
from rtkit.cli.system.document import read_document
from rtkit.errors import UsageProblem


@command(
    "rtresurrect",
    examples=(
        ("rtresurrect robot.xml", "Make, configure and connect what a profile describes."),
        ("rtresurrect --dry-run robot.xml", "Tell what would be done."),
        ("rtresurrect --stand-in robot.xml", "Without the modules: stand-ins for components."),
    ),
    json=("plan", "step"),
)
def main(
    app: App,
    no_create: bool = flag("--no-create", "Components must be there; create none."),
    stand_in: bool = flag(
        "--stand-in", "Generate what is missing from the profile, without its modules."
    ),
    transmit: bool = flag(
        "--transmit", "Stand-ins write default values while active, and answer calls."
    ),
    strict_path: bool = flag(
        "--strict-path",
        "Ends of connectors must tell the path of their component, where they tell one.",
    ),
    wait_s: float = shared.WAIT,
    is_json: bool = shared.PLAN_JSON,
    dry_run: bool = shared.DRY_RUN,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> None:
    """Bring up the system of an RTS profile (FILE, or stdin).

    Components that are not there are created where the profile, its rtkit properties, or a known
    component profile says how; then connections are made and configuration sets written and
    activated. Components that are there already are left as they are. If something required fails,
    what was made is removed again.

    Managers that do not run are started first, as rtmgr start does, those of hosts that rthost
    knows as with --host; with --no-create they must run. Only one rtapply, rtresurrect,
    rtteardown or rtstate works at a manager at a time.
    """
    from rtkit.api.starting import bring_up

    if no_create and (stand_in or transmit):
        raise UsageProblem("--no-create makes no stand-ins")
    shared.watch(app, is_json=is_json)
    document = read_document(app, asked)
    if strict_path:
        from rtkit.deployment.place import check_paths

        with document.naming():
            check_paths(document.profile)
    plans = bring_up(
        app,
        document,
        may_create=not no_create,
        stand_in=stand_in,
        transmit=transmit,
        is_dry=dry_run,
        lock=None if dry_run else shared.locks(app, asked.files, wait_s),
    )
    for plan in () if is_json else plans:
        shared.show(plan)
