"""Guards calls of foreign code: an exception of any kind stays with the one call.

User code may raise anything, SystemExit included, and so may the text of its exception. Threads
and time-outs for such calls are in `rtkit.serving.workers`.

See decision 38.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

LONGEST_TEXT = 300


class GuardedResult(NamedTuple):
    """The result of a call, or what it raised."""

    result: Any = None
    error: BaseException | None = None


def guarded(work: Callable[[], object]) -> GuardedResult:
    """Call something; nothing that it raises gets out, not SystemExit either."""
    try:
        return GuardedResult(work())
    except BaseException as error:
        return GuardedResult(error=error)


def text_of(error: BaseException) -> str:
    """Return the text of an error on one line, also where asking for it fails."""
    try:
        text = " ".join(str(error).split())
    except BaseException:
        return "(its text cannot be shown)"
    return text if len(text) <= LONGEST_TEXT else f"{text[: LONGEST_TEXT - 1]}…"


def kind_and_text(error: BaseException) -> str:
    """Return ``ValueError: text`` on one line, the class alone where there is no text."""
    text = text_of(error)
    if isinstance(error, ModuleNotFoundError):
        from rtkit.extras import hint

        text += hint(error)
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
