"""Finds the known words nearest to a word that was mistyped."""

from __future__ import annotations

from collections.abc import Callable, Iterable

CLOSE_ENOUGH = 0.6
CLOSE = 0.75
"""How alike words are of which one is another mistyped, where there may be many others."""
_NO_WORSE = 0.15
_SHORTEST = 5


def nearest(
    word: str, known: Iterable[str], most: int = 3, least: float = CLOSE_ENOUGH
) -> list[str]:
    """Return the known words that look most like this one, capitals or not, the best first."""
    folded = word.casefold()
    known = [each for each in known if _likeness_at_most(folded, each.casefold()) >= least]
    if not known:
        return []
    from difflib import SequenceMatcher  # 0035: most words resemble none, and it costs 1 ms

    matcher = SequenceMatcher(b=folded)
    likeness: dict[str, float] = {}
    for each in known:
        matcher.set_seq1(each.casefold())
        if matcher.ratio() >= least:
            likeness[each] = matcher.ratio()
    worst = max(likeness.values(), default=0.0) - _NO_WORSE
    near = [each for each, ratio in likeness.items() if ratio >= worst]
    return sorted(near, key=lambda each: -likeness[each])[:most]


def _likeness_at_most(one: str, other: str) -> float:
    """Return a bound of how alike two words are, by their letters, whatever their order."""
    shared = sum(min(one.count(c), other.count(c)) for c in set(one))
    return 2 * shared / (len(one) + len(other)) if one or other else 1.0


def is_slip(word: str, meant: str) -> bool:
    """Return whether two words differ by a slip: letters swapped, one left out or too many.

    Short words, and those that differ only in a digit, are none of each other.
    """
    short, long = sorted((word, meant), key=len)
    if len(short) < _SHORTEST or len(long) - len(short) > 1:
        return False
    if len(short) < len(long):
        return any(c.isalpha() and long[:n] + long[n + 1 :] == short for n, c in enumerate(long))
    unlike = [n for n, (one, other) in enumerate(zip(word, meant, strict=True)) if one != other]
    if len(unlike) != 2:
        return False
    first, last = unlike
    is_swapped = last == first + 1 and word[first : last + 1] == meant[first : last + 1][::-1]
    return is_swapped and word[first : last + 1].isalpha()


def did_you_mean(
    word: str,
    known: Iterable[str],
    most: int = 3,
    shown: Callable[[str], str] = str,
    least: float = CLOSE_ENOUGH,
) -> str:
    """Return ``" (did you mean A or B?)"``, empty where nothing looks like the word."""
    near = [shown(each) for each in nearest(word, known, most, least)]
    return f" (did you mean {' or '.join(near)}?)" if near else ""
