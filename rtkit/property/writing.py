"""Writes values as canonical text: equal values are written alike.

Laws: ``read(write(value)) == value``, and ``write(read(text))`` is a fixed point.
"""

from __future__ import annotations

import re

from rtkit.property.codes import PropertyError
from rtkit.property.limits import LIMITS
from rtkit.property.reading import CONTROL, read
from rtkit.property.values import Element, Value, Word
from rtkit.xmltext import bad_character

_ATOM = re.compile(rf"[^\s()<>\"{{}}{CONTROL}]+")
_PLAIN = re.compile(rf"[^\"\\{CONTROL}\ud800-\udfff]*")
_SPECIAL = re.compile(rf"[\"\\{CONTROL}]")
_SHORT = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\r": "\\r", "\t": "\\t"}
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.\-]*")
_MARKUP = {"&": "&amp;", "<": "&lt;", ">": "&gt;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
_IN_LEAF = str.maketrans(_MARKUP)
_IN_ATTRIBUTE = str.maketrans({**_MARKUP, '"': "&quot;"})
_ODD = frozenset({"nan", "inf", "true", "false"})


def write(value: Value, depth: int = 0) -> str:
    """Return the canonical text of a value.

    Raises:
        PropertyError: ``too-large``: nested too deep; ``bad-value``: no text stands for it.
    """
    if type(value) is float:
        return repr(value)
    if isinstance(value, tuple):
        if depth >= LIMITS.depth:
            raise PropertyError("too-large", f"nested deeper than {LIMITS.depth}")
        return f"({' '.join([write(item, depth + 1) for item in value])})"
    if isinstance(value, str):
        return _word(value) if isinstance(value, Word) else quoted(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return _number(value)
    if isinstance(value, Element):
        return _element(value, depth + 1)
    raise PropertyError("bad-value", f"no text stands for a {type(value).__name__}")


def as_item(name: str) -> str:
    """Return a name as an item of a list: one that reads as a number or boolean is quoted."""
    if name[:1].isalpha() and name not in _ODD:
        return name
    return write(Word(name))


def worded(value: Value) -> Value:
    """Return a value with words in it for the texts that need no quotes."""
    if isinstance(value, tuple):
        return tuple(map(worded, value))
    if isinstance(value, str) and not _word(value).startswith('"'):
        return Word(value)
    return value


def _number(value: float) -> str:
    try:
        return repr(value)
    except ValueError as error:
        raise PropertyError("too-large", str(error)) from None


def _word(text: str) -> str:
    if text and _ATOM.fullmatch(text) and text.isprintable():
        try:
            if isinstance(read(text), Word):
                return str(text)
        except PropertyError:
            return quoted(text)
    return quoted(text)


def quoted(text: str) -> str:
    """Return a text as a string in quotes.

    Raises:
        PropertyError: ``bad-value``: it holds half a character (a lone surrogate).
    """
    if _PLAIN.fullmatch(text):
        return f'"{text}"'
    if any("\ud800" <= c <= "\udfff" for c in text):
        raise PropertyError("bad-value", "text with half a character in it")
    return f'"{_SPECIAL.sub(_escaped, text)}"'


def _escaped(match: re.Match[str]) -> str:
    return _SHORT.get(match[0]) or f"\\u{{{ord(match[0]):x}}}"


def _element(element: Element, depth: int) -> str:
    if depth > LIMITS.depth:
        raise PropertyError("too-large", f"nested deeper than {LIMITS.depth}")
    parts = [f"<{_checked(element.name)}"]
    for name, text in element.attributes.items():
        if bad_character(text):
            raise PropertyError("bad-value", f"attribute {name} has a character XML does not know")
        parts.append(f' {_checked(name)}="{text.translate(_IN_ATTRIBUTE)}"')
    if element.children:
        children = "".join([_element(child, depth + 1) for child in element.children])
        return f"{''.join(parts)}>{children}</{element.name}>"
    if element.leaf is None:
        return f"{''.join(parts)}/>"
    return f"{''.join(parts)}>{_leaf(element.leaf, depth + 1)}</{element.name}>"


def _leaf(value: Value, depth: int) -> str:
    text = write(value, depth)
    # A word that needs quotes reads as a string: it is written as that string is.
    if isinstance(value, str) and text[:1] == '"' and _is_bare(bare := str(value)):
        text = bare
    return text.translate(_IN_LEAF)


def _is_bare(text: str) -> bool:
    """Return whether a string needs no quotes in a leaf: because it reads as nothing else."""
    if not text or text != text.strip(" \t\r\n") or bad_character(text):
        return False
    try:
        read(text)
    except PropertyError as error:
        return error.code == "syntax"
    return False


def _checked(name: str) -> str:
    if not _NAME.fullmatch(name):
        raise PropertyError("bad-value", f"not a name of an element or attribute: {name!r}")
    return name
