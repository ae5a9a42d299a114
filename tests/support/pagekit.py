"""Reads the examples of pages in Markdown, as the tests that run them need them.

A page is one session in one home: its blocks of `sh` and `python` are run from top to bottom, and
a block of `text` behind one is what that one prints. A comment before a block may say otherwise:
`<!-- file: NAME -->` has it written to a file, `<!-- not run by the tests: WHY -->` left out,
`<!-- shown -->` says that it is a form or an extract, to be read only. `<!-- run as root -->` and
`<!-- file as root: NAME -->` are for the test that has namespaces. `<!-- replay: WIRE -->` is
for a test that speaks that protocol. Of a table behind `<!-- rows are run -->` the code in the last
cell of each row is run.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
MARK = "-- end of block --"
_BLOCK = re.compile(
    r"^(?:<!-- (file: (?P<file>[^\n]+)|not run by the tests: [^\n]+|shown|replay: (?P<replay>\w+)"
    r"|file as root: (?P<far>[^\n]+)|(?P<root>run as root)) -->\n)?"
    r"```(?P<language>[^\s`]*)[^\n]*\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
_RUN = ("sh", "python")


class Block(NamedTuple):
    """One fenced block.

    Attributes:
        file: Where it is written, empty for nowhere.
        replay: The protocol whose messages it has, empty for none.
        is_marked: A comment says that it is not run, or not by all.
        is_roots: It is run by root, in namespaces.
    """

    language: str
    text: str
    file: str
    replay: str
    is_marked: bool
    is_roots: bool


class Script(NamedTuple):
    """The examples of a page as one script of bash, and what each of its blocks prints."""

    text: str
    expected: list[str]


_TABLE = re.compile(r"^<!-- rows are run -->\n((?:\|[^\n]*\n)+)", re.MULTILINE)
_LAST_CELL = re.compile(r"`([^`]+)` \|$", re.MULTILINE)


def pages() -> list[Path]:
    """Return README, CONTRIBUTING and all pages written by hand, without decision records."""
    docs = ROOT / "docs"
    below = (file.relative_to(docs) for file in sorted(docs.rglob("*.md")))
    written = [docs / file for file in below if file.parts[0] not in ("decisions", "generated")]
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *written]


def blocks(page: Path) -> list[Block]:
    """Return the fenced blocks of a page."""
    text = _TABLE.sub(_as_block, page.read_text(encoding="utf-8"))
    return [
        Block(
            found["language"],
            found["text"],
            (found["file"] or found["far"] or "").strip(),
            found["replay"] or "",
            bool(found[1]),
            bool(found["root"] or found["far"]),
        )
        for found in _BLOCK.finditer(text)
    ]


def _as_block(table: re.Match[str]) -> str:
    """Return the rows of a table as a block of commands whose output nobody compares."""
    commands = "".join(f"{found[1]}\n" for found in _LAST_CELL.finditer(table[1]))
    return f"```sh\n{{\n{commands}}} > rows.txt 2> told.txt\n```\n"


def script(page: Path, *, is_roots: bool = False) -> Script:
    """Return what is to be run of a page; with `is_roots` what root runs in namespaces."""
    parts: list[str] = []
    expected: list[str] = []
    for block in blocks(page):
        if block.is_roots != is_roots:
            continue
        if block.file:
            parts.append(f"cat > {block.file} <<'END OF FILE'\n{block.text}END OF FILE\n")
        elif block.is_marked and not is_roots:
            continue
        elif block.language in _RUN:
            is_shell = block.language == "sh"
            run = block.text if is_shell else f"python - <<'END OF CODE'\n{block.text}END OF CODE\n"
            parts.append(f"{run}echo '{MARK}'\n")
            expected.append("")
        elif block.language == "text":
            assert expected, f"{page}: a block of text that nothing prints"
            expected[-1] += block.text
    return Script("".join(parts), expected)
