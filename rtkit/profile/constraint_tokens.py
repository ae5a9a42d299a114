"""Tokens of one-line constraints: literals, signs and marks, from text and back."""

from __future__ import annotations

import re
from typing import NamedTuple

from rtkit.errors import Malformed

VARIABLE = "x"
"""Placeholder of the value in ``x>1``."""

_TOKEN = re.compile(
    r"""\s*(?:
        (?P<quoted>"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')
      | (?P<sign><=|>=|!=|<|>)
      | (?P<mark>[(){},:])
      | (?P<word>(?:[^<>=(){},:\s!]|!(?!=))+)
    )\s*""",
    re.DOTALL | re.VERBOSE,
)
_PLAIN = re.compile(r"[^<>=(){},:\s!\\'\"]+")
_ESCAPED = {"\n": "n", "\r": "r", "\t": "t"}
_MEANT = {letter: character for character, letter in _ESCAPED.items()}


class Token(NamedTuple):
    """A piece of a constraint.

    Attributes:
        kind: word, quoted, sign or mark.
        is_exact: Whether its case matters, as in ``'Word'``.
    """

    kind: str
    text: str
    is_exact: bool = False

    @property
    def is_literal(self) -> bool:
        """Return whether it can be a value."""
        return self.kind in ("word", "quoted")

    @property
    def is_variable(self) -> bool:
        """Return whether it stands for the value that is tested."""
        return self.kind == "word" and self.text == VARIABLE


def tokens(text: str) -> list[Token]:
    """Return the pieces of a constraint; blanks mean nothing, except inside quotes.

    Raises:
        Malformed: A character belongs nowhere.
    """
    found: list[Token] = []
    place = 0
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            if text[place:].isspace():
                break
            raise Malformed(f"bad constraint {text!r}: nothing begins with {text[place:].strip()}")
        place = match.end()
        kind = match.lastgroup or ""
        token = Token(kind, match[kind])
        if kind == "quoted":
            token = Token(kind, _unquoted(token.text), token.text[0] == "'")
        elif kind == "word" and found and found[-1].kind == "word":
            token = Token(kind, found.pop().text + token.text)
        found.append(token)
    return found


def _unquoted(text: str) -> str:
    return re.sub(r"\\(.)", lambda m: _MEANT.get(m[1], m[1]), text[1:-1], flags=re.DOTALL)


def literal(text: str, *, is_exact: bool = False) -> str:
    """Return a value as `tokens` reads it back: plain where that is possible."""
    if not is_exact and _PLAIN.fullmatch(text):
        return text
    quote = "'" if is_exact else '"'
    written = "".join(
        f"\\{_ESCAPED.get(c, c)}" if c in _ESCAPED or c in (quote, "\\") else c for c in text
    )
    return f"{quote}{written}{quote}"
