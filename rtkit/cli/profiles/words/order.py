"""``rtprofile order``: in which order the components of a system start, stop and so on."""

from __future__ import annotations

import click

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import argument, arguments, flag, option, strict_option
from rtkit.errors import UsageProblem


@command(
    "order",
    is_local=True,
    examples=(
        ("rtprofile order robot.xml activation", "Show the order."),
        (
            "rtprofile order robot.xml activation Sensor0 Control0:wait=500",
            "Half a second later.",
        ),
        (
            "rtprofile order robot.xml activation Sensor0 Control0:after=Sensor0,timeout=1000",
            "Control0 once Sensor0 is active, within 1 s.",
        ),
    ),
)
def main(
    app: App,
    is_removed: bool = flag("--remove", "Remove the order."),
    output: str | None = option("-o --output OUTPUT", "Where to write it (default FILE itself)."),
    strict: None = strict_option(),
    file: str | None = argument("FILE", required=False),
    name: str | None = argument("ORDER", required=False),
    steps: tuple[str, ...] = arguments("[STEP]..."),
) -> None:
    """Show or write an order of a system profile: which component comes when.

    ORDER is activation, deactivation, start-up, shut-down, resetting, initializing or finalizing.
    A STEP is the instance name of a component, INSTANCE@CONTEXT for one of several execution
    contexts. Behind a colon, separated by commas: at=N, its place (default: that in the list);
    wait=MS, a time to wait; after=INSTANCE, what must be done first, with timeout=MS, how long to
    wait for that, and sent, if it need only have been told. Without steps the order is shown, a
    step a line. An order that makes no sense is refused, and nothing is written.
    """
    from rtkit.cli.profiles.document import read_document, report_findings
    from rtkit.deployment.conditions import start_orders, stop_orders
    from rtkit.link.atomic import write_output
    from rtkit.profile.forms import form_of
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.profile.write import write_profile
    from rtkit.profile_tools.ordering import NAMES, steps_in, with_steps
    from rtkit.profile_tools.rewriting import rewritten

    if file is None or name is None:
        raise WrongArguments("A file and an order are wanted.")
    if name not in NAMES:
        raise UsageProblem(f"no order: {name} (one of {', '.join(NAMES)})")
    if is_removed and steps:
        raise UsageProblem("--remove takes no steps")
    document = read_document(app, file, kind="rts")
    assert isinstance(document.profile, RtsProfile)
    if not steps and not is_removed:
        for each in steps_in(document.profile, name):
            click.echo(each)
        return
    profile = with_steps(document.profile, name, steps)
    start_orders(profile)
    stop_orders(profile)
    report_findings(app, rewritten(document.data, document.name).findings)
    write_output(write_profile(profile, form_of(document.data, document.name)), output or file)
