"""Renders a page as Markdown, with tables as GitHub and most others read them."""

from __future__ import annotations

import re
from collections.abc import Iterator

from rtkit.profile_tools.html_page import paragraphs
from rtkit.profile_tools.page import Page, PageTable, Section, with_line_breaks

_SPECIAL = re.compile(r"([\\`*_{}\[\]<>|~#])")
_LINE_START = re.compile(r"^(\s*\d*)([-+=.)])")


def markdown_page(page: Page, picture_file: str = "") -> str:
    """Return the page as Markdown; the picture is shown if it is in a file of this name."""
    return "\n\n".join(_blocks(page, picture_file)) + "\n"


def _blocks(page: Page, picture_file: str) -> Iterator[str]:
    yield f"# {_line(page.title)}"
    if page.lead:
        yield _text(page.lead)
    if page.picture and picture_file:
        from urllib.parse import quote

        yield f"![{_line(page.picture_text)}]({quote(picture_file)})"
    if page.facts:
        yield _table(PageTable(("", ""), page.facts))
    for each in page.sections:
        yield from _section(each, 2)


def _section(each: Section, level: int) -> Iterator[str]:
    yield f"{'#' * min(level, 6)} {_line(each.title)}"
    for text in each.texts:
        yield from map(_text, paragraphs(text))
    if each.table is not None:
        yield _table(each.table)
    for part in each.parts:
        yield from _section(part, level + 1)


def _table(table: PageTable) -> str:
    rows = [table.heads, ("---",) * len(table.heads)]
    lines = [_row(tuple(map(_cell, rows[0]))), _row(rows[1])]
    lines += [_row(tuple(map(_cell, row))) for row in table.rows]
    return "\n".join(lines)


def _row(cells: tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |"


def _cell(text: str) -> str:
    lines = with_line_breaks(text).strip().split("\n")
    return "<br>".join(_escaped(line.strip()) for line in lines)


def _line(text: str) -> str:
    return _escaped(" ".join(text.split()))


def _text(text: str) -> str:
    """Return a paragraph: what would begin a list or a heading is escaped, line breaks stay."""
    lines = [_escaped(line.strip()) for line in text.split("\n")]
    return "\\\n".join(_LINE_START.sub(r"\1\\\2", line) for line in lines)


def _escaped(text: str) -> str:
    return _SPECIAL.sub(r"\\\1", text).replace("&", "&amp;")
