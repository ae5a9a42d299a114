"""Renders a page as plain text, for a terminal or a mail."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rtkit.profile_tools.html_page import paragraphs
from rtkit.profile_tools.page import Page, PageTable, Section, with_line_breaks

Width = Callable[[str], int]
"""Function that returns the number of columns a text takes."""


def text_page(page: Page, width: Width = len) -> str:
    """Return the page as lines of text; titles are underlined, tables stand in columns."""
    return "\n\n".join(_blocks(page, width)) + "\n"


def _blocks(page: Page, width: Width) -> Iterator[str]:
    yield _title(page.title, "=", width)
    if page.lead:
        yield page.lead
    if page.facts:
        yield _columns(page.facts, width)
    for each in page.sections:
        yield from _section(each, 0, width)


def _section(each: Section, level: int, width: Width) -> Iterator[str]:
    yield _title(each.title, "-~."[min(level, 2)], width)
    for text in each.texts:
        yield from paragraphs(text)
    if each.table is not None:
        yield _table(each.table, width)
    for part in each.parts:
        yield from _section(part, level + 1, width)


def _title(text: str, rule: str, width: Width) -> str:
    line = " ".join(text.split())
    return f"{line}\n{rule * max(1, width(line))}"


def _table(table: PageTable, width: Width) -> str:
    return _columns((table.heads, *table.rows), width)


def _columns(rows: tuple[tuple[str, ...], ...], width: Width) -> str:
    cells = [tuple(" ".join(with_line_breaks(text).split()) for text in row) for row in rows]
    widths = [max(map(width, column)) for column in zip(*cells, strict=True)]
    lines = (
        "  ".join(text + " " * (size - width(text)) for text, size in zip(row, widths, strict=True))
        for row in cells
    )
    return "\n".join(line.rstrip() for line in lines)
