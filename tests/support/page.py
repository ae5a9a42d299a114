"""Emulates a terminal's screen, as far as reading live pages needs."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import Any

from terminal import Terminal

_SEQUENCE = re.compile(r"\x1b\[(\??)([\d;]*)([A-Za-z])|\x1b[()][A-Z0-9]|\x1b[=>]")
_PATIENCE_S = 30.0
_OTHERS = (7, 2004)
"""Modes that tell nothing of a page: wrapping at the margin, marked pasting of shells."""


class Page:
    """The page of a terminal.

    Attributes:
        lines: What stands there.
        modes: Private modes that are set: 1049 for the other page, 25 while the cursor shows.
        said: Everything that was written.
    """

    def __init__(self, terminal: Terminal, columns: int = 80, rows: int = 24) -> None:
        self._terminal = terminal
        self.modes = {25}
        self.said = ""
        self._rest = ""
        self.resize(columns, rows)

    def resize(self, columns: int, rows: int) -> None:
        """Give the terminal another size; its program is told."""
        self._columns = columns
        self.lines = [""] * rows
        self._at = (0, 0)
        self._terminal.resize(columns, rows)

    def until(self, holds: Callable[[list[str]], Any]) -> Any:
        """Wait until something holds for the lines, and return that."""
        deadline = time.monotonic() + _PATIENCE_S
        while not (found := holds(self.lines)):
            assert time.monotonic() < deadline, self._shown()
            more = self._terminal.more()
            assert more, self._shown()
            self._take(more)
        return found

    def row(self, word: str) -> str:
        """Wait until a line has a word in it, and return that line."""
        return str(self.until(lambda lines: [line for line in lines if word in line])[0])

    def rest(self) -> None:
        """Read what is written until the program ends."""
        while more := self._terminal.more():
            self._take(more)

    def _shown(self) -> str:
        return "\n".join(self.lines)

    def _take(self, text: str) -> None:
        self.said += text
        text, self._rest = self._rest + text, ""
        while text:
            if text[0] != "\x1b":
                self._put(text[0])
                text = text[1:]
                continue
            match = _SEQUENCE.match(text)
            if match is None:
                self._rest = text
                return
            if match[3]:
                self._obey(match[1], match[2], match[3])
            text = text[match.end() :]

    def _put(self, c: str) -> None:
        line, column = self._at
        if c == "\n":
            if line == len(self.lines) - 1:
                self.lines = [*self.lines[1:], ""]
            self._at = (min(line + 1, len(self.lines) - 1), column)
        elif c == "\r":
            self._at = (line, 0)
        elif c >= " " and column < self._columns:
            present = self.lines[line].ljust(column)
            self.lines[line] = present[:column] + c + present[column + 1 :]
            self._at = (line, column + 1)

    def _obey(self, private: str, numbers: str, letter: str) -> None:
        values = [int(each or 0) for each in numbers.split(";")]
        line, column = self._at
        if private and letter in "hl":
            change = self.modes.add if letter == "h" else self.modes.discard
            for value in values:
                if value not in _OTHERS:
                    change(value)
        elif letter == "H":
            at = (max(1, values[0]) - 1, max(1, (values[1:] or [1])[0]) - 1)
            self._at = (min(at[0], len(self.lines) - 1), at[1])
        elif letter == "K":
            self.lines[line] = self.lines[line][:column]
        elif letter == "J":
            first = 0 if values[0] == 2 else line
            self.lines[first:] = [""] * (len(self.lines) - first)
