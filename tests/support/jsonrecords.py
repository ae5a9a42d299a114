"""Validates the JSON records that commands write against their schemas."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator

FOLDER = Path(__file__).parents[2] / "schemas" / "json"


@cache
def validator(kind: str) -> Draft202012Validator:
    text = (FOLDER / f"{kind}.1.schema.json").read_text(encoding="utf-8")
    return Draft202012Validator(json.loads(text))


def kind_of(record: Any) -> str:
    family, _, rest = record["schema"].partition(".")
    kind, _, version = rest.partition("/")
    assert (family, version) == ("rtkit", "1")
    return str(kind)


def checked(text: str) -> list[Any]:
    """Return the records of JSON Lines, each of which is as its schema says."""
    records = [json.loads(line, parse_constant=_refuse) for line in text.splitlines()]
    for record in records:
        found = [
            f"{e.json_path}: {e.message}" for e in validator(kind_of(record)).iter_errors(record)
        ]
        assert found == [], record
    return records


def _refuse(name: str) -> Any:
    raise AssertionError(f"{name} is no JSON")
