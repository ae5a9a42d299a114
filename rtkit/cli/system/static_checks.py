"""Checks systems before anything runs: ``rtprofile check`` and ``rtcheck --static``."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import click

from rtkit.cli.shared.app import App
from rtkit.cli.shared.options import option, several
from rtkit.cli.shared.system_values import parameters
from rtkit.cli.shared.terminal import finding_style
from rtkit.errors import InvalidDocument, NotFound, Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.deployment.limits import Capacity
    from rtkit.report.finding import Checked
    from rtkit.static_check.verdict import Opened, Options

TEXT = "text"
_FORMS = (TEXT, "json", "sarif", "junit", "github")


COMPONENTS = several(
    "--components FOLDER",
    "Look for RTC profiles in this folder and below, or in this file; repeatable.",
)
REPORT = option("--format", "How to tell (default text).", click.Choice(_FORMS))
IGNORED = several("--ignore RULE", "Say nothing that is about this rule; repeatable.")


def this_host() -> Capacity:
    """Return the resources of the host on which a system is to run."""
    from rtkit.manager.limits.control_groups import capacity

    return capacity()


def check(
    app: App,
    paths: Sequence[str],
    components: Sequence[str],
    *,
    report: str,
    tool: str,
    options: Options,
    is_quiet: bool = False,
) -> int:
    """Check systems, report the findings, and return the exit status.

    Folders among the paths, and RTC profiles beside systems, are where components are looked for.

    Raises:
        UsageProblem: There is no such rule.
        NotFound: A file or folder of components cannot be read.
    """
    from rtkit.profile.rules import RULES as RULES_OF_PROFILES
    from rtkit.report.forms import report_lines
    from rtkit.static_check.finding import RULES

    unknown = sorted(set(options.ignored) - RULES.keys())
    if unknown:
        raise UsageProblem(f"no such rule: {unknown[0]}; there are {', '.join(sorted(RULES))}")
    folders = [path for path in paths if os.path.isdir(path)]
    systems = [path for path in paths if path not in folders]
    components = [*components, *folders]
    checked = list(_checked(app, systems, components, options))
    rules = {**RULES_OF_PROFILES, **RULES, "unreadable": "A file or folder cannot be read"}
    for line in report_lines(report, checked, rules, tool, style=finding_style, is_quiet=is_quiet):
        click.echo(line)
    if report == TEXT and not components and not is_quiet and _lacks_profiles(checked):
        app.report("hint: --components FOLDER tells where RTC profiles are")
    return _status(app, checked)


def _checked(
    app: App, paths: Sequence[str], components: Sequence[str], options: Options
) -> Iterator[Checked]:
    from rtkit.api.component_profiles import profiles
    from rtkit.cli.shared.profile_files import sources
    from rtkit.profile.forms import may_be_component
    from rtkit.profile_tools.validation import unreadable
    from rtkit.static_check.stock import CandidateDocument, stocked
    from rtkit.static_check.verdict import Opened, verdict

    named = list(sources(paths))
    others = [each for each in named if each.data and may_be_component(each.data[:8192])]
    others = others if len(others) < len(named) else []
    systems: list[Opened | Checked] = []
    for source in named:
        if source in others:
            continue
        if source.data is None:
            systems.append(unreadable(source.name, source.problem))
        else:
            systems.append(_opened(app, source.data, source.name, options))
    types = {name for each in systems if isinstance(each, Opened) for name in each.types}
    components = [*components, *(each.name for each in others)]
    files = [source.name for source in named if source.data is not None and source.name in paths]
    documents = (
        CandidateDocument(*each) for each in profiles(components, app.verbose, systems=files)
    )
    catalogue, troubles = stocked(documents, types, options)
    for each in systems:
        yield verdict(each, catalogue, options) if isinstance(each, Opened) else each
    yield from troubles


def _opened(app: App, data: bytes, name: str, options: Options) -> Opened:
    """Look into a system, with the values that the command line gives."""
    from rtkit.api.system_profiles import read_parametrised
    from rtkit.profile.findings import InvalidProfile
    from rtkit.profile.forms import has_parameters
    from rtkit.static_check.verdict import Opened, opened

    given = parameters(app)
    if given is None and not has_parameters(data):
        return opened(data, name, form=app.form, strict=options.strict)
    try:
        found = read_parametrised(app, name, data, app.form, given)
    except InvalidProfile as error:
        return Opened(error.source, None, None, error.problems)  # perhaps of an included file
    return Opened(name, found.profile, found)


def _lacks_profiles(checked: Sequence[Checked]) -> bool:
    return any(finding.rule == "no-profile" for each in checked for finding in each.findings)


def _status(app: App, checked: Sequence[Checked]) -> int:
    bad = [each for each in checked if not each.is_valid]
    if not bad:
        return 0
    if all(not each.is_read for each in bad):
        return app.status(NotFound())
    return app.status(Refused() if any(each.what for each in bad) else InvalidDocument())
