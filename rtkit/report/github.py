"""Writes findings as workflow commands of GitHub Actions, which shows them at their lines."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtkit.report.finding import ERROR, NOTE, WARNING, Checked, Finding

_LEVELS = {ERROR: "error", WARNING: "warning", NOTE: "notice"}
_MESSAGE = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A"})
_PROPERTY = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A", ":": "%3A", ",": "%2C"})


def github_lines(checked: Iterable[Checked]) -> Iterator[str]:
    """Yield one workflow command for each finding."""
    for each in checked:
        for finding in each.findings:
            yield _command(finding)


def _command(finding: Finding) -> str:
    properties = {"file": finding.file.removeprefix("./")}
    if finding.line:
        properties["line"] = str(finding.line)
    properties["title"] = finding.rule
    told = ",".join(f"{key}={value.translate(_PROPERTY)}" for key, value in properties.items())
    text = finding.full_text + (f" ({finding.path})" if finding.path else "")
    return f"::{_LEVELS[finding.severity]} {told}::{text.translate(_MESSAGE)}"
