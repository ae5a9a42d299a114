"""Shared parts of rtstart and rtstop: a plan shown or carried out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from rtkit.api import looking, starting
from rtkit.cli.shared.app import App
from rtkit.cli.shared.options import flag
from rtkit.cli.system import shared
from rtkit.errors import UsageProblem

if TYPE_CHECKING:
    from rtkit.api.system_profiles import SystemProfile


PLAN = flag("--plan", "Print the plan as a graph (dot), and do nothing.")


def no_wait_flag(state: str) -> Any:
    """Return the option not to wait until components are in the state that is the goal."""
    return flag(
        "--no-wait", f"Do not wait until each component is {state}; conditions are waited for."
    )


def run(
    app: App,
    document: SystemProfile,
    plan_for: starting.PlanFor,
    *,
    draws: bool,
    dry_run: bool,
    may_lack: bool = False,
) -> None:
    """Carry out a plan for the system of `document`, or only print it.

    With `may_lack` some of several managers may be missing.

    Raises:
        Refused: It was broken off; the message tells how far it went.
        KeyboardInterrupt: Interrupted; its text tells how far it went.
    """
    if draws and app.watch is not None:
        raise UsageProblem("--json and --plan exclude each other")
    nothing = looking.nothing(app.usual_manager) if draws else None
    inputs = starting.prepare(app, document, plan_for, nothing, is_dry=dry_run, may_lack=may_lack)
    if draws:
        from rtkit.deployment.plan_graph import to_dot

        click.echo("\n".join(to_dot(inputs.plan)))
    elif dry_run:
        if app.watch is None:
            shared.show(inputs.plan)
    else:
        source = click.get_current_context().get_parameter_source("timeout")
        is_bounded = source is ParameterSource.COMMANDLINE
        starting.carry_out(app, inputs, app.timeout_s if is_bounded else None)
