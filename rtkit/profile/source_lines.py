"""Locates findings at the lines that people see: the begin of a tag, or an attribute.

The parser only reports the line on which a start tag ends. For tags over several lines the text is
searched, where its encoding has ASCII in it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from rtkit.fast_dataclass import replace
from rtkit.profile.common import Note

_MOST_LINES = 200
_LONGEST_LINE = 5_000
"""A tag over more lines is not looked for, nor one among longer lines: there may be many notes."""

_LAST_NAME = re.compile(r"(?:[^/\[\]:'@]*:)?([^/\[\]:'@]+)(?:\[\d+\])?$")
_LOCAL_NAME = re.compile(
    r"local-name\(\)='([^']*)'(?: and namespace-uri\(\)='[^']*')?\](?:\[\d+\])?$"
)


def at_their_lines(notes: Iterable[Note], data: bytes) -> list[Note]:
    """Return the notes of an XML document with the lines at which a reader would look."""
    if b"\0" in data[:4]:
        return list(notes)
    # Any encoding that has ASCII in it will do: names of profiles are nothing else.
    lines = data.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return [replace(note, line=_line(note, lines)) for note in notes]


def _line(note: Note, lines: list[str]) -> int:
    element, _, attribute = note.path.partition("/@")
    name = _name(element)
    if not name or not 0 < note.line <= len(lines):
        return note.line
    start = re.compile(rf"<(?:[\w.-]+:)?{re.escape(name)}(?![\w.-])")
    nearest = range(note.line, max(0, note.line - _MOST_LINES), -1)
    if any(len(lines[n - 1]) > _LONGEST_LINE for n in nearest):
        return note.line
    begin = next((n for n in nearest if start.search(lines[n - 1])), None)
    if begin is None:
        return note.line
    named = _name(attribute)
    if begin == note.line or not named:
        return begin
    inside = re.compile(rf"(?<![\w.-]){re.escape(named)}\s*(?:=|$)")
    return next((n for n in range(begin, note.line + 1) if inside.search(lines[n - 1])), begin)


def _name(path: str) -> str:
    """Return the local name that the last step of a path tells."""
    found = _LOCAL_NAME.search(path) or _LAST_NAME.search(path)
    return found[1] if found else ""
