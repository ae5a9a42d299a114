"""Writes findings as SARIF 2.1.0, which code hosts and editors show at their lines."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rtkit.report.finding import Checked, Finding, Rules
from rtkit.version import __version__

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


def sarif(checked: Iterable[Checked], rules: Rules, tool: str) -> str:
    """Return one SARIF document with one run of `tool`; rules are those that were met."""
    import json

    findings = [finding for each in checked for finding in each.findings]
    met = sorted({finding.rule for finding in findings})
    index = {rule: number for number, rule in enumerate(met)}
    driver = {
        "name": tool,
        "version": __version__,
        "rules": [_rule(rule, rules.get(rule, rule)) for rule in met],
    }
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [_result(finding, index[finding.rule]) for finding in findings],
    }
    document = {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}
    return json.dumps(document, ensure_ascii=False, indent=2)


def _rule(rule: str, summary: str) -> dict[str, Any]:
    return {"id": rule, "shortDescription": {"text": summary}}


def _result(finding: Finding, rule_index: int) -> dict[str, Any]:
    physical: dict[str, Any] = {"artifactLocation": {"uri": uri(finding.file)}}
    if finding.line:
        physical["region"] = {"startLine": finding.line}
    location: dict[str, Any] = {"physicalLocation": physical}
    if finding.path:
        kind = "attribute" if "/@" in finding.path else "element"
        location["logicalLocations"] = [{"fullyQualifiedName": finding.path, "kind": kind}]
    result: dict[str, Any] = {
        "ruleId": finding.rule,
        "ruleIndex": rule_index,
        "level": finding.severity,
        "message": {"text": finding.full_text},
        "locations": [location],
    }
    details = {"found": finding.found, "allowed": finding.allowed or None}
    known = {name: value for name, value in details.items() if value is not None}
    if known:
        result["properties"] = known
    return result


def uri(file: str) -> str:
    """Return a file name as a URI reference: relative stays relative."""
    from urllib.parse import quote

    quoted = quote(file.removeprefix("./"), safe="/", errors="surrogateescape")
    return f"file://{quoted}" if file.startswith("/") else quoted
