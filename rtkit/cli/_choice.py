"""Values of options out of a few words: in any case of letters, and what was meant is guessed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click


class Words(click.Choice[str]):
    """One of these words, which are capitals; a dash stands for an underscore.

    Args:
        what: What they are, in a message: ``level``.
        words: The words.
        is_short: The beginning of a word is enough.
    """

    def __init__(self, what: str, words: Sequence[str], *, is_short: bool = False) -> None:
        super().__init__(words)
        self._what = what
        self._is_short = is_short

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the word that is meant."""
        typed = str(value).casefold()
        for word in self.choices:
            known = word.casefold()
            if typed in (known, known.replace("_", "-")):
                return word
            if self._is_short and typed and known.startswith(typed):
                return word
        from rtkit.rtc.nearest import did_you_mean

        hint = did_you_mean(str(value), self.choices)
        self.fail(f"unknown {self._what}: {value}{hint}; known: {', '.join(self.choices)}")
