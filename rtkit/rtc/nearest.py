"""What somebody may have meant who typed a word that is not known."""

from __future__ import annotations

from collections.abc import Iterable

CLOSE_ENOUGH = 0.6


def nearest(word: str, known: Iterable[str], most: int = 3) -> list[str]:
    """Return the known words that look most like this one, capitals or not, the best first."""
    from difflib import get_close_matches

    by_look: dict[str, list[str]] = {}
    for each in dict.fromkeys(known):
        by_look.setdefault(each.casefold(), []).append(each)
    near = get_close_matches(word.casefold(), by_look, most, CLOSE_ENOUGH)
    return [each for look in near for each in by_look[look]][:most]


def did_you_mean(word: str, known: Iterable[str], most: int = 3) -> str:
    """Return ``" (did you mean A or B?)"``, empty where nothing looks like the word."""
    near = nearest(word, known, most)
    return f" (did you mean {' or '.join(near)}?)" if near else ""
