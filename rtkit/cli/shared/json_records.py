"""Formats records for other programs: JSON Lines, each object with the name of its schema.

The schemas are ``schemas/json/NAME.1.schema.json``; docs/json.md explains all of them.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

_NS = 1_000_000_000


def line(kind: str, fields: Mapping[str, Any], indent: int | None = None) -> str:
    """Return a record of this kind as JSON, on one line unless it is to be indented.

    Numbers that JSON does not know are texts: ``"NaN"``, ``"Infinity"``, ``"-Infinity"``.
    """
    from json import dumps

    record = {"schema": f"rtkit.{kind}/1", **fields}
    try:
        text = dumps(record, ensure_ascii=False, allow_nan=False, indent=indent)
    except ValueError:
        record = _named(record)
        text = dumps(record, ensure_ascii=False, allow_nan=False, indent=indent)
    if text.isprintable():
        return text
    # A control character in the text could steer a terminal: JSON escapes hide it.
    return dumps(record, indent=indent)


def lines(kind: str, records: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return several records of one kind."""
    return [line(kind, each) for each in records]


def written_file(path: str) -> dict[str, str | None]:
    """Return the fields of ``built-file`` for a file that was written."""
    return {"path": path, "fate": "written", "why": None}


def picked(model: object, fields: str) -> dict[str, Any]:
    """Return the fields of a record that are attributes: ``"kind required=is_required"``."""
    named = (each.partition("=") for each in fields.split())
    return {name: getattr(model, attribute or name) for name, _, attribute in named}


def time_text(time_ns: int) -> str:
    """Return a Unix time [ns] as ISO 8601 in UTC: ``2024-01-31T12:00:00.000000000Z``."""
    seconds, nanoseconds = divmod(time_ns, _NS)
    return f"{time.strftime('%Y-%m-%dT%H:%M:%S', time.gmtime(seconds))}.{nanoseconds:09}Z"


def _named(value: Any) -> Any:
    """Return a value with texts in place of numbers that JSON does not know."""
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    if isinstance(value, Mapping):
        return {key: _named(item) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return [_named(item) for item in value]
    return value
