"""Values as JSON has them, there and back."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rtkit.property.codes import PropertyError
from rtkit.property.plain import from_plain, payload_to_plain
from rtkit.property.writing import write

TEXTS = [
    "1", "-2.5", "true", '"two words"', "(1 2 3)", '("a" (1 2) true)', "()", "<a/>",
    '<a b="1"><c>2</c><d>"x y"</d></a>', "<m><location>(1 2)</location></m>",
]  # fmt: skip


@pytest.mark.parametrize("text", TEXTS)
def test_what_was_told_can_be_said(text: str) -> None:
    plain = json.loads(json.dumps(payload_to_plain(text)))
    value = from_plain(plain)
    assert not isinstance(value, bytes)
    assert payload_to_plain(write(value)) == plain


def test_bytes_are_base64() -> None:
    assert from_plain(payload_to_plain(b"\xff\x00")) == b"\xff\x00"


def test_a_long_list_is_a_list() -> None:
    assert payload_to_plain(f"({'1.25 ' * 300_000})") == [1.25] * 300_000


def _deep() -> Any:
    value: Any = []
    for _ in range(100):
        value = [value]
    return value


@pytest.mark.parametrize(("plain", "code"), [
    ({}, "bad-value"), ({"element": 3}, "bad-value"), ({"element": "a", "x": 1}, "bad-value"),
    ({"element": "a", "attributes": {"b": 1}}, "bad-value"), ({"base64": "!"}, "bad-value"),
    ({"base64": 3}, "bad-value"), ([{"base64": ""}], "bad-value"),
    ({"element": "a", "children": [1]}, "bad-value"),
    ({"element": "a", "children": [{"element": "b"}], "value": 1}, "bad-value"),
    (_deep(), "too-large"),
])  # fmt: skip
def test_what_stands_for_nothing_is_refused(plain: Any, code: str) -> None:
    with pytest.raises(PropertyError) as refused:
        from_plain(plain)
    assert refused.value.code == code
