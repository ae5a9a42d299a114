"""The JSON Schemas are what the tables make, documented, and accept what is written."""

from __future__ import annotations

import json
import runpy
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from corpus import ROOT, corpus, needs_corpus
from jsonschema import Draft202012Validator

from rtkit.profile.forms import FORMS
from rtkit.profile.read import read_file, read_profile
from rtkit.profile.write import write_profile
from rtkit.resources import resource

SAMPLES = Path(__file__).parent / "samples"
NAMES = {"rtc": "RtcProfile.schema.json", "rts": "RtsProfile.schema.json"}


@cache
def schema(kind: str) -> Any:
    return json.loads(Path(resource("schemas", NAMES[kind])).read_text(encoding="utf-8"))


def errors(kind: str, data: Any) -> list[str]:
    found = Draft202012Validator(schema(kind)).iter_errors(data)
    return [f"{error.json_path}: {error.message[:200]}" for error in found]


def test_they_are_not_stale() -> None:
    made = runpy.run_path(str(ROOT / "tools" / "make_json_schemas.py"))["made"]()
    assert made == {
        name: Path(resource("schemas", name)).read_text(encoding="utf-8") for name in NAMES.values()
    }


@pytest.mark.parametrize("kind", NAMES)
def test_they_are_schemas(kind: str) -> None:
    Draft202012Validator.check_schema(schema(kind))


def properties(part: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(part, dict):
        yield from part.get("properties", {}).items()
        for below in part.values():
            yield from properties(below)
    elif isinstance(part, list):
        for below in part:
            yield from properties(below)


@pytest.mark.parametrize("kind", NAMES)
def test_everything_is_documented(kind: str) -> None:
    definitions = schema(kind)["$defs"]
    for name, part in definitions.items():
        assert part["description"], name
    for key, part in properties(schema(kind)):
        about = part.get("description") or definitions[part["$ref"].split("/")[-1]]["description"]
        assert about.endswith("."), key


@pytest.mark.parametrize("kind", NAMES)
@pytest.mark.parametrize("form", FORMS)
def test_the_samples_are_valid(kind: str, form: str) -> None:
    profile = read_file(str(SAMPLES / f"{kind}.{form}")).profile
    assert errors(kind, json.loads(write_profile(profile, "json"))) == []


@needs_corpus
@pytest.mark.parametrize("kind", NAMES)
def test_the_corpus_is_valid_once_written(kind: str) -> None:
    files = corpus(f"{kind}/*", f"yaml/*{kind.upper()}*.yaml")
    assert len(files) >= 22
    for file in files:
        written = write_profile(read_file(str(file)).profile, "json")
        assert errors(kind, json.loads(written)) == [], file


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('"isRequired": true', '"isRequired": "true"', "isRequired: 'true' is not of type"),
        ('"direction": "LEFT"', '"direction": "left"', "'left' is not one of"),
        ('"sequence": 1', '"sequence": 1.5', "1.5 is not of type 'integer'"),
        ('"year": 2024', '"year": "2024"', "is not valid under any of the given schemas"),
        ('"pathUri"', '"pathURI"', "'pathUri' is a required property"),
        ('"waitTime": 0', '"waitTime": 0}, "preceding": {', "is valid under each of"),
    ],
)
def test_what_is_not_valid(old: str, new: str, why: str) -> None:
    text = (SAMPLES / "rts.json").read_text(encoding="utf-8")
    assert old in text
    found = errors("rts", json.loads(text.replace(old, new, 1)))
    assert any(why in message for message in found), found


def test_a_document_may_name_its_schema() -> None:
    text = (SAMPLES / "rts.json").read_text(encoding="utf-8")
    named = text.replace("{", '{"$schema": "RtsProfile.schema.json",', 1)
    assert errors("rts", json.loads(named)) == []
    assert read_profile(named).profile == read_profile(text).profile
