"""Writes the pages of the site that come from other files: manual pages, the index of decisions.

`docs/conf.py` calls it before each build; nothing of what it writes is committed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path

from rtkit import component

_ROFF = re.compile(r"\\f[BR]|\\([-&e\\])")
_MARKDOWN = re.compile(r"([\\`*_{}\[\]<>#|~$])")
_HEAD = re.compile(r"# (\d+)\. ([^\n]*)\n\nDate: ([\d-]+)\. Status: (\w+)\. *([^\n]*)\n")


def write(root: Path, folder: Path) -> None:
    """Write all pages below `folder`, each only if it differs from what is there."""
    names = sorted(file.stem for file in (root / "man").glob("*.1"))
    pages = {f"man/{name}.md": _manual(root / "man" / f"{name}.1") for name in names}
    pages["man/index.md"] = _manual_index(root / "man", names)
    pages["data_types.md"] = data_types()
    pages["decisions.md"] = decisions(root / "docs" / "decisions")
    for name, text in pages.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


def decisions(folder: Path) -> str:
    """Return the index of decision records: number, title, date, status."""
    rows, names = [], []
    for file in sorted(folder.glob("[0-9]*.md")):
        found = _HEAD.match(file.read_text(encoding="utf-8"))
        assert found, f"{file}: no title, date and status"
        number, title, date, status, more = found.groups()
        told = f"{status}. {more}" if more else status
        rows.append(f"| {number} | [{title}](../decisions/{file.name}) | {date} | {told} |")
        names.append(f"../decisions/{file.stem}")
    table = ["| | decision | date | status |", "| ---: | --- | --- | --- |", *rows]
    return "\n".join(["# Decisions", "", *table, "", *_toctree(names, is_hidden=True)])


def data_types() -> str:
    """Return a table of the data types that component authors import: name and fields."""
    types = {name: getattr(component, name) for name in sorted(component.__all__)}
    rows = [
        f"| `{name}` | {', '.join(f'`{each.name}`' for each in fields(each_type))} |"
        for name, each_type in types.items()
        if is_dataclass(each_type)
    ]
    return "\n".join(["| type | fields |", "| --- | --- |", *rows, ""])


def _manual_index(folder: Path, names: list[str]) -> str:
    rows = []
    for name in names:
        summary = _plain((folder / f"{name}.1").read_text(encoding="utf-8"), "NAME")
        rows.append(f"| [{name}]({name}.md) | {summary.partition(' - ')[2]} |")
    lines = ["# Manual pages", "", "The same texts as `man rtls` and `rtls -h`.", ""]
    lines += ["| command | |", "| --- | --- |", *rows, ""]
    return "\n".join([*lines, *_toctree(names, is_hidden=True)])


def _toctree(names: list[str], *, is_hidden: bool) -> list[str]:
    hidden = [":hidden:"] if is_hidden else []
    return ["```{toctree}", *hidden, *names, "```", ""]


def _plain(text: str, section: str) -> str:
    body = text.partition(f".SH {section}\n")[2].partition("\n.SH ")[0]
    return _ROFF.sub(lambda m: m[1] if m[1] and m[1] != "&" else "", body).strip()


def _manual(file: Path) -> str:
    lines = file.read_text(encoding="utf-8").splitlines()
    return "\n".join([f"# {file.stem}", "", *_markdown(lines)])


def _markdown(lines: list[str]) -> Iterator[str]:
    """Yield Markdown for the few macros of roff that `make man` writes."""
    is_literal = is_term = is_item = False
    for line in lines:
        macro, _, rest = line.partition(" ")
        if macro == ".nf" or macro == ".fi":
            is_literal = macro == ".nf"
            yield from ["```none"] if is_literal else ["```", ""]
        elif is_literal:
            yield _unescaped(line)
        elif macro in (".SH", ".SS"):
            is_item = False
            title = _unescaped(rest).strip('"')
            yield from ["", f"{'##' if macro == '.SH' else '###'} {title}", ""]
        elif macro == ".PP":
            is_item = False
            yield ""
        elif macro == ".TP":
            is_term = True
        elif is_term:
            is_term, is_item = False, True
            yield from ["", f"`` {_unescaped(line)} ``"]
        elif macro == ".B":
            yield f"**{_escaped(rest)}**"
        elif not line.startswith(('.\\"', ".TH")):
            yield f": {_escaped(line)}" if is_item else _escaped(line)
            is_item = False


def _unescaped(text: str) -> str:
    return _ROFF.sub(lambda m: {"e": "\\", "&": "", None: ""}.get(m[1], m[1]), text)


def _escaped(text: str) -> str:
    return _MARKDOWN.sub(r"\\\1", _unescaped(text))
