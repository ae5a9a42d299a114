"""Change of a live property, as scripts and clients hear of it."""

from __future__ import annotations

from typing import Any, NamedTuple


class PropertyChange(NamedTuple):
    """A value that a property came to have.

    Attributes:
        target: The property, as it was named.
        value: Numbers, booleans, texts, lists; elements as tables; bytes as they are. The
            last one, or an empty text, where there is a code.
        time: When it came into force [s since 1970].
        quality: ``good``, ``uncertain``, ``bad``, or ``stale`` while the owner is away.
        code: Why there is no value now: ``no-service`` while the owner is away, otherwise nothing
            further will come; empty while it lives.
    """

    target: str
    value: Any
    time: float
    quality: str = "good"
    code: str = ""
