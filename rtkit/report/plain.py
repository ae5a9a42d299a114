"""Writes findings as text: a line each, a verdict for each thing checked, last the total."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator

from rtkit.report.finding import SEVERITIES, Checked, Finding, counted

Style = Callable[[str, str], str]
"""Makes a text printable and gives it the look of a role: a severity, ``name`` or ``path``."""

_ROLES = (("valid", "valid"), ("invalid", "error"), ("not checked", "error"))
"""Verdicts and their styles."""


def as_is(text: str, _role: str) -> str:
    """Leave a text without any style."""
    return text


def plain_lines(
    checked: Iterable[Checked], style: Style = as_is, *, is_quiet: bool = False
) -> Iterator[str]:
    """Yield one line a finding, one line a verdict, and a total of several; if quiet, findings."""
    files: Counter[str] = Counter()
    severities: Counter[str] = Counter()
    for each in checked:
        files[_word(each)] += 1
        severities.update(finding.severity for finding in each.findings)
        for finding in each.findings:
            yield plain_line(finding, style)
        if not is_quiet:
            yield _verdict(each, style)
    if files.total() > 1 and not is_quiet:
        told = ", ".join(
            f"{files[word]} {style(word, role)}" for word, role in _ROLES if files[word]
        )
        counts = _counts(severities)
        yield f"{files.total()} checked: {told}{f' ({counts})' if counts else ''}"


def plain_line(finding: Finding, style: Style = as_is) -> str:
    """Return the line of a finding."""
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
    word = _word(each)
    told = ", ".join(filter(None, (each.what, _counts(Counter(f.severity for f in each.findings)))))
    told = f" ({told})" if told and each.is_read else ""
    return f"{style(each.name, 'name')}: {style(word, dict(_ROLES)[word])}{told}"


def _word(each: Checked) -> str:
    if not each.is_read:
        return "not checked"
    return "valid" if each.is_valid else "invalid"


def _counts(severities: Counter[str]) -> str:
    return ", ".join(counted(severities[each], each) for each in SEVERITIES if severities[each])
