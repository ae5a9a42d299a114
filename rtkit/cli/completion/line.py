"""Parses a partly typed command line of bash, and quotes the replacement of its last word."""

from __future__ import annotations

import re
from typing import NamedTuple

_ASSIGNMENT = re.compile(r"[A-Za-z_]\w*=")
_PLAIN = re.compile(r"[\w@%+=:,./~^-]", re.ASCII)
_IN_DOUBLE = re.compile(r'([\\"$`])')


class TypedLine(NamedTuple):
    """The command line before the cursor.

    Attributes:
        words: The words before the last one, without quotes, assignments in front left out.
        typed: The last word, which may be empty, without quotes.
        kept: The part of `typed` that the shell leaves as it is: what it replaces begins behind.
        quote: The quote that is open at the cursor, or empty.
    """

    words: tuple[str, ...]
    typed: str
    kept: str
    quote: str

    def replacement(self, text: str) -> str:
        """Return the replacement for the word `text`, quoted as the line needs it."""
        return quoted(text.removeprefix(self.kept), self.quote)


def read(text: str, breaks: str) -> TypedLine:
    """Read a line; `breaks` are the characters at which the shell begins to replace.

    An open quote and a backslash at the end are no errors: somebody is still typing.
    """
    words: list[str] = []
    word: str | None = None
    kept = quote = ""
    escaped = False
    for c in text:
        if escaped:
            # Within double quotes bash keeps a backslash that escapes nothing.
            word = f"{word or ''}{'' if quote != chr(34) or c in _ESCAPABLE else chr(92)}{c}"
            escaped = False
        elif c == "\\" and quote != "'":
            escaped = True
        elif quote:
            if c == quote:
                quote = ""
            else:
                word = f"{word or ''}{c}"
        elif c in "'\"":
            quote = c
            word = kept = word or ""
        elif c in " \t\n":
            if word is not None:
                words.append(word)
            word, kept = None, ""
        else:
            word = f"{word or ''}{c}"
            kept = word if c in breaks else kept
    while words and _ASSIGNMENT.match(words[0]):
        del words[0]
    return TypedLine(tuple(words), word or "", kept, quote)


_ESCAPABLE = '\\"$`'


def quoted(text: str, quote: str) -> str:
    """Return text so that bash takes it as it is, within an open quote or without any."""
    if quote == "'":
        return text.replace("'", "'\\''")
    if quote == '"':
        return _IN_DOUBLE.sub(r"\\\1", text)
    return "".join(c if _PLAIN.match(c) or not c.isascii() else f"\\{c}" for c in text)


def unquoted(word: str) -> str:
    """Return a single word as typed without its quotes."""
    return read(word, "").typed
