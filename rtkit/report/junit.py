"""Writes findings as JUnit XML: a test case for each thing checked, failed on errors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtkit.report.finding import ERROR, Checked
from rtkit.report.lines import plain_line
from rtkit.xmltext import TEXT_ESCAPES, VALUE_ESCAPES, without_bad_characters

_NEW_LINE = "\n"


def junit(checked: Iterable[Checked], tool: str, timestamp: str) -> str:
    """Return one JUnit document; `timestamp` is ``2024-01-31T12:00:00``, without a zone."""
    return "\n".join(_lines(list(checked), tool, timestamp))


def _lines(checked: list[Checked], tool: str, timestamp: str) -> Iterator[str]:
    failures = sum(not each.is_valid for each in checked)
    counts = f'tests="{len(checked)}" failures="{failures}" errors="0"'
    yield '<?xml version="1.0" encoding="UTF-8"?>'
    # Ant's schema allows no attributes here, and no other one asks for any.
    yield "<testsuites>"
    yield (
        f'  <testsuite name="{_value(tool)}" package="rtkit" id="0" hostname="localhost"'
        f' timestamp="{_value(timestamp)}" {counts} skipped="0" time="0">'
    )
    yield "    <properties/>"
    for each in checked:
        yield from _case(each, tool)
    notes = [plain_line(f) for each in checked for f in each.findings if f.severity != ERROR]
    yield f"    <system-out>{_text(_NEW_LINE.join(notes))}</system-out>"
    yield "    <system-err/>"
    yield "  </testsuite>"
    yield "</testsuites>"


def _case(each: Checked, tool: str) -> Iterator[str]:
    head = f'    <testcase classname="{_value(tool)}" name="{_value(each.name)}" time="0"'
    errors = each.only_errors().findings
    if not errors:
        yield f"{head}/>"
        return
    first, more = errors[0], len(errors) - 1
    message = first.full_text + (f" (and {more} more)" if more else "")
    yield f"{head}>"
    details = _NEW_LINE.join(map(plain_line, errors))
    yield f'      <failure type="{_value(first.rule)}" message="{_value(message)}">'
    yield f"{_text(details)}</failure>"
    yield "    </testcase>"


def _text(text: str) -> str:
    return without_bad_characters(text).translate(TEXT_ESCAPES)


def _value(text: str) -> str:
    return without_bad_characters(text).translate(VALUE_ESCAPES)
