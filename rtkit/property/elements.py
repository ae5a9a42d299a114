"""Reads elements from text: the part of XML that values use.

No document types, no processing instructions, no CDATA, no mixed content, five named entities.
A leaf is read as a value once its entities are decoded; a text that is no value is a string.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from rtkit.property.codes import PropertyError
from rtkit.property.limits import Budget, syntax
from rtkit.property.values import Element, Value

NAME = r"[A-Za-z_][A-Za-z0-9_.\-]*"
_BLANKS = re.compile(r"[ \t\r\n]*")
_OPEN = re.compile(rf"<({NAME})")
_CLOSE = re.compile(rf"</({NAME})[ \t\r\n]*>")
_ATTRIBUTE = re.compile(
    rf"[ \t\r\n]+({NAME})[ \t\r\n]*=[ \t\r\n]*(?:\"([^\"<]*)\"|'([^'<]*)')", re.ASCII
)
_COMMENT = re.compile(r"<!--(?:[^-]|-[^-])*+-->", re.DOTALL)
_TEXT = re.compile(r"[^<]*")
_REFERENCE = re.compile(r"&(?:(lt|gt|amp|quot|apos)|#([0-9]{1,7})|#x([0-9A-Fa-f]{1,6}));|&")
_NAMED = {"lt": "<", "gt": ">", "amp": "&", "quot": '"', "apos": "'"}
_NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


ReadItem = Callable[[str, int, Budget], Value]
"""Reads the text of a leaf as a value that lies some levels deep."""


class _Open:
    """Element whose end has not been read yet."""

    __slots__ = ("attributes", "children", "name", "text")

    def __init__(self, name: str, attributes: dict[str, str]) -> None:
        self.name = name
        self.attributes = attributes
        self.children: list[Element] = []
        self.text: str | None = None


def read_element(
    text: str, start: int, depth: int, budget: Budget, read_item: ReadItem
) -> tuple[Element, int]:
    """Read the element that begins at `start`; return it, and where it ends.

    Raises:
        PropertyError: ``syntax`` or ``too-large``.
    """
    opened: list[_Open] = []
    position = start
    while True:
        if opened and text.startswith("</", position):
            closing = _CLOSE.match(text, position)
            if closing is None or closing[1] != opened[-1].name:
                raise syntax(position, f"expected </{opened[-1].name}>")
            element = _closed(opened.pop(), depth + len(opened), budget, read_item)
            position = closing.end()
        elif opened and text.startswith("<!--", position):
            position = _comment(text, position, opened[-1])
            continue
        elif text.startswith("<", position):
            begun, position, is_empty = _begin(text, position, opened)
            budget.spend(depth + len(opened))
            if not is_empty:
                opened.append(begun)
                continue
            element = Element(begun.name, begun.attributes)
        else:
            position = _characters(text, position, opened[-1])
            continue
        if not opened:
            return element, position
        opened[-1].children.append(element)


def _begin(text: str, position: int, opened: list[_Open]) -> tuple[_Open, int, bool]:
    tag = _OPEN.match(text, position)
    if tag is None:
        raise syntax(position + 1, "expected the name of an element")
    if opened and opened[-1].text is not None:
        raise syntax(position, f"expected </{opened[-1].name}>")
    position = tag.end()
    attributes: dict[str, str] = {}
    while (found := _ATTRIBUTE.match(text, position)) is not None:
        name, raw = found[1], found[2] if found[2] is not None else found[3]
        if name in attributes:
            raise syntax(found.start(1), f"attribute {name} is there already")
        attributes[name] = decoded(raw, found.end() - 1 - len(raw))
        position = found.end()
    position = _skip(text, position)
    if text.startswith("/>", position):
        return _Open(tag[1], attributes), position + 2, True
    if text.startswith(">", position):
        return _Open(tag[1], attributes), position + 1, False
    raise syntax(position, "expected an attribute, > or />")


def _comment(text: str, position: int, parent: _Open) -> int:
    comment = _COMMENT.match(text, position)
    if comment is None:
        raise syntax(position, "expected a comment without -- that ends with -->")
    if parent.text is not None:
        raise syntax(position, f"expected </{parent.name}>")
    return comment.end()


def _characters(text: str, position: int, parent: _Open) -> int:
    found = _TEXT.match(text, position)
    end = found.end() if found else position
    if end == len(text):
        raise syntax(end, f"expected </{parent.name}>")
    raw = text[position:end]
    if raw.strip(" \t\r\n"):
        if parent.children:
            raise syntax(_skip(text, position), "expected an element: it has others before")
        parent.text = decoded(raw, position)
        if text.startswith("<", end) and not text.startswith("</", end):
            raise syntax(end, f"expected </{parent.name}>")
    return end


def _closed(opened: _Open, depth: int, budget: Budget, read_item: ReadItem) -> Element:
    leaf = None if opened.text is None else _leaf(opened.text, depth + 1, budget, read_item)
    return Element(opened.name, opened.attributes, tuple(opened.children), leaf)


def _leaf(text: str, depth: int, budget: Budget, read_item: ReadItem) -> Value:
    """Return the value in a leaf; depth bounds how often leaves can lie in leaves."""
    budget.spend(depth)
    try:
        return read_item(text, depth, budget)
    except PropertyError as error:
        if error.code != "syntax":
            raise
        return text.strip(" \t\r\n")


def decoded(raw: str, offset: int) -> str:
    """Return character data with its entities replaced.

    Raises:
        PropertyError: ``syntax``: another entity, or a character that XML does not know.
    """

    def character(match: re.Match[str]) -> str:
        if match[1]:
            return _NAMED[match[1]]
        code = int(match[2]) if match[2] else int(match[3], 16) if match[3] else -1
        if not 0 <= code <= 0x10FFFF or _NOT_XML.match(chr(code)):
            raise syntax(offset + match.start(), "unknown entity")
        return chr(code)

    bad = _NOT_XML.search(raw)
    if bad is not None:
        raise syntax(offset + bad.start(), "unexpected character")
    return _REFERENCE.sub(character, raw) if "&" in raw else raw


def _skip(text: str, position: int) -> int:
    blanks = _BLANKS.match(text, position)
    return blanks.end() if blanks else position
