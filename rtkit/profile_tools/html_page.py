"""Renders a page as one HTML file: no scripts, no external resources, every text escaped."""

from __future__ import annotations

import re
from collections.abc import Iterator

from rtkit.drawing.svg import escaped
from rtkit.profile_tools.page import Page, PageTable, Section, with_line_breaks

_STYLE = """
body{font-family:'Noto Sans','Noto Sans JP','DejaVu Sans','Helvetica Neue',Arial,sans-serif;
color:#1a202c;background:#fff;max-width:70rem;margin:2rem auto;padding:0 1.5rem;line-height:1.5}
h1{margin-bottom:.2rem}h2{margin-top:2rem;border-bottom:1px solid #cbd5e0}
.lead{font-size:1.1rem;color:#4a5568;margin-top:0}
table{border-collapse:collapse;margin:.8rem 0}
th,td{border:1px solid #cbd5e0;padding:.25rem .6rem;text-align:left;vertical-align:top}
.wide{overflow-x:auto}
thead th{background:#e8eef6}.facts th{background:#f7fafc;font-weight:600}
figure{margin:1.5rem 0;overflow-x:auto}figure svg{max-width:100%;height:auto}
@media print{body{margin:0;max-width:none}.wide{overflow:visible}td{overflow-wrap:anywhere}}
"""
_POLICY = "default-src 'none'; style-src 'unsafe-inline'"


def html_page(page: Page) -> str:
    """Return the page as HTML, which is well-formed XML too."""
    return "\n".join(_lines(page)) + "\n"


def _lines(page: Page) -> Iterator[str]:
    yield "<!DOCTYPE html>"
    yield '<html xmlns="http://www.w3.org/1999/xhtml" lang="en">'
    yield "<head>"
    yield '<meta charset="utf-8"/>'
    yield f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}"/>'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1"/>'
    yield f"<title>{escaped(page.title)}</title>"
    yield f"<style>{_STYLE}</style>"
    yield "</head>"
    yield "<body>"
    yield f"<h1>{escaped(page.title)}</h1>"
    if page.lead:
        yield f'<p class="lead">{escaped(page.lead)}</p>'
    if page.picture:
        yield f'<figure aria-label="{escaped(page.picture_text)}">'
        yield page.picture.rstrip()
        yield "</figure>"
    if page.facts:
        yield '<table class="facts">'
        for name, value in page.facts:
            yield f"<tr><th>{escaped(name)}</th><td>{_broken(value)}</td></tr>"
        yield "</table>"
    for each in page.sections:
        yield from _section(each, 2)
    yield "</body>"
    yield "</html>"


def _section(each: Section, level: int) -> Iterator[str]:
    yield "<section>"
    yield f"<h{level}>{escaped(each.title)}</h{level}>"
    for text in each.texts:
        for paragraph in paragraphs(text):
            yield f"<p>{_broken(paragraph)}</p>"
    if each.table is not None:
        yield from _table(each.table)
    for part in each.parts:
        yield from _section(part, min(level + 1, 6))
    yield "</section>"


def _table(table: PageTable) -> Iterator[str]:
    yield '<div class="wide"><table>'
    if any(table.heads):
        cells = "".join(f"<th>{escaped(head)}</th>" for head in table.heads)
        yield f"<thead><tr>{cells}</tr></thead>"
    yield "<tbody>"
    for row in table.rows:
        yield "<tr>" + "".join(f"<td>{_broken(cell)}</td>" for cell in row) + "</tr>"
    yield "</tbody>"
    yield "</table></div>"


def paragraphs(text: str) -> list[str]:
    """Return the paragraphs of a text: what blank lines part."""
    found = re.split(r"\n[ \t]*\n", with_line_breaks(text))
    return [each.strip() for each in found if each.strip()]


def _broken(text: str) -> str:
    """Return a text with its line breaks."""
    return "<br/>".join(escaped(line) for line in with_line_breaks(text).strip().split("\n"))
