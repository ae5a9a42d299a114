"""Writes a report in the form of a given name: text, JSON, SARIF, JUnit, GitHub."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtkit.report.finding import Checked, Rules
from rtkit.report.lines import Style, as_is, github_lines, json_lines, plain_lines

TEXT, JSON, SARIF, JUNIT, GITHUB = "text", "json", "sarif", "junit", "github"
FORMS = (TEXT, JSON, SARIF, JUNIT, GITHUB)


def report_lines(
    form: str,
    checked: Iterable[Checked],
    rules: Rules,
    tool: str,
    timestamp: str = "",
    *,
    style: Style = as_is,
    is_quiet: bool = False,
) -> Iterator[str]:
    """Yield the lines of a report in one of `FORMS`.

    Args:
        form: One of `FORMS`.
        checked: Checked things; text, JSON and annotations come one by one as these do.
        rules: Subject of each rule, for the forms that explain rules.
        tool: The name under which it was checked.
        timestamp: When, for JUnit: ``2024-01-31T12:00:00``; empty for now.
        style: Style of the parts of a line, for text.
        is_quiet: Report errors only, and no verdict in a text.
    """
    checked = map(Checked.only_errors, checked) if is_quiet else checked
    if form == TEXT:
        yield from plain_lines(checked, style, is_quiet=is_quiet)
    elif form == JSON:
        yield from json_lines(checked)
    elif form == SARIF:
        from rtkit.report.sarif import sarif

        yield sarif(checked, rules, tool)
    elif form == JUNIT:
        import time

        from rtkit.report.junit import junit

        now = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime())
        yield junit(checked, tool, timestamp or now)
    else:
        yield from github_lines(checked)
