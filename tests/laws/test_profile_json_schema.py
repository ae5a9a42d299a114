"""Law of the JSON Schemas: what they accept is read, but for names that lead nowhere."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from rtkit.profile.findings import InvalidProfile
from rtkit.profile.forms import FORMS
from rtkit.profile.read import read_profile
from rtkit.profile.write import write_profile
from rtkit.resources import resource

SAMPLES = Path(__file__).parents[1] / "unit" / "profile" / "samples"
BEYOND_SCHEMA = {"component-name", "repeated-component", "unknown-component", "bad-character"}
"""References, and the names of foreign content: the schemas leave those to the reader."""

NUMBER = st.integers(0, 10**6)
VALUES = st.sampled_from(
    [
        *(
            None,
            True,
            0,
            -1,
            1.5,
            1e300,
            10**18,
            "",
            "x",
            "true",
            "1",
            "LEFT",
            "\n",
            "\x01",
            [],
            {},
        ),
        *("2024-02-30T00:00:00", "2024-01-02T03:04:05Z", "Grouping", "Wheel0", "{urn:x}y"),
    ]
)
WAYS = ("drop", "set", "double", "rename", "borrow", "wrap")
CHANGES = st.lists(st.tuples(st.sampled_from(WAYS), NUMBER, NUMBER, VALUES), min_size=1, max_size=3)


@cache
def parts(kind: str) -> tuple[str, Draft202012Validator]:
    path = Path(resource("schemas", f"{kind.capitalize()}Profile.schema.json"))
    schema = json.loads(path.read_text(encoding="utf-8"))
    return (SAMPLES / f"{kind}.json").read_text(encoding="utf-8"), Draft202012Validator(schema)


def containers(value: Any) -> list[Any]:
    """Every table and list inside that is not empty."""
    found = [value] if isinstance(value, dict | list) and value else []
    below = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    for item in below:
        found += containers(item)
    return found


def change(data: Any, how: str, which: int, what: int, value: Any) -> None:
    """Do one thing to the tree; `which` picks a table or list, `what` a place in it."""
    every = containers(data)
    if not every:
        return
    holder = every[which % len(every)]
    keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
    key = keys[what % len(keys)]
    if how == "drop":
        del holder[key]
    elif how == "set":
        holder[key] = value
    elif how == "borrow":
        other = every[what % len(every)]
        holder[key] = json.loads(json.dumps(other))
    elif how == "wrap":
        holder[key] = [holder[key]]
    elif isinstance(holder, list):
        holder.append(json.loads(json.dumps(holder[key])))
    elif how == "rename":
        others = list(every[what % len(every)])
        holder[str(others[which % len(others)])] = holder.pop(key)


def attempt(text: str) -> tuple[Any, set[str]]:
    """Read; what was refused gives the rules that it broke."""
    try:
        return read_profile(text, form="json"), set()
    except InvalidProfile as refused:
        return None, {note.rule for note in refused.problems}


@given(st.sampled_from(("rtc", "rts")), CHANGES)
@settings(deadline=None, max_examples=150)
def test_what_the_schema_accepts_is_read(
    kind: str, changes: list[tuple[str, int, int, Any]]
) -> None:
    text, validator = parts(kind)
    data = json.loads(text)
    for one in changes:
        change(data, *one)
    reading, rules = attempt(json.dumps(data))
    if reading is None:
        assert not validator.is_valid(data) or rules & BEYOND_SCHEMA, rules
        return
    for form in FORMS:
        written = write_profile(reading.profile, form)
        assert read_profile(written, form=form).profile == reading.profile
        if form == "json":
            assert validator.is_valid(json.loads(written))
