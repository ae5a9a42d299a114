"""Shared parts of the system commands: options, the wanted system, messages on stderr."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from rtkit.cli.shared.app import App
from rtkit.cli.shared.options import (
    arguments,
    flag,
    json_flag,
    option,
    setting,
    several,
    strict_option,
    together,
)
from rtkit.cli.shared.system_values import PARAMETERS
from rtkit.errors import Refused

if TYPE_CHECKING:
    from rtkit.deployment.layered_plan import LayeredPlan
    from rtkit.deployment.start_schedule import StartPlan
    from rtkit.tree.plan_locks import PlanLocks

MOST_WAIT_S = 86_400.0


def form_options(verb: str, default: str, *forms: str) -> Any:
    """Return an option for each form that a profile may have; the last one sets `App.form`."""
    return together(
        None,
        {
            form: flag(
                "--json" if form == "json" else f"-{form[0]} --{form}",
                f"{verb} {form.upper()}{default if form == 'xml' else ''}.",
                **setting("form", form),
            )
            for form in forms
        },
    )


READ_FORMS = form_options("Read", "; without -x and -y, as name and content say", "xml", "yaml")
DRY_RUN = flag("--dry-run", "Print what would be done, and do nothing.")
PLAN_JSON = json_flag("The plan, then what becomes of each step, as JSON objects on stdout.")


def wait_option(default_s: float) -> Any:
    """Return the option how long to wait for the locks of plans [s]."""
    return option(
        "--wait SECONDS",
        f"Wait so long for another command that carries a plan out (default {default_s:g}).",
        click.FloatRange(min=0, max=MOST_WAIT_S),
        default=default_s,
    )


WAIT = wait_option(0.0)


class DocumentOptions(NamedTuple):
    """Options and argument that name a system profile.

    Attributes:
        forms: Nothing: the run knows the form that was asked for.
        strict: Nothing: the run knows.
        parameters: Nothing: the run knows the values and the prefix.
        mapped: ``HOST=HOST``: a host of the profile stands for another.
        placed: ``COMPONENT=PLACE``: where components are to be instead.
        left_out: Parts of the profile that are left out.
        files: The profile; none for stdin.
    """

    forms: None = READ_FORMS
    strict: None = strict_option("Refuse a profile that needs repair, or has warnings.")
    parameters: None = PARAMETERS
    mapped: tuple[str, ...] = several(
        "--map HOST=HOST",
        "A host of the profile stands for another, e.g. 10.0.0.7=localhost; repeatable.",
    )
    placed: tuple[str, ...] = several(
        "--place COMPONENT=PLACE",
        "A component is to be there instead: Motor0=/robot1/manager.mgr; repeatable.",
    )
    left_out: tuple[str, ...] = several(
        "--without PART",
        "Leave out a component, a connector (its id), or values: Motor0.default, 'Motor0.*';"
        " repeatable.",
    )
    files: tuple[str, ...] = arguments("[FILE]")


def locks(app: App, files: tuple[str, ...], wait_s: float) -> PlanLocks:
    """Return the locks that keep others off until the command ends."""
    from rtkit.tree.plan_locks import PlanLocks

    made = PlanLocks(" ".join([app.name, *files]), wait_s, app.report if wait_s else app.verbose)
    click.get_current_context().call_on_close(made.close)
    return made


def watch(app: App, *, is_json: bool) -> None:
    """Have plans and what becomes of their steps told as JSON, each record at once, if asked."""
    if is_json:
        from rtkit.deployment.plan_watch import PlanWatch

        app.watch = PlanWatch(_write_record)


def _write_record(kind: str, fields: Mapping[str, Any]) -> None:
    """Write a record; where nobody reads any more, the plan ends as after a failure."""
    from rtkit.cli.shared import console_process, json_records, terminal

    try:
        terminal.write_now([json_records.line(kind, fields)])
    except BrokenPipeError:
        console_process.leave_pipe()
        raise Refused("nobody reads what --json tells") from None


def show(plan: LayeredPlan | StartPlan) -> None:
    """Print a plan on stdout."""
    for line in plan.lines():
        click.echo(line)
