"""Renders a page as a LaTeX article; every installation has the packages that it needs."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.profile_tools.html_page import paragraphs
from rtkit.profile_tools.page import Page, PageTable, Section, with_line_breaks

_ESCAPES = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{c: f"\\{c}" for c in "&%$#_{}"},
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
}
_TABLE = str.maketrans(_ESCAPES)
_LEVELS = ("section", "subsection", "subsubsection", "paragraph")


def latex_page(page: Page) -> str:
    """Return the page as LaTeX; every text is escaped."""
    return "\n".join(_lines(page)) + "\n"


def _lines(page: Page) -> Iterator[str]:
    yield r"\documentclass{article}"
    yield r"\usepackage[T1]{fontenc}"
    yield r"\usepackage[utf8]{inputenc}"
    yield r"\begin{document}"
    yield rf"\section*{{{_line(page.title)}}}"
    if page.lead:
        yield f"{_line(page.lead)}\n"
    if page.facts:
        yield r"\begin{description}"
        yield from (rf"\item[{_line(name)}] {_line(value)}" for name, value in page.facts)
        yield r"\end{description}"
    for each in page.sections:
        yield from _section(each, 0)
    yield r"\end{document}"


def _section(each: Section, level: int) -> Iterator[str]:
    yield rf"\{_LEVELS[min(level, 3)]}{{{_line(each.title)}}}"
    for text in each.texts:
        yield from (f"{_broken(paragraph)}\n" for paragraph in paragraphs(text))
    if each.table is not None:
        yield from _table(each.table)
    for part in each.parts:
        yield from _section(part, level + 1)


def _table(table: PageTable) -> Iterator[str]:
    width = 0.95 / len(table.heads)
    yield r"\noindent\begin{tabular}{" + f"p{{{width:.2f}\\linewidth}}" * len(table.heads) + "}"
    heads = (rf"\textbf{{{_line(head)}}}" for head in table.heads)
    yield " & ".join(heads) + r" \\ \hline"
    for row in table.rows:
        yield " & ".join(map(_line, row)) + r" \\"
    yield "\\end{tabular}\n"


def _line(text: str) -> str:
    return " ".join(with_line_breaks(text).split()).translate(_TABLE)


def _broken(text: str) -> str:
    return "\\\\\n".join(_line(line) for line in text.split("\n"))
