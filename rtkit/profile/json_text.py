"""Reads and writes JSON: text to nodes with the lines of their objects, plain data to text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from rtkit.profile.findings import refused
from rtkit.profile.tree_read import MAX_DEPTH, MAX_NODES, ListNode, Node, ScalarNode, TableNode

# Possessive, and content with the end of the text for the end of a string: time grows with length.
_MARKS = re.compile(r'"[^"\\]*+(?:\\.[^"\\]*+)*+(?:"|\\?\Z)|[{}\[\],\n]', re.DOTALL)


def read_json(text: str, source: str) -> Node:
    """Return the root of a document.

    Raises:
        InvalidProfile: It is no JSON, has a key twice, or is beyond bounds.
    """
    import json

    lines = _lines_of_objects(text, source)

    def table(pairs: list[tuple[str, Any]]) -> TableNode:
        line = next(lines)
        keys: set[str] = set()
        for key, _ in pairs:
            if key in keys:
                raise refused(
                    source, line, "repeated-key", f"key {key[:80]!r} is there twice in one object"
                )
            keys.add(key)
        items = ((ScalarNode(line, key, True), _node(value, line)) for key, value in pairs)
        return TableNode(line, tuple(items))

    def constant(name: str) -> None:
        raise refused(source, 1, "not-well-formed", f"{name} is no number of JSON")

    try:
        data = json.loads(
            text,
            object_pairs_hook=table,
            parse_int=_Number,
            parse_float=_Number,
            parse_constant=constant,
        )
    except json.JSONDecodeError as error:
        raise refused(source, error.lineno, "not-well-formed", f"not JSON: {error.msg}") from error
    return _node(data, 1)


def write_json(data: dict[str, Any]) -> str:
    """Return plain data as JSON, indented, keys in the order of `data`."""
    import json

    return json.dumps(data, ensure_ascii=False, indent=2, allow_nan=False) + "\n"


class _Number(str):
    """The digits of a number as they were written."""

    __slots__ = ()


def _node(value: Any, line: int) -> Node:
    """Wrap the result of the library; members of an object have the line of that object."""
    if isinstance(value, TableNode):
        return value
    if isinstance(value, list):
        return ListNode(line, tuple(_node(item, line) for item in value))
    if isinstance(value, bool):
        return ScalarNode(line, "true" if value else "false")
    if value is None:
        return ScalarNode(line, "null")
    return ScalarNode(line, str(value), not isinstance(value, _Number))


def _lines_of_objects(text: str, source: str) -> Iterator[int]:
    """Return the lines on which objects begin, in the order in which they end.

    Raises:
        InvalidProfile: It is nested too deeply, or has too many parts.
    """
    line, parts = 1, 0
    begun: list[int] = []
    ended: list[int] = []
    for found in _MARKS.finditer(text):
        mark = found[0]
        if mark == "\n":
            line += 1
            continue
        if mark[0] == '"':
            line += mark.count("\n")
            continue
        parts += 1
        if mark in "{[":
            begun.append(line)
        elif mark in "}]" and begun:
            start = begun.pop()
            if mark == "}":
                ended.append(start)
        if len(begun) > MAX_DEPTH:
            raise refused(source, line, "too-deep", f"nested deeper than {MAX_DEPTH}")
        if parts > MAX_NODES:
            why = f"more than {MAX_NODES} entries; no profile has so many"
            raise refused(source, line, "too-large", why)
    return iter(ended)
