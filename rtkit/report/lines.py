"""Writes findings as lines: text for people, annotations for GitHub, one JSON object a document."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator

from rtkit.report.finding import ERROR, NOTE, SEVERITIES, WARNING, Checked, Finding, counted

Style = Callable[[str, str], str]
"""Makes a text printable and gives it the look of a role: a severity, ``name`` or ``path``."""

_ROLES = (("valid", "valid"), ("invalid", "error"), ("not checked", "error"))
"""Verdicts and their styles."""


_LEVELS = {ERROR: "error", WARNING: "warning", NOTE: "notice"}
_MESSAGE = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A"})
_PROPERTY = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A", ":": "%3A", ",": "%2C"})


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
        verdicts = ", ".join(
            f"{files[word]} {style(word, role)}" for word, role in _ROLES if files[word]
        )
        counts = _counts(severities)
        yield f"{files.total()} checked: {verdicts}{f' ({counts})' if counts else ''}"


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
    text = ", ".join(filter(None, (each.what, _counts(Counter(f.severity for f in each.findings)))))
    text = f" ({text})" if text and each.is_read else ""
    return f"{style(each.name, 'name')}: {style(word, dict(_ROLES)[word])}{text}"


def _word(each: Checked) -> str:
    if not each.is_read:
        return "not checked"
    return "valid" if each.is_valid else "invalid"


def _counts(severities: Counter[str]) -> str:
    return ", ".join(counted(severities[each], each) for each in SEVERITIES if severities[each])


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
    fields = ",".join(f"{key}={value.translate(_PROPERTY)}" for key, value in properties.items())
    text = finding.full_text + (f" ({finding.path})" if finding.path else "")
    return f"::{_LEVELS[finding.severity]} {fields}::{text.translate(_MESSAGE)}"


def json_lines(checked: Iterable[Checked]) -> Iterator[str]:
    """Yield one JSON object for each thing checked; unknown facts are null."""
    import json

    for each in checked:
        made = {
            "schema": "rtkit.checked/1",
            "file": each.name,
            "what": each.what or None,
            "valid": each.is_valid,
            "findings": [_object(finding) for finding in each.findings],
        }
        yield json.dumps(made, ensure_ascii=False)


def _object(finding: Finding) -> dict[str, object]:
    return {
        "severity": finding.severity,
        "rule": finding.rule,
        "text": finding.text,
        "file": finding.file,
        "line": finding.line or None,
        "xpath": finding.path or None,
        "found": finding.found,
        "allowed": finding.allowed or None,
    }
