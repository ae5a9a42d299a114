"""Renders a page as reStructuredText."""

from __future__ import annotations

import re
from collections.abc import Iterator

from rtkit.profile_tools.page import Page, PageTable, Section, with_line_breaks
from rtkit.profile_tools.text_page import Width

_SPECIAL = re.compile(r"([\\*`|_])")


def rst_page(page: Page, width: Width = len, dot: str = "") -> str:
    """Return the page as reStructuredText; `dot` becomes a diagram by Graphviz, if it is given.

    Texts of sections are taken as they are: that they are reStructuredText is what the tools of
    old expect. All else is escaped.
    """
    return "\n\n".join(_blocks(page, width, dot)) + "\n"


def _blocks(page: Page, width: Width, dot: str) -> Iterator[str]:
    line = _line(page.title)
    rule = "=" * max(1, width(line))
    yield f"{rule}\n{line}\n{rule}"
    if page.lead:
        yield _line(page.lead)
    if page.facts:
        yield "\n".join(f":{name}: {_line(value)}" for name, value in page.facts)
    if dot:
        body = "\n".join(f"   {each}" for each in dot.splitlines())
        yield f".. graphviz::\n\n{body}"
    for each in page.sections:
        yield from _section(each, 0, width)


def _section(each: Section, level: int, width: Width) -> Iterator[str]:
    line = _line(each.title)
    yield f"{line}\n{'-~.'[min(level, 2)] * max(1, width(line))}"
    for text in each.texts:
        yield with_line_breaks(text).strip("\n")
    if each.table is not None:
        yield _table(each.table)
    for part in each.parts:
        yield from _section(part, level + 1, width)


def _table(table: PageTable) -> str:
    lines = [".. list-table::", "   :header-rows: 1", ""]
    for row in (table.heads, *table.rows):
        for index, cell in enumerate(row):
            mark = "*" if index == 0 else " "
            lines.append(f"   {mark} - {_line(cell)}".rstrip())
    return "\n".join(lines)


def _line(text: str) -> str:
    return _SPECIAL.sub(r"\\\1", " ".join(with_line_breaks(text).split()))
