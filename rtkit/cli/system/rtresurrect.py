"""``rtresurrect``: bring up the system that a profile describes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import flag, together
from rtkit.cli.system import following, shared
from rtkit.cli.system.document import read_document
from rtkit.cli.system.preflight import missing
from rtkit.errors import UsageProblem

if TYPE_CHECKING:
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.system import WantedSystem


@command(
    "rtresurrect",
    examples=(
        ("rtresurrect robot.xml", "Make, configure and connect what a profile describes."),
        ("rtresurrect --dry-run robot.xml", "Tell what would be done."),
        ("rtresurrect --stand-in robot.xml", "Without the modules: stand-ins for components."),
    ),
)
def main(
    app: App,
    no_create: bool = flag("--no-create", "Components must be there; create none."),
    stand_in: bool = flag(
        "--stand-in", "Generate what is missing from the profile, without its modules."
    ),
    transmit: bool = flag("--transmit", "Stand-ins write default values while active."),
    strict_path: bool = flag(
        "--strict-path",
        "Ends of connectors must tell the path of their component, where they tell one.",
    ),
    wait_s: float = shared.WAIT,
    dry_run: bool = shared.DRY_RUN,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> None:
    """Bring up the system of an RTS profile (FILE, or stdin).

    Components that are not there are created where the profile, its rtkit properties, or a known
    component profile says how; then connections are made and configuration sets written and
    activated. What is there already is left as it is. If something required fails, what was made
    is removed again.

    Managers of this host that do not run are started first, as rtmgr start does; with --no-create
    they must run. Only one rtapply, rtresurrect or rtstate works at a manager at a time.
    """
    from rtkit.cli.system.known_types import known_types
    from rtkit.cli.system.preflight import check_reserved
    from rtkit.deployment.creation import bring_up_plans

    if no_create and (stand_in or transmit):
        raise UsageProblem("--no-create makes no stand-ins")
    document = read_document(app, asked.files)
    if strict_path:
        from rtkit.deployment.place import check_paths

        with document.naming():
            check_paths(document.profile)
    is_followed = not dry_run and following.is_wanted(document)
    lock = None if dry_run else shared.locks(app, asked.files, wait_s)
    found = shared.look(app, document.profile, dry_run=dry_run, starts=not no_create, lock=lock)
    with shared.managers_started(app, found, dry_run=dry_run) as before:
        system = shared.wanted_system(
            app,
            document,
            before,
            stand_in=stand_in,
            transmit=transmit,
            mapped=asked.mapped,
            known_types=None if no_create or stand_in else known_types(document.profile, before),
        )
        check_reserved(app, system, before)
        lacks = {} if no_create else missing(app, system, before)
        with document.naming():
            if dry_run:
                plans = bring_up_plans(system, before, may_create=not no_create, lacks=lacks)
                for plan in plans:
                    shared.show(plan)
            else:
                _bring_up(app, system, before, lacks, may_create=not no_create)
    if is_followed:
        following.begin_as_stated(app, document, asked.mapped, stand_in=stand_in, transmit=transmit)


def _bring_up(
    app: App, system: WantedSystem, before: Snapshot, lacks: dict[str, str], *, may_create: bool
) -> None:
    from rtkit.cli.shared.progress import counted, metered
    from rtkit.cli.system import step_times
    from rtkit.tree.resurrect import resurrect

    with step_times.noting(app, system, before) as taken, metered(app, "resurrect") as show:
        runner = shared.runner(app, counted(show), taken)
        resurrect(app.tree, system, before, runner, may_create=may_create, lacks=lacks)
