"""Findings as lines of text: one each, then the verdict on what was checked."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from rtkit.report.finding import SEVERITIES, Checked, Finding, counted

Style = Callable[[str, str], str]
"""Makes a text printable and gives it the look of a role: a severity, ``name`` or ``path``."""


def as_is(text: str, _role: str) -> str:
    """Leave a text without any style."""
    return text


def plain_lines(
    checked: Iterable[Checked], style: Style = as_is, *, is_quiet: bool = False
) -> Iterator[str]:
    """Yield one line a finding and one line a verdict; if quiet, no verdicts."""
    for each in checked:
        for finding in each.findings:
            yield plain_line(finding, style)
        if not is_quiet:
            yield _verdict(each, style)


def plain_line(finding: Finding, style: Style = as_is) -> str:
    """Return the line that tells of a finding."""
    place = f"{finding.file}:{finding.line}" if finding.line else finding.file
    parts = [
        f"{style(place, 'name')}:",
        f"{style(finding.severity, finding.severity)}:",
        f"{style(finding.full_text, 'text')}",
        style(f"[{finding.rule}]", "path"),
    ]
    if finding.path:
        parts.append(style(finding.path, "path"))
    return " ".join(parts)


def _verdict(each: Checked, style: Style) -> str:
    counts = [
        counted(number, severity) for severity in SEVERITIES if (number := each.count(severity))
    ]
    if not each.is_read:
        return f"{style(each.name, 'name')}: {style('not checked', 'error')}"
    word, role = ("valid", "valid") if each.is_valid else ("invalid", "error")
    told = ", ".join([each.what, *counts] if each.what else counts)
    return f"{style(each.name, 'name')}: {style(word, role)}{f' ({told})' if told else ''}"
