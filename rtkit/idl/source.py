"""Assembles the text of an IDL file and of all that it includes, each line with its origin.

A file is read once, whether or not it guards itself.

The preprocessor has the directives that interface definitions use: ``#include``, guards,
``#define`` of a name or a plain value, ``#if`` of ``0``, ``1`` and ``defined(NAME)``. It ignores
``#pragma``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

from rtkit.errors import InvalidDocument
from rtkit.idl.model import SourceLine

_COMMENT_OR_TEXT = re.compile(r'//[^\n]*|/\*.*?(?:\*/|\Z)|"(?:\\.|[^"\\\n])*"', re.DOTALL)
_DIRECTIVE = re.compile(r"\s*#\s*([a-z]*)\s*(.*?)\s*$", re.DOTALL)
_INCLUDE = re.compile(r'["<]([^">]+)[">]')
_NAME = r"[A-Za-z_]\w*"
_DEFINED = re.compile(rf"(!?)\s*defined\s*\(?\s*({_NAME})\s*\)?")
_DEFINE = re.compile(rf"({_NAME})(\(?)\s*(.*)", re.DOTALL)
_IGNORED = ("pragma", "ident", "line", "warning", "")


class InvalidIdl(InvalidDocument):
    """An IDL file that cannot be read; the message names file and line."""


class IdlLine(NamedTuple):
    """A line of text and where it stands."""

    text: str
    place: SourceLine


Find = Callable[[str, str], tuple[str, str] | None]
"""Takes an included name and the including file; returns file and text, None when not found."""


class IdlSource:
    """One file and what it includes.

    Attributes:
        lines: All lines that count, in order.
        missing: Included names that were not found.
    """

    def __init__(self, file: str, text: str, find: Find) -> None:
        self._find = find
        self._defined: dict[str, str] = {}
        self._seen: set[str] = set()
        self.missing: list[str] = []
        self.lines = list(self._read(file, text))

    @property
    def text(self) -> str:
        """The lines as one text."""
        return "".join(f"{line.text}\n" for line in self.lines)

    def place(self, line: int) -> SourceLine:
        """Return file and line of a line of the text; lines count from 1."""
        if not self.lines:
            return SourceLine("", 1)
        return self.lines[min(max(line, 1), len(self.lines)) - 1].place

    def _read(self, file: str, text: str) -> Iterator[IdlLine]:
        if file in self._seen:
            return
        self._seen.add(file)
        text = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
        masked = _COMMENT_OR_TEXT.sub(_blank, text).split("\n")
        active = [True]
        end = 0
        for number, line in enumerate(text.split("\n"), 1):
            place = SourceLine(file, number)
            if number <= end:
                continue
            if not masked[number - 1].lstrip().startswith("#"):
                if all(active):
                    yield IdlLine(self._replaced(line), place)
                continue
            end = number
            while masked[end - 1].endswith("\\") and end < len(masked):
                end += 1
            lines = text.split("\n")[number - 1 : end]
            code = _without_comments(" ".join(each.removesuffix("\\") for each in lines))
            word, rest = _directive(code)
            if word in ("if", "ifdef", "ifndef", "else", "elif", "endif"):
                self._branch(word, rest, active, place)
            elif all(active):
                yield from self._perform(word, rest, place)
        if len(active) > 1:
            raise InvalidIdl(f"{file}:{number}: #endif is missing")

    def _perform(self, word: str, rest: str, place: SourceLine) -> Iterator[IdlLine]:
        if word == "include":
            included = _INCLUDE.match(rest)
            if not included:
                raise InvalidIdl(f'{place}: #include needs "FILE" or <FILE>')
            found = self._find(included[1], place.file)
            if found is None:
                self.missing.append(included[1])
            else:
                yield from self._read(*found)
        elif word == "define":
            macro = _DEFINE.match(rest)
            if not macro or macro[2]:
                raise InvalidIdl(f"{place}: #define is understood of plain names only: {rest}")
            self._defined[macro[1]] = macro[3]
        elif word == "undef":
            self._defined.pop(rest, None)
        elif word not in _IGNORED:
            raise InvalidIdl(f"{place}: #{word} {rest}".rstrip())

    def _branch(self, word: str, rest: str, active: list[bool], place: SourceLine) -> None:
        if word in ("ifdef", "ifndef"):
            active.append((rest in self._defined) == (word == "ifdef"))
        elif word == "if":
            active.append(self._condition(rest, place) if all(active) else False)
        elif len(active) == 1 or word == "elif":
            why = "#elif is not understood" if word == "elif" else f"#{word} without #if"
            raise InvalidIdl(f"{place}: {why}")
        elif word == "else":
            active[-1] = not active[-1]
        else:
            active.pop()

    def _condition(self, text: str, place: SourceLine) -> bool:
        if text in ("0", "1"):
            return text == "1"
        asked = _DEFINED.fullmatch(text)
        if not asked:
            raise InvalidIdl(f"{place}: #if is understood of 0, 1 and defined(NAME): {text}")
        return (asked[2] in self._defined) != bool(asked[1])

    def _replaced(self, line: str) -> str:
        values = {name: value for name, value in self._defined.items() if value}
        if not values:
            return line
        return re.sub(_NAME, lambda found: values.get(found[0], found[0]), line)


def _blank(found: re.Match[str]) -> str:
    return re.sub(r"[^\n]", " ", found[0])


def _without_comments(code: str) -> str:
    return re.sub(r"//.*|/\*.*?(?:\*/|$)", " ", code)


def _directive(code: str) -> tuple[str, str]:
    found = _DIRECTIVE.match(code)
    return (found[1], found[2]) if found else ("", "")
