"""Writes any text as Python source: literals and docstrings.

Lines keep to the width of the house, counted in columns of a terminal, and have the form that
``ruff format`` gives them. No text from outside becomes a comment.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence

WIDTH = 100
INDENT = "    "
_ESCAPES = {"\\": "\\\\", "\n": "\\n", "\r": "\\r", "\t": "\\t"}
_BREAK = re.compile(r"\r\n?|<br ?/?>")
_ENDS = (".", "?", "!")
_HEADS = """
    args arguments attention attributes caution danger error example examples hint important
    methods note notes raises references return returns tip todo warning warnings warns yield
    yields
"""
_SECTIONS = {*_HEADS.split(), "keyword args", "keyword arguments", "other args", "see also"}
"""Words that Google's style takes for the head of a section when alone on a line."""


def width(text: str) -> int:
    """Return how many columns a text takes."""
    if text.isascii():
        return len(text)
    return sum(1 + (unicodedata.east_asian_width(c) in "WF") for c in text)


def literal(text: str) -> str:
    """Return a string literal."""
    quote = "'" if text.count('"') > text.count("'") else '"'
    return quote + "".join(_escaped(c, quote) for c in text) + quote


def _escaped(c: str, quote: str) -> str:
    if c in _ESCAPES:
        return _ESCAPES[c]
    if c == quote:
        return f"\\{c}"
    return c if c.isprintable() else c.encode("unicode_escape").decode("ascii")


def value(content: object) -> str:
    """Return the literal of a number or a truth value."""
    if isinstance(content, float) and not math.isfinite(content):
        return f'float("{content!r}")'
    return repr(content).replace("e+", "e")


def cut_text(text: str, indent: str) -> list[str]:
    """Return a text as literals below each other, to stand inside brackets."""
    room = WIDTH - width(indent)
    pieces = [""]
    for word in _words(text):
        for part in _parts(word, room):
            if pieces[-1] and width(literal(pieces[-1] + part)) > room:
                pieces.append("")
            pieces[-1] += part
    return [f"{indent}{literal(piece)}" for piece in pieces]


def _words(text: str) -> list[str]:
    words = text.split(" ")
    return [*(f"{word} " for word in words[:-1]), words[-1]]


def _parts(word: str, room: int) -> Iterator[str]:
    """Yield a word, or where its literal does not fit pieces of it that do."""
    # No character takes more than ten columns: \U0010ffff.
    while width(literal(word)) > room:
        cut = max(1, (room - 2) // 10)
        while cut < len(word) and width(literal(word[: cut + 1])) <= room:
            cut += 1
        yield word[:cut]
        word = word[cut:]
    yield word


def clean(text: str | None) -> str:
    """Return documentation without invisible characters; its lines are kept."""
    plain = _BREAK.sub("\n", text or "")
    lines = [" ".join(line.split()) for line in plain.split("\n")]
    return "\n".join("".join(filter(str.isprintable, line)) for line in lines).strip()


def one_line(text: str | None) -> str:
    """Return documentation on one line."""
    return " ".join(clean(text).split())


def wrapped(text: str, room: int) -> list[str]:
    """Return text in lines of at most `room` columns; ASCII words stay whole."""
    found: list[str] = []
    for line in text.split("\n"):
        lines = [""]
        for word in line.split(" "):
            for part in _slices(word, room):
                joined = f"{lines[-1]} {part}" if lines[-1] else part
                if lines[-1] and width(joined) > room:
                    lines.append(part)
                else:
                    lines[-1] = joined
        found += lines
    return found


def _slices(word: str, room: int) -> Iterator[str]:
    while not word.isascii() and width(word) > room:
        cut = max(1, room // 2)
        while cut < len(word) and width(word[: cut + 1]) <= room:
            cut += 1
        yield word[:cut]
        word = word[cut:]
    yield word


def docstring(
    neutral: str,
    text: str | None,
    paragraphs: Iterable[str] = (),
    indent: str = "",
    sections: Sequence[str] = (),
) -> list[str]:
    """Return the lines of a docstring.

    Args:
        neutral: Its first line where `text` does not fit there.
        text: Its text.
        paragraphs: What follows.
        indent: Indentation of each line.
        sections: Lines of our own that end it.
    """
    room = WIDTH - width(indent)
    body = clean(text)
    first = sentence(body)
    fits = "\n" not in body and width(first) <= room - 7
    is_summary = fits and not body.startswith('"') and not _begins_with_a_name(body)
    rest = [clean(each) for each in ([] if is_summary else [body]) + list(paragraphs)]
    lines = [first if is_summary and body else neutral]
    for part in filter(None, rest):
        lines += ["", *(_harmless(line) for line in wrapped(part, room - 2))]
    return quoted([*lines, *sections], indent)


def quoted(lines: Sequence[str], indent: str) -> list[str]:
    """Return lines between the quotes of a docstring."""
    safe = [line.replace('"""', "'''") for line in lines]
    prefix = 'r"""' if any("\\" in line for line in safe) else '"""'
    if len(safe) == 1:
        return [f'{indent}{prefix}{safe[0]}"""']
    tail = [f"{indent}{line}".rstrip() for line in safe[1:]]
    return [f"{indent}{prefix}{safe[0]}", *tail, f'{indent}"""']


def sentence(text: str) -> str:
    """Return a text with a capital and a full stop."""
    first = _first_word(text)
    is_word = first.isascii() and first.isalpha() and first == first.lower()
    capital = text[:1].upper() + text[1:] if is_word else text
    return capital if capital.endswith(_ENDS) else f"{capital}."


def _first_word(text: str) -> str:
    return text.partition(" ")[0].rstrip(".,:;!?")


def _begins_with_a_name(text: str) -> bool:
    """Return whether the first word is one whose capitals matter: ``onExecute``."""
    first = _first_word(text)
    return first.isascii() and first.isalpha() and first[0].islower() and first != first.lower()


def doc_text(doc: object, name: str) -> str:
    """Return a text of a documentation element, which may be absent."""
    return getattr(doc, name, None) or ""


def _harmless(line: str) -> str:
    """Return a line of documentation that reads neither as a section head nor as a region mark."""
    is_head = line.rstrip(": ").lower() in _SECTIONS
    return f"- {line}" if is_head or line.startswith("#") else line
