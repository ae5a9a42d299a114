"""Assigns comments to declarations as their documentation."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

_MARKS = re.compile(r"^\s*(?:/\*[*!]*<?|//[/!]*<?|\*+(?!/))?\s?|\s*\*+/\s*$")
_DECORATION = re.compile(r"[\W_]*")
_BRIEF = re.compile(r"[@\\]brief\s+")
_COMMAND = re.compile(
    r"\s*[@\\](?:param|return|returns|retval|exception|throw|throws|if|else|endif)"
)
_WORD = re.compile(r"[@\\](?:a|c|b|e|p|li)\s+")


class Comment(NamedTuple):
    """A comment as it stands in the text; lines count from 1."""

    text: str
    line: int
    end_line: int


class Comments:
    """The comments of a text.

    A comment that begins its line belongs to the declaration that begins on the next line; any
    other to the declaration that ends on its own line.
    """

    def __init__(self, lines: Sequence[str], comments: Iterable[Comment]) -> None:
        self._before: dict[int, list[Comment]] = {}
        self._behind: dict[int, Comment] = {}
        for comment in sorted(comments, key=lambda each: each.line):
            if lines[comment.line - 1].lstrip().startswith(("//", "/*")):
                earlier = self._before.pop(comment.line - 1, [])
                both = [*earlier, comment] if _is_line(comment, earlier) else [comment]
                self._before[comment.end_line] = both
            else:
                self._behind[comment.line] = comment

    def of(self, line: int, end_line: int) -> str:
        """Return the comment of a declaration that stands on these lines; may be empty."""
        before = _text_of(self._before.get(line - 1, []))
        behind = self._behind.get(end_line)
        return before or (_text_of([behind]) if behind else "")


def _is_line(comment: Comment, earlier: list[Comment]) -> bool:
    return comment.text.startswith("//") and all(e.text.startswith("//") for e in earlier)


def _text_of(comments: Iterable[Comment]) -> str:
    lines: list[str] = []
    for comment in comments:
        for raw in comment.text.split("\n"):
            line = _MARKS.sub("", raw).rstrip()
            if _COMMAND.match(line):
                return "\n".join(lines).strip()
            if not _DECORATION.fullmatch(line) or not line:
                lines.append(_WORD.sub("", _BRIEF.sub("", line)))
    text = "\n".join(lines).strip()
    return "" if "\ufffd" in text else text
