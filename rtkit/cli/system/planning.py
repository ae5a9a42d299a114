"""Options of the commands that plan: rtplan, rtapply, rtstate."""

from __future__ import annotations

import click

from rtkit.api.planning import MEASURED, STATES, TABLE, GoalOptions, WayOptions
from rtkit.cli.shared.options import flag, option, several, together

STAND_IN = flag("--stand-in", "Generate what is missing from the profile, without its modules.")
WAY = together(
    WayOptions,
    {
        "costs": several(
            "--cost NAME=NUMBER", "What a kind of step costs, or any interruption of a component."
        ),
        "basis": option(
            "--costs",
            "Cost of the other steps: as long as they took here (default, where known), or what the"
            " table says.",
            click.Choice((MEASURED, TABLE)),
            default=MEASURED,
        ),
        "stand_in": STAND_IN,
        "transmit": flag("--transmit", "Stand-ins write values while active, and answer calls."),
        "replaces": flag(
            "--replace",
            "End and replace what cannot be changed in place: another type, another create string,"
            " a stand-in with other ports.",
        ),
    },
)
AIM = together(
    GoalOptions,
    {
        "state": option(
            "-s --state",
            "State that every component is to be in (default Active).",
            click.Choice(STATES, case_sensitive=False),
            default=STATES[0],
        ),
        "way": WAY,
        "prunes": flag(
            "--prune",
            "End the other components of the managers of the profile, and remove the other"
            " connections of its components.",
        ),
    },
)
