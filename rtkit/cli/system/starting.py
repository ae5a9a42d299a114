"""Shared parts of rtstart, rtstop, rtteardown: plans shown or carried out, never undone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from rtkit.cli.shared.app import App
from rtkit.cli.shared.options import flag
from rtkit.cli.system import shared
from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.cli.system.document import SystemDocument
    from rtkit.deployment.actions import Action
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.start_schedule import StartPlan
    from rtkit.deployment.system import WantedSystem


PLAN = flag("--plan", "Print the plan as a graph (dot), and do nothing.")


def no_wait_flag(state: str) -> Any:
    """Return the option not to wait until components are in the state that is the goal."""
    return flag(
        "--no-wait", f"Do not wait until each component is {state}; conditions are waited for."
    )


def run(
    app: App,
    document: SystemDocument,
    plan_for: Callable[[WantedSystem, LiveIndex], StartPlan],
    *,
    draws: bool,
    dry_run: bool,
    mapped: tuple[str, ...],
    may_lack: bool = False,
) -> None:
    """Carry out a plan for the system of `document`, or only print it.

    With `may_lack` some of several managers may be missing.

    Raises:
        Refused: It was broken off; the message tells how far it went.
        KeyboardInterrupt: Interrupted; its text tells how far it went.
    """
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.running import active_now

    snapshot = (
        shared.nothing()
        if draws
        else shared.look(app, document.profile, dry_run=dry_run, may_lack=may_lack)
    )
    system = shared.wanted_system(app, document, snapshot, mapped=mapped)
    plan = plan_for(system, LiveIndex(snapshot, system))
    for text in plan.warnings():
        app.fail(f"warning: {text}")
    if draws:
        from rtkit.deployment.plan_graph import to_dot

        click.echo("\n".join(to_dot(plan)))
        return
    if dry_run:
        shared.show(plan)
        return
    from rtkit.cli.system import step_times

    shared.runner(app).check(plan.checks)
    with (
        reporting_progress(app, system, active_now),
        step_times.noting(app, system, snapshot) as taken,
    ):
        _carry_out(app, plan, taken)


def _carry_out(app: App, plan: StartPlan, taken: list[tuple[Action, float]]) -> None:
    from rtkit.cli.shared.progress import counted, metered
    from rtkit.tree.start import Starter

    source = click.get_current_context().get_parameter_source("timeout")
    is_bounded = plan.has_conditions and source is ParameterSource.COMMANDLINE
    timeout_s = app.timeout_s if is_bounded else None
    with metered(app, app.name.split()[-1]) as show:
        Starter(app.tree, plan, app.report, app.fail, timeout_s, counted(show), taken).run()


@contextmanager
def reporting_progress(
    app: App, system: WantedSystem, describe: Callable[[WantedSystem, LiveIndex], str]
) -> Iterator[None]:
    """Add the progress to an error that ends the command; `describe` reads it off the live system.

    Raises:
        RtkitError: What was raised inside.
        KeyboardInterrupt: Likewise.
    """
    try:
        yield
    except RtkitError as error:
        raise type(error)(f"{error}; {_progress(app, system, describe)}") from error
    except KeyboardInterrupt as error:
        more = _progress(app, system, describe)
        raise KeyboardInterrupt("; ".join(filter(None, (str(error), more)))) from error


def _progress(
    app: App, system: WantedSystem, describe: Callable[[WantedSystem, LiveIndex], str]
) -> str:
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.tree.grace import uninterrupted

    try:
        return describe(system, LiveIndex(uninterrupted(lambda: app.tree.remains()), system))
    except (RtkitError, KeyboardInterrupt) as trouble:
        return f"how far it got is not known ({str(trouble) or 'interrupted again'})"
