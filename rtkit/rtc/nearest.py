"""What somebody may have meant who typed a word that is not known."""

from __future__ import annotations

from collections.abc import Callable, Iterable

CLOSE_ENOUGH = 0.6
_NO_WORSE = 0.15


def nearest(word: str, known: Iterable[str], most: int = 3) -> list[str]:
    """Return the known words that look most like this one, capitals or not, the best first."""
    from difflib import SequenceMatcher

    matcher = SequenceMatcher(b=word.casefold())
    likeness: dict[str, float] = {}
    for each in known:
        matcher.set_seq1(each.casefold())
        if matcher.quick_ratio() >= CLOSE_ENOUGH and matcher.ratio() >= CLOSE_ENOUGH:
            likeness[each] = matcher.ratio()
    least = max(likeness.values(), default=0.0) - _NO_WORSE
    near = [each for each, ratio in likeness.items() if ratio >= least]
    return sorted(near, key=lambda each: -likeness[each])[:most]


def did_you_mean(
    word: str, known: Iterable[str], most: int = 3, shown: Callable[[str], str] = str
) -> str:
    """Return ``" (did you mean A or B?)"``, empty where nothing looks like the word."""
    near = [shown(each) for each in nearest(word, known, most)]
    return f" (did you mean {' or '.join(near)}?)" if near else ""
