"""Page about a profile: its content, apart from its rendering as HTML or Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

_LINE_BREAK = re.compile(r"<br[ \t]*/?>|\r\n|\r", re.IGNORECASE)


def with_line_breaks(text: str) -> str:
    """Return a text of a profile with its line breaks: builders of components write ``<br/>``."""
    return _LINE_BREAK.sub("\n", text)


class PageTable(NamedTuple):
    """Rows under heads; columns in which nothing stands are left out."""

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


class Section(NamedTuple):
    """A part of a page: texts, then a table, then parts of its own.

    Attributes:
        texts: Paragraphs, as the profile has them: blank lines part them, line breaks stay.
    """

    title: str
    texts: tuple[str, ...] = ()
    table: PageTable | None = None
    parts: tuple[Section, ...] = ()


class Page(NamedTuple):
    """A page.

    Attributes:
        lead: Description of the subject in a few words.
        facts: Names and values that stand at the top.
        picture: SVG; empty for none.
    """

    title: str
    lead: str
    facts: tuple[tuple[str, str], ...]
    picture: str
    picture_text: str
    sections: tuple[Section, ...]


def section(
    title: str,
    texts: Iterable[str | None] = (),
    table: PageTable | None = None,
    parts: Iterable[Section | None] = (),
) -> Section | None:
    """Return a section without what is empty in it; None where nothing is left."""
    kept = tuple(text for text in texts if text and text.strip())
    inner = tuple(part for part in parts if part is not None)
    shown = None if table is None else without_empty_columns(table)
    if not (kept or inner or shown):
        return None
    return Section(title, kept, shown, inner)


def without_empty_columns(table: PageTable) -> PageTable | None:
    """Return a table without its empty columns; None where it has no rows."""
    if not table.rows:
        return None
    columns = [i for i in range(len(table.heads)) if any(row[i].strip() for row in table.rows)]
    return PageTable(
        tuple(table.heads[i] for i in columns),
        tuple(tuple(row[i] for i in columns) for row in table.rows),
    )


def present(facts: Sequence[tuple[str, str | None]]) -> tuple[tuple[str, str], ...]:
    """Return the facts that have a value."""
    return tuple((name, value) for name, value in facts if value and value.strip())
