"""Option types: words out of a few, with a suggestion for a misspelt one, finite numbers, times.

Words are taken in any case of letters. Numbers must be finite: neither ``nan``
nor infinity, to which ``1e400`` overflows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import click


class WordChoice(click.Choice[str]):
    """One of these words, which are capitals; a dash stands for an underscore.

    Args:
        what: Noun for them in a message: ``level``.
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


class NumberChoice(click.FloatRange):
    """A number within bounds, as `click.FloatRange`, and finite."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the number that was typed."""
        number: float = super().convert(value, param, ctx)
        if number - number != 0.0:
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        return number


F = TypeVar("F", bound=Callable[..., Any])


def lasting(text: str = "Stop after this time.", long: str = "--timeout") -> Callable[[F], F]:
    """Add ``-t``, as `duration_s`: a time above zero [s], None if it was not given."""
    return click.option(
        "-t",
        long,
        "duration_s",
        type=NumberChoice(min=0.0, min_open=True),
        metavar="SECONDS",
        help=text,
    )
