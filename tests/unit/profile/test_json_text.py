"""JSON: what is read with which line, what is refused, what is written."""

from __future__ import annotations

from typing import Any

import pytest

from rtkit.profile.findings import InvalidProfile
from rtkit.profile.json_text import read_json, write_json
from rtkit.profile.tree_read import MAX_DEPTH, ListNode, Node, ScalarNode, TableNode


def lines(node: Node) -> Any:
    """The tree with the line of each object in place of it."""
    if isinstance(node, TableNode):
        return node.line, {key.text: lines(value) for key, value in node.items}
    if isinstance(node, ListNode):
        return [lines(item) for item in node.items]
    return node.text


def test_every_object_has_its_line() -> None:
    text = '\n{"a": {\n"b": [{"c": "}{\\"["},\n{"d": 1}], "e": {}},\n"f": 2.50}'
    assert lines(read_json(text, "x")) == (
        2,
        {"a": (2, {"b": [(3, {"c": '}{"['}), (4, {"d": "1"})], "e": (4, {})}), "f": "2.50"},
    )


def test_scalars() -> None:
    node = read_json('["1", 1, true, false, null, "null", "", 1e5, "日\\ud83d\\ude00"]', "x")
    assert isinstance(node, ListNode)
    found = [(item.text, item.is_null) for item in node.items if isinstance(item, ScalarNode)]
    assert found == [
        ("1", False),
        ("1", False),
        ("true", False),
        ("false", False),
        ("null", True),
        ("null", False),
        ("", False),
        ("1e5", False),
        ("日\U0001f600", False),
    ]


@pytest.mark.parametrize(
    ("text", "line", "why"),
    [
        ("", 1, "not JSON: Expecting value"),
        ("{\n'a': 1}", 2, "not JSON: Expecting property name"),
        ('{"a": 1,\n"b": 2,}', 2, "not JSON"),
        ('{"a": 1} x', 1, "not JSON: Extra data"),
        ('{"a": "\x00"}', 1, "not JSON: Invalid control character"),
        ('{"a": "b\n"}', 1, "not JSON: Invalid control character"),
        ('{"a": {\n"b": 1,\n"b": 2}}', 1, "key 'b' is there twice in one object"),
        ('{"a": NaN}', 1, "NaN is no number of JSON"),
        ('{"a": -Infinity}', 1, "-Infinity is no number of JSON"),
        ("[" * 1_000_000, 1, f"nested deeper than {MAX_DEPTH}"),
        ("\n" + '{"a":' * 100_000, 2, f"nested deeper than {MAX_DEPTH}"),
        ("[" + "1," * 500_000 + "1]", 1, "entries; no profile has so many"),
        ('"' + '\\"' * 1_000_000, 1, "not JSON: Unterminated string"),
        ('"\\', 1, "not JSON"),
        ("}" * 1000, 1, "not JSON"),
        ('{"a": ' + "9" * 100_000 + "x}", 1, "not JSON"),
    ],
)
def test_what_is_refused(text: str, line: int, why: str) -> None:
    with pytest.raises(InvalidProfile) as caught:
        read_json(text, "x.json")
    (note,) = caught.value.problems
    assert why in note.text
    assert note.line == line


def test_what_is_written() -> None:
    data = {"a": "日\n", "b": [1, 1.5, True], "c": {}}
    text = '{\n  "a": "日\\n",\n  "b": [\n    1,\n    1.5,\n    true\n  ],\n  "c": {}\n}\n'
    assert write_json(data) == text
    with pytest.raises(ValueError, match="Out of range"):
        write_json({"a": float("nan")})
