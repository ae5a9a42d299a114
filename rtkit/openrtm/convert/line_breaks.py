"""Breaks long expressions into lines, as formatters do."""

from __future__ import annotations

import ast

from rtkit.openrtm.convert.edits import SourceEdits

MOST = 99
"""Columns of a line."""


def laid_out(text: str, indent: str) -> str:
    """Return a call that stands behind an indent, over several lines where one is too short."""
    if len(indent) + len(text) <= MOST or "\n" in text:
        return text
    source = SourceEdits(text)
    statement = source.tree.body[0]
    call = statement.value if isinstance(statement, ast.Expr) else None
    if not isinstance(call, ast.Call) or not (call.args or call.keywords):
        return text
    deeper = f"{indent}    "
    parts = [laid_out(source.text(each), deeper) for each in call.args]
    for each in call.keywords:
        parts.append(f"{each.arg}={laid_out(source.text(each.value), deeper)}")
    ending = "," if len(parts) > 1 else ""
    lines = "".join(f"\n{deeper}{each}{ending}" for each in parts)
    return f"{source.text(call.func)}({lines}\n{indent})"
