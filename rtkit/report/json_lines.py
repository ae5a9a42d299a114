"""Writes findings as JSON: one object a line for each thing that was checked."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtkit.report.finding import Checked, Finding


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
