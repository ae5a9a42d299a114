"""Writes ``docs/manager-properties.md`` from the table of properties.

Usage: ``python tools/make_property_table.py [FILE]``; a test checks that the file in ``docs/`` is
what this writes.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from rtkit.settings.properties import FIXED, LIVE, NONE, properties

FILE = Path(__file__).parents[1] / "docs" / "manager-properties.md"
_HEAD = """\
# Properties of a manager

Written by `python tools/make_property_table.py` from `rtkit/settings/properties.py`:
change that.

A manager takes them from `rtmgr start -f FILE`, else from the file that `RTC_MANAGER_CONFIG` names,
else from `./rtc.conf`, else from one in `/etc`; what `rtmgr start -o KEY:VALUE` says counts more.
The syntax is that of `rtc.conf`: `key: value`, `#` for comments, a backslash at the end of a line
that goes on, commas between the items of a list. `rtmgr -g MANAGER` lists them, and
`rtmgr -s KEY=VALUE MANAGER` changes one that takes effect at once. Keys that begin with `corba.`
are taken for those with `net.`.

Unknown keys are warned of, with the nearest that is known; a value of the wrong kind ends the
start, with file and line. Components inherit `exec_cxt.*`, `execution_contexts`, `ec.*`,
`logger.*`, `naming.*` and `port.*`; what a create string says counts more.

## With effect

| key | default | takes effect | meaning |
| --- | --- | --- | --- |
"""
_VAIN = """
## Accepted, without effect

Known from other managers, so that their files can be read; rtkit warns of one that is given another
value than this.

| key | default | why |
| --- | --- | --- |
"""
_WORDS = {LIVE: "at once", FIXED: "read-only"}


def table() -> str:
    """Return the text of the file."""
    known = list(properties())
    useful = (each for each in known if each.when != NONE)
    rows = (
        f"| `{each.key}` | {_code(each.default)} | {_WORDS.get(each.when, 'at the start')}"
        f" | {_escaped(each.meaning)} |"
        for each in useful
    )
    vain = (each for each in known if each.when == NONE)
    others = (
        f"| `{each.key}` | {_code(each.default)} | {_escaped(each.meaning)} |" for each in vain
    )
    return f"{_HEAD}{_lines(rows)}{_VAIN}{_lines(others)}"


def _lines(rows: Iterable[str]) -> str:
    return "".join(f"{row}\n" for row in rows)


def _code(text: str) -> str:
    return f"`{text}`" if text else ""


def _escaped(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


def write(file: Path) -> None:
    """Write the file."""
    file.write_text(table(), encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else FILE)
