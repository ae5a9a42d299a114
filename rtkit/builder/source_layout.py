"""Expressions laid out in lines: on one where they fit, else an item a line.

The form is that of ``ruff format``: a split list ends in a comma, so that it stays split.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from rtkit.builder.source_text import INDENT, WIDTH, cut_text, literal, value, width


class PlainExpression(NamedTuple):
    """An expression that is never split."""

    code: str


class CallExpression(NamedTuple):
    """``head(…)``; an argument is its keyword, which may be empty, and its value."""

    head: str
    arguments: Sequence[tuple[str, Node]]


Node = str | tuple["Node", ...] | Mapping[str, "Node"] | PlainExpression | CallExpression
"""An expression: a text, tuple or mapping stands for its literal; a long text is cut."""


def constant(content: object) -> Node:
    """Return the literal of a number, a text, a truth value or a tuple of them."""
    if isinstance(content, str):
        return content
    if isinstance(content, tuple):
        return tuple(constant(item) for item in content)
    return PlainExpression(value(content))


def flat(node: Node) -> str:
    """Return an expression on one line."""
    opening, items, closing = _parts(node)
    inner = ", ".join(f"{prefix}{flat(item)}" for prefix, item in items)
    comma = "," if opening == "(" and len(items) == 1 else ""
    return f"{opening}{inner}{comma}{closing}"


def _parts(node: Node) -> tuple[str, list[tuple[str, Node]], str]:
    if isinstance(node, PlainExpression):
        return node.code, [], ""
    if isinstance(node, str):
        return literal(node), [], ""
    if isinstance(node, CallExpression):
        pairs = [(f"{keyword}=" if keyword else "", item) for keyword, item in node.arguments]
        return f"{node.head}(", pairs, ")"
    if isinstance(node, tuple):
        return "(", [("", item) for item in node], ")"
    return "{", [(f"{literal(key)}: ", item) for key, item in node.items()], "}"


def lines(head: str, node: Node, tail: str = "", indent: str = INDENT) -> list[str]:
    """Return the lines of ``head`` + expression + ``tail``."""
    line = f"{indent}{head}{flat(node)}{tail}"
    if width(line) <= WIDTH or isinstance(node, PlainExpression):
        return [line]
    if isinstance(node, str):
        return [f"{indent}{head}(", *cut_text(node, indent + INDENT), f"{indent}){tail}"]
    opening, items, closing = _parts(node)
    if not items:
        return [line]
    inner = (
        _pairs(node, indent + INDENT)
        if isinstance(node, Mapping)
        else _inner(items, indent + INDENT)
    )
    return [f"{indent}{head}{opening}", *inner, f"{indent}{closing}{tail}"]


def _inner(items: Iterable[tuple[str, Node]], indent: str) -> list[str]:
    return [line for prefix, item in items for line in lines(prefix, item, ",", indent)]


def _pairs(items: Mapping[str, Node], indent: str) -> list[str]:
    """Return the lines of keys and values; a key that is too long is cut, too."""
    found: list[str] = []
    for key, item in items.items():
        head = f"{literal(key)}: "
        rows = lines(head, item, ",", indent)
        if width(rows[0]) > WIDTH:
            rows = [f"{indent}(", *cut_text(key, indent + INDENT), *lines("): ", item, ",", indent)]
        found += rows
    return found


def assigned(name: str, node: Node, indent: str = INDENT) -> list[str]:
    """Return the lines of an assignment."""
    return lines(f"{name} = ", node, indent=indent)


def mapping(name: str, items: Mapping[str, Node], indent: str = INDENT) -> list[str]:
    """Return the lines of a mapping that is written an item a line."""
    return [f"{indent}{name} = {{", *_pairs(items, indent + INDENT), f"{indent}}}"]


def chained(name: str, calls: Sequence[CallExpression], indent: str = INDENT) -> list[str]:
    """Return the lines of ``name = a(…).b(…).c(…)``."""
    if len(calls) == 1:
        return assigned(name, calls[0], indent)
    if len(calls) > 2:
        inner = [row for each in calls for row in lines("", each, indent=indent + INDENT)]
        return [f"{indent}{name} = (", *inner, f"{indent})"]
    first, second = calls
    head = f"{name} = {flat(first)}"
    if width(f"{indent}{head}{second.head}(") <= WIDTH:
        return lines(head, second, indent=indent)
    opening, items, closing = _parts(first)
    split = [f"{indent}{name} = {opening}", *_inner(items, indent + INDENT)]
    return [*split, *lines(closing, second, indent=indent)]
