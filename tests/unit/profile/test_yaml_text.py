"""YAML: what is read, what is refused, what is written."""

from __future__ import annotations

import contextlib
from typing import Any

import pytest
import yaml

from rtkit.profile.findings import InvalidProfile
from rtkit.profile.tree_read import MAX_DEPTH, Node, ScalarNode, TableNode
from rtkit.profile.yaml_text import read_yaml, write_yaml


def plain(node: Node) -> Any:
    if isinstance(node, ScalarNode):
        return node.text
    if isinstance(node, TableNode):
        return {key.text: plain(value) for key, value in node.items}
    return [plain(item) for item in node.items]


def read(text: str) -> Any:
    return plain(read_yaml(text, "x"))


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("", ""),
        ("# nothing\n", ""),
        ("a: b # c", {"a": "b"}),
        ("---\na: b\n...\n", {"a": "b"}),
        ("%YAML 1.1\n---\na: b", {"a": "b"}),
        (
            "a: 0.2\nb: no\nc: 2020-01-01\nd: 0x10",
            {"a": "0.2", "b": "no", "c": "2020-01-01"} | {"d": "0x10"},
        ),
        ("a:\n  b: c\n  d:\n  - e\n  - f: g", {"a": {"b": "c", "d": ["e", {"f": "g"}]}}),
        ('"rtsExt::visible": true', {"rtsExt::visible": "true"}),
        ("rtsExt::visible: true", {"rtsExt::visible": "true"}),
        ("a: RTC::TimedLong", {"a": "RTC::TimedLong"}),
        (r'a: "\x41\u3042\U0001f600\n\t\"\\"', {"a": 'A\u3042\U0001f600\n\t"\\'}),
        ("a: |\n  x\n   y\nb: >-\n  x\n  y\n", {"a": "x\n y\n", "b": "x y"}),
        ('{"a": 1, "b": [true, null], "c": {}}', {"a": "1", "b": ["true", "null"], "c": {}}),
        ("a: &x LEFT\nb: *x", {"a": "LEFT", "b": "LEFT"}),
        (
            "a: !!str 1\nb: !!map {c: !!seq [!!int 2]}\nd: ! x",
            {"a": "1", "b": {"c": ["2"]}, "d": "x"},
        ),
    ],
)
def test_what_is_read(text: str, meaning: object) -> None:
    assert read(text) == meaning


def test_lines_and_nulls() -> None:
    node = read_yaml("a:\n  b: ~\n  c: ''\n  d:\n\n  e: &x null\n  f: *x\n  g: !!str ~\n", "x")
    assert isinstance(node, TableNode)
    ((_, body),) = node.items
    assert isinstance(body, TableNode)
    found = [
        (key.line, isinstance(value, ScalarNode) and value.is_null) for key, value in body.items
    ]
    assert found == [(2, True), (3, False), (4, True), (6, True), (7, True), (8, False)]
    assert [value.line for _, value in body.items if isinstance(value, ScalarNode)][4] == 7


LAUGHS = "\n".join(f"l{n}: &l{n} [{', '.join([f'*l{n - 1}'] * 9)}]" for n in range(1, 12))


@pytest.mark.parametrize(
    ("text", "line", "why"),
    [
        ("a: !!python/object:os.system x", 1, "tag 'tag:yaml.org,2002:python/object:os.system'"),
        ("a: b\nc: !x y", 2, "tag '!x' is not allowed"),
        ("a: !!binary aGk=", 1, "is not allowed"),
        ("a: !!set {b}", 1, "is not allowed"),
        ("a: !!seq {b: c}", 1, "is not allowed"),
        (f"l0: &l0 [ha]\n{LAUGHS}", 2, "alias *l0 stands for a table or list"),
        ("a: &a [*a]", 1, "alias *a stands for a table or list"),
        ("a: &x {b: c}\nd:\n  <<: *x", 3, "alias *x stands for a table or list"),
        ("a: b\nc: *x", 2, "alias *x has no anchor before it"),
        ("a: b\n---\nc: d", 2, "a second document"),
        ("? [a]\n: b", 1, "a key is a table or list"),
        ("a: b\n? {c: d}\n: e", 2, "a key is a table or list"),
        ("a: b\nc: d\na: e", 3, "key 'a' is there twice"),
        ("{a: b, 'a': c}", 1, "key 'a' is there twice"),
        ("a: &k b\n*k : c\n*k : d", 3, "key 'b' is there twice"),
        ("a: [b, c\n", 2, "not YAML: while parsing a flow sequence"),
        ("a:\n\t b: c", 2, "not YAML: while scanning for the next token"),
        ('a: "b', 1, "not YAML: while scanning a quoted scalar"),
        ("a: b\nc: d\x00e", 2, "not YAML"),
        ("a: b\x07", 1, "not YAML"),
        ('a: "\\ud800"', 1, "not YAML"),
        ("[" * 100_000, 1, f"nested deeper than {MAX_DEPTH}"),
        ("- " * 1000 + "a", 1, f"nested deeper than {MAX_DEPTH}"),
        ("\n".join(" " * n + "a:" for n in range(200)), MAX_DEPTH + 1, "nested deeper than"),
        ("[" + "a," * 500_000 + "]", 1, "entries; no profile has so many"),
        ("[" + "*a," * 500_000 + "]", 1, "alias *a has no anchor"),
        ("- &a " + "x" * 10**6 + "\n" + "- *a\n" * 100, 14, "aliases make the document larger"),
    ],
)
def test_what_is_refused(text: str, line: int, why: str) -> None:
    with pytest.raises(InvalidProfile) as caught:
        read_yaml(text, "x.yaml")
    (note,) = caught.value.problems
    assert why in note.text
    assert note.line == line
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    "text",
    [
        'a: "' + " " * 300_000 + '"',
        'a: "' + "x\n" * 100_000,
        "a: [" + "x,\n" * 100_000,
        "a: [" + "#x\n" * 100_000 + "]",
        "\n".join(f"k{number}: [a,\n b]" for number in range(30_000)),
        "\n".join(f"k{number}: |\n  b" for number in range(30_000)),
        "a: " + ":" * 300_000,
        "a: b\n" + " c\n" * 100_000,
        "a: >\n" + "\n" * 300_000 + " x",
    ],
)
def test_time_grows_with_the_length_only(text: str) -> None:
    """Were it to grow with the square, one of these would take hours: the time limit tells."""
    with contextlib.suppress(InvalidProfile):
        read_yaml(text, "x")


@pytest.mark.parametrize(
    ("data", "text"),
    [
        ({"a": "b", "c": {"d": 1.5, "e": True}}, "a: b\nc:\n  d: 1.5\n  e: true\n"),
        ({"a": [{"b": 1, "c": [2, "x"]}, []]}, "a:\n- b: 1\n  c:\n  - 2\n  - x\n- []\n"),
        ({"a": "0.2", "b": "true", "c": ""}, "a: '0.2'\nb: 'true'\nc: ''\n"),
        ({"rtsExt::x": "RTC:a:b:1"}, '"rtsExt::x": RTC:a:b:1\n'),
        ({"a": "日\x7f"}, 'a: "日\\x7F"\n'),
    ],
)
def test_what_is_written(data: Any, text: str) -> None:
    assert write_yaml(data) == text
    assert yaml.safe_load(text) == data


def test_nothing_that_is_there_twice_becomes_an_alias() -> None:
    one = {"a": ["b"]}
    assert "*" not in write_yaml({"x": one, "y": one})


def test_the_slow_parser_does_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    text = "a:\n  b: [c, 'd', &x e, *x]\n  \"f::g\": 1.5\n"
    fast, written = read_yaml(text, "x"), write_yaml({"a::b": ["c"]})
    monkeypatch.delattr(yaml, "CSafeLoader", raising=False)
    monkeypatch.delattr(yaml, "CSafeDumper", raising=False)
    assert read_yaml(text, "x") == fast
    assert write_yaml({"a::b": ["c"]}) == written
    with pytest.raises(InvalidProfile, match="nested deeper"):
        read_yaml("[" * 100_000, "x")
    with pytest.raises(InvalidProfile, match="x:2: not YAML"):
        read_yaml("a: b\nc: \x00", "x")
