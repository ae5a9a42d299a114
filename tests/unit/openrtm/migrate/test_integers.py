"""Which expressions are whole numbers, and which divisions are of them."""

from __future__ import annotations

import ast

import pytest

from rtkit.openrtm.migrate.integers import divisions, is_integer, is_integer_needed, note_parents


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("4", True), ("-4", True), ("len(x) - 4", True), ("int(x) * 2", True), ("True", False),
        ("4.0", False), ("x", False), ("float(3)", False), ("len(x) / 2", True), ("2 ** -1", False),
        ("x.len()", False), ("ord('a') // 2", True), ("len(x) * y", False),
    ],
)  # fmt: skip
def test_only_what_is_certainly_whole_is(text: str, expected: bool) -> None:
    node = ast.parse(text, mode="eval").body
    assert is_integer(node) is expected


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("(len(x) - 4) / 2", "whole"),
        ("1 / 2", "whole"),
        ("a / 2", "open"),
        ("a / 2.0", "other"),
        ("float(a) / b", "other"),
        ("math.pi / 180", "other"),
        ("def f(n):\n    return n / 2", "open"),
        ("def f():\n    n = 3\n    n += 1\n    return n / 2", "whole"),
        ("def f():\n    n = 3\n    n = g()\n    return n / 2", "open"),
        ("def f(x):\n    for i in range(9):\n        y = i / 2", "whole"),
        ("def f(x):\n    for i in x:\n        y = i / 2", "open"),
        ("def f():\n    global n\n    n = 3\n    return n / 2", "open"),
        ("def f():\n    n = m = 3\n    return n / 2", "open"),
        ("def f():\n    a, n = 3, 4\n    return n / 2", "open"),
        ("def f():\n    with g() as n:\n        return n / 2", "open"),
        ("def f():\n    n = 1\n    def g():\n        nonlocal n\n        n = x\n    n / 2", "open"),
    ],
)  # fmt: skip
def test_divisions_are_told_apart(text: str, kind: str) -> None:
    (found,) = divisions(ast.parse(text))
    told = "whole" if found.is_of_integers else "open" if found.is_open else "other"
    assert told == kind


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[None] * ((len(x) - 4) / 2)", True), ("x[len(x) / 2]", True), ("x[: len(x) / 2]", True),
        ("range(len(x) / 2)", True), ("y = len(x) / 2", False), ("3 * (len(x) / 2)", False),
        ("[None] * (n / 2)", False),
    ],
)  # fmt: skip
def test_where_python_3_takes_whole_numbers_only_shows_python_2(text: str, expected: bool) -> None:
    tree = ast.parse(text)
    note_parents(tree)
    (found,) = divisions(tree)
    assert is_integer_needed(found.node) is expected
