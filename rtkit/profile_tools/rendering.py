"""Renders a page as HTML, Markdown, reStructuredText, LaTeX or plain text, by one walk over it."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence

from rtkit.profile_tools.page import Page, PageTable, Section, with_line_breaks

Width = Callable[[str], int]
"""Function that returns the number of columns a text takes."""

_RULES = "-~."
_LATEX_LEVELS = ("section", "subsection", "subsubsection", "paragraph")
_MARKDOWN = re.compile(r"([\\`*_{}\[\]<>|~#])")
_LINE_START = re.compile(r"^(\s*\d*)([-+=.)])")
_RST = re.compile(r"([\\*`|_])")
_LATEX = str.maketrans(
    {
        "\\": r"\textbackslash{}",
        "~": r"\textasciitilde{}",
        "^": r"\textasciicircum{}",
        **{c: f"\\{c}" for c in "&%$#_{}"},
        "<": r"\textless{}",
        ">": r"\textgreater{}",
        "|": r"\textbar{}",
    }
)
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


def rendered(
    page: Page, form: str, *, width: Width = len, picture_file: str = "", dot: str = ""
) -> str:
    """Return a page in one of the `FORMS`.

    HTML is one file, well-formed XML too: no scripts, no external resources, every text escaped.
    Texts of sections are taken as they are in reStructuredText, which is what the tools of old
    expect; all else is escaped.

    Args:
        page: The page.
        form: ``html``, ``markdown``, ``rst``, ``latex`` or ``text``.
        width: Measures texts that stand in columns or are underlined.
        picture_file: Where the picture is, for Markdown; empty for nowhere.
        dot: Becomes a diagram by Graphviz in reStructuredText.
    """
    return FORMS[form](width, picture_file, dot).written(page)


class _PageForm(ABC):
    """The walk over a page; each form says how headings, paragraphs and tables look."""

    _between = "\n\n"

    def __init__(self, width: Width, picture_file: str, dot: str) -> None:
        self._width = width
        self._picture_file = picture_file
        self._dot = dot

    def written(self, page: Page) -> str:
        """Return the text of a page."""
        return (
            self._between.join([*self._head(page), *self._parts(page.sections), *self._foot()])
            + "\n"
        )

    def _parts(self, sections: Sequence[Section], level: int = 0) -> Iterator[str]:
        for each in sections:
            yield from self._heading(each.title, level)
            for text in each.texts:
                yield from map(self._paragraph, self._paragraphs(text))
            if each.table is not None:
                yield self._table(each.table)
            yield from self._parts(each.parts, level + 1)
            yield from self._end()

    @abstractmethod
    def _head(self, page: Page) -> Iterator[str]: ...

    @abstractmethod
    def _heading(self, title: str, level: int) -> Iterator[str]: ...

    def _paragraphs(self, text: str) -> list[str]:
        """Return the paragraphs of a text, which blank lines part."""
        found = re.split(r"\n[ \t]*\n", with_line_breaks(text))
        return [each.strip() for each in found if each.strip()]

    def _paragraph(self, text: str) -> str:
        return text

    @abstractmethod
    def _table(self, table: PageTable) -> str: ...

    def _end(self) -> Sequence[str]:
        return ()

    def _foot(self) -> Sequence[str]:
        return ()


def _one_line(text: str) -> str:
    return " ".join(with_line_breaks(text).split())


class _Html(_PageForm):
    _between = "\n"

    def _head(self, page: Page) -> Iterator[str]:
        title = self._escaped(page.title)
        yield "<!DOCTYPE html>"
        yield '<html xmlns="http://www.w3.org/1999/xhtml" lang="en">'
        yield "<head>"
        yield '<meta charset="utf-8"/>'
        yield f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}"/>'
        yield '<meta name="viewport" content="width=device-width, initial-scale=1"/>'
        yield f"<title>{title}</title>"
        yield f"<style>{_STYLE}</style>"
        yield "</head>"
        yield "<body>"
        yield f"<h1>{title}</h1>"
        if page.lead:
            yield f'<p class="lead">{self._escaped(page.lead)}</p>'
        if page.picture:
            yield f'<figure aria-label="{self._escaped(page.picture_text)}">'
            yield page.picture.rstrip()
            yield "</figure>"
        if page.facts:
            yield '<table class="facts">'
            for name, value in page.facts:
                yield f"<tr><th>{self._escaped(name)}</th><td>{self._broken(value)}</td></tr>"
            yield "</table>"

    def _heading(self, title: str, level: int) -> Iterator[str]:
        tag = f"h{min(level + 2, 6)}"
        yield "<section>"
        yield f"<{tag}>{self._escaped(title)}</{tag}>"

    def _paragraph(self, text: str) -> str:
        return f"<p>{self._broken(text)}</p>"

    def _table(self, table: PageTable) -> str:
        lines = ['<div class="wide"><table>']
        if any(table.heads):
            cells = "".join(f"<th>{self._escaped(head)}</th>" for head in table.heads)
            lines.append(f"<thead><tr>{cells}</tr></thead>")
        lines.append("<tbody>")
        for row in table.rows:
            lines.append(f"<tr>{''.join(f'<td>{self._broken(cell)}</td>' for cell in row)}</tr>")
        return "\n".join([*lines, "</tbody>", "</table></div>"])

    def _end(self) -> Sequence[str]:
        return ("</section>",)

    def _foot(self) -> Sequence[str]:
        return ("</body>", "</html>")

    def _escaped(self, text: str) -> str:
        from rtkit.drawing.svg import escaped

        return escaped(text)

    def _broken(self, text: str) -> str:
        """Return a text with its line breaks."""
        return "<br/>".join(map(self._escaped, with_line_breaks(text).strip().split("\n")))


class _Markdown(_PageForm):
    """Markdown, with tables as GitHub and most others read them."""

    def _head(self, page: Page) -> Iterator[str]:
        yield from self._heading(page.title, -1)
        if page.lead:
            yield self._paragraph(page.lead)
        if page.picture and self._picture_file:
            from urllib.parse import quote

            yield f"![{self._line(page.picture_text)}]({quote(self._picture_file)})"
        if page.facts:
            yield self._table(PageTable(("", ""), page.facts))

    def _heading(self, title: str, level: int) -> Iterator[str]:
        yield f"{'#' * min(level + 2, 6)} {self._line(title)}"

    def _paragraph(self, text: str) -> str:
        """Return a paragraph: marks of lists and headings are escaped, line breaks stay."""
        lines = [self._escaped(line.strip()) for line in text.split("\n")]
        return "\\\n".join(_LINE_START.sub(r"\1\\\2", line) for line in lines)

    def _table(self, table: PageTable) -> str:
        heads, *rows = [tuple(map(self._cell, row)) for row in (table.heads, *table.rows)]
        shown = (heads, ("---",) * len(heads), *rows)
        return "\n".join(f"| {' | '.join(cells)} |" for cells in shown)

    def _cell(self, text: str) -> str:
        lines = with_line_breaks(text).strip().split("\n")
        return "<br>".join(self._escaped(line.strip()) for line in lines)

    def _line(self, text: str) -> str:
        return self._escaped(" ".join(text.split()))

    def _escaped(self, text: str) -> str:
        return _MARKDOWN.sub(r"\\\1", text).replace("&", "&amp;")


class _Rst(_PageForm):
    def _head(self, page: Page) -> Iterator[str]:
        line = self._line(page.title)
        rule = "=" * max(1, self._width(line))
        yield f"{rule}\n{line}\n{rule}"
        if page.lead:
            yield self._line(page.lead)
        if page.facts:
            yield "\n".join(f":{name}: {self._line(value)}" for name, value in page.facts)
        if self._dot:
            body = "\n".join(f"   {each}" for each in self._dot.splitlines())
            yield f".. graphviz::\n\n{body}"

    def _heading(self, title: str, level: int) -> Iterator[str]:
        line = self._line(title)
        yield f"{line}\n{_RULES[min(level, 2)] * max(1, self._width(line))}"

    def _paragraphs(self, text: str) -> list[str]:
        return [with_line_breaks(text).strip("\n")]

    def _table(self, table: PageTable) -> str:
        lines = [".. list-table::", "   :header-rows: 1", ""]
        for row in (table.heads, *table.rows):
            marks = ("*", *(" " * (len(row) - 1)))
            cells = zip(marks, map(self._line, row), strict=True)
            lines += [f"   {mark} - {cell}".rstrip() for mark, cell in cells]
        return "\n".join(lines)

    def _line(self, text: str) -> str:
        return _RST.sub(r"\\\1", _one_line(text))


class _Latex(_PageForm):
    """A LaTeX article; every installation has the packages that it needs."""

    _between = "\n"

    def _head(self, page: Page) -> Iterator[str]:
        yield r"\documentclass{article}"
        yield r"\usepackage[T1]{fontenc}"
        yield r"\usepackage[utf8]{inputenc}"
        yield r"\begin{document}"
        yield rf"\section*{{{self._line(page.title)}}}"
        if page.lead:
            yield f"{self._line(page.lead)}\n"
        if page.facts:
            yield r"\begin{description}"
            yield from (rf"\item[{self._line(n)}] {self._line(value)}" for n, value in page.facts)
            yield r"\end{description}"

    def _heading(self, title: str, level: int) -> Iterator[str]:
        yield rf"\{_LATEX_LEVELS[min(level, 3)]}{{{self._line(title)}}}"

    def _paragraph(self, text: str) -> str:
        return "\\\\\n".join(map(self._line, text.split("\n"))) + "\n"

    def _table(self, table: PageTable) -> str:
        column = f"p{{{0.95 / len(table.heads):.2f}\\linewidth}}"
        heads = (rf"\textbf{{{self._line(head)}}}" for head in table.heads)
        lines = [rf"\noindent\begin{{tabular}}{{{column * len(table.heads)}}}"]
        lines.append(" & ".join(heads) + r" \\ \hline")
        lines += [" & ".join(map(self._line, row)) + r" \\" for row in table.rows]
        return "\n".join([*lines, "\\end{tabular}\n"])

    def _foot(self) -> Sequence[str]:
        return (r"\end{document}",)

    def _line(self, text: str) -> str:
        return _one_line(text).translate(_LATEX)


class _Text(_PageForm):
    """Lines for a terminal or a mail; titles are underlined, tables stand in columns."""

    def _head(self, page: Page) -> Iterator[str]:
        yield self._title(page.title, "=")
        if page.lead:
            yield page.lead
        if page.facts:
            yield self._columns(page.facts)

    def _heading(self, title: str, level: int) -> Iterator[str]:
        yield self._title(title, _RULES[min(level, 2)])

    def _title(self, text: str, rule: str) -> str:
        line = " ".join(text.split())
        return f"{line}\n{rule * max(1, self._width(line))}"

    def _table(self, table: PageTable) -> str:
        return self._columns((table.heads, *table.rows))

    def _columns(self, rows: Sequence[Sequence[str]]) -> str:
        cells = [tuple(map(_one_line, row)) for row in rows]
        widths = [max(map(self._width, column)) for column in zip(*cells, strict=True)]
        padded = (
            (
                text + " " * (size - self._width(text))
                for text, size in zip(row, widths, strict=True)
            )
            for row in cells
        )
        return "\n".join("  ".join(row).rstrip() for row in padded)


FORMS: dict[str, type[_PageForm]] = {
    "html": _Html,
    "rst": _Rst,
    "latex": _Latex,
    "markdown": _Markdown,
    "text": _Text,
}
