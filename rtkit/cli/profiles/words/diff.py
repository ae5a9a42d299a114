"""``rtprofile diff``: compare two profiles by meaning."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag
from rtkit.errors import Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.profile_tools.difference import Difference

_STYLES = {"added": "green", "removed": "red", "changed": "yellow"}


@command(
    "diff",
    is_local=True,
    examples=(
        ("rtprofile diff robot.xml robot.new.xml", "What changed, but for ids, dates, positions."),
        ("rtprofile diff --json robot.xml robot.new.xml", "Each difference as JSON."),
    ),
    json=("profile-difference",),
    statuses={"1": "The profiles differ, or cannot be read."},
)
def main(
    app: App,
    takes_all: bool = flag("--all", "Also ids, dates, positions, remarks."),
    is_json: bool = json_flag("One object a line for each difference."),
    files: tuple[str, ...] = arguments("BEFORE AFTER"),
) -> int:
    """Compare two profiles by what they mean.

    That is components, ports, connectors, parameters and orders. Components are the same
    where their instance names are, connectors where their ends are; the order of elements, ids of
    connectors, dates, positions and remarks make no difference. One of the two may be - for stdin.
    Exit status 0: the same, 1: different.
    """
    from rtkit.cli.profiles.document import read_document
    from rtkit.profile_tools.difference import differences

    if len(files) != 2:
        raise WrongArguments(f"takes two files, not {len(files)}")
    if files == ("-", "-"):
        raise UsageProblem("only one of the two can come from stdin")
    before, after = (read_document(app, file).profile for file in files)
    found = differences(before, after, takes_all=takes_all)
    for each in found:
        click.echo(_object(each) if is_json else terminal.styled(each.text, _STYLES[each.change]))
    return app.status(Refused()) if found else 0


def _object(each: Difference) -> str:
    return json_records.line("profile-difference", each._asdict())
