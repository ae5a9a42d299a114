"""Rules of assemblies as a constraint of a parameter, which profiles hold and rtkit checks.

Made of what `read_assembly` refuses, so that there is one truth: each assembly is tried, and each
rule told by the fewest words that break it, behind the sentence with which they are refused.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations, product
from math import prod

from .assembly import KEYS, MOST_GAIN, OVER, PERIMETERS, WORDS, Assembly, _rules, variants

_ANY = 'like("*")'
_NEVER = f"not({_ANY})"
_BOUND_IS = f"over {' or '.join(OVER)}, and perimeters {', '.join(PERIMETERS)} from 0 on"
_GAINS = (0.0, 0.5)
_CHOICES: Mapping[str, tuple[object, ...]] = {
    **{key: tuple(words) for key, words in WORDS.items()},
    "gain": _GAINS,
}
Words = tuple[tuple[str, tuple[object, ...]], ...]
"""Keys, each with words of which an assembly has one."""


def constraint_of_variants() -> str:
    """Return what the parameter ``variant`` may be: a name, or an assembly as JSON."""
    names = ", ".join(variants())
    parts = [
        _said(
            f"it is one of {names}, or an assembly in braces",
            f'{_one_of(variants())},like("{{*")',
        ),
        _said("what is in braces is no JSON object", _always(f'key("",{_NEVER})')),
        _said(f"an assembly has no other keys than {', '.join(KEYS)}", _always(_closed(KEYS))),
    ]
    for key, words in WORDS.items():
        known = ", ".join(map(str, words))
        parts.append(_said(f"{key} is one of {known}", _always(f"key({key},{_one_of(words)})")))
    parts.append(_said(f"gain is from 0 to {MOST_GAIN} m", _always(f"key(gain,0<=x<={MOST_GAIN})")))
    parts.append(_said(f"a bound is {_BOUND_IS}", _always(f"key(bound,{_bound()})")))
    for why, refused in _refused().items():
        broken = _any("or", [_any("and", [_atom(*each) for each in words]) for words in refused])
        parts.append(_said(why, f"not({broken})"))
    return f"and({','.join(parts)})"


def _bound() -> str:
    over = f"not({_always(f'key(over,not({_one_of(OVER)}))')})"
    numbers = ",".join(f"key({key},x>=0)" for key in PERIMETERS)
    keys = _closed(("over", *PERIMETERS))
    return f'and(like("{{*"),{over},{_always(numbers)},{_always(keys)})'


def _closed(keys: Iterable[str]) -> str:
    """Return that there are no other keys than these."""
    named = ",".join(f"key({key},{_ANY})" for key in keys)
    return f'{named},key("*",{_NEVER})'


def _always(keys: str) -> str:
    """Return what holds of keys, true where they are absent: a hash alone says nothing then."""
    return f"and({_ANY},hash({keys}))"


def _refused() -> dict[str, list[Words]]:
    """Return by sentence the least combinations of words that break its rule."""
    made = [
        (words, _rules(Assembly(**dict(zip(_CHOICES, words, strict=True)))))
        for words in product(*_CHOICES.values())
    ]
    broken: dict[str, set[tuple[object, ...]]] = {}
    for words, rules in made:
        for is_broken, why in rules:
            if is_broken:
                broken.setdefault(why, set()).add(words)
    return {why: list(_least(of_rule)) for why, of_rule in broken.items()}


def _least(broken: set[tuple[object, ...]]) -> Iterator[Words]:
    """Yield the fewest words with which all assemblies are among the broken ones."""
    keys = list(_CHOICES)
    places = [at for at in range(len(keys)) if _matters(at, broken)]
    known: list[frozenset[tuple[str, object]]] = []
    for count in range(1, len(places) + 1):
        for chosen in combinations(places, count):
            with_all = Counter(tuple(words[at] for at in chosen) for words in broken)
            others = (len(_CHOICES[key]) for at, key in enumerate(keys) if at not in chosen)
            whole = prod(others)
            found: dict[tuple[object, ...], list[object]] = {}
            for words in sorted((w for w, n in with_all.items() if n == whole), key=str):
                pairs = frozenset((keys[at], word) for at, word in zip(chosen, words, strict=True))
                if not any(each <= pairs for each in known):
                    known.append(pairs)
                    found.setdefault(words[:-1], []).append(words[-1])
            for head, last in found.items():
                several = [*((word,) for word in head), tuple(last)]
                yield tuple((keys[at], each) for at, each in zip(chosen, several, strict=True))


def _matters(at: int, broken: set[tuple[object, ...]]) -> bool:
    """Return whether another word at a place may make a broken assembly a good one."""
    words = _CHOICES[list(_CHOICES)[at]]
    return any((*e[:at], word, *e[at + 1 :]) not in broken for e in broken for word in words)


def _atom(key: str, words: tuple[object, ...]) -> str:
    """Return that an assembly has one of these, also where it says nothing: then the default."""
    if key == "gain":
        is_default, holds = not words[0], "x>0" if words[0] else "0"
    else:
        is_default, holds = WORDS[key][0] in words, _one_of(words)
    if is_default:
        return _always(f"key({key},{holds})")
    return f"not({_always(f'key({key},not({holds}))')})"


def _one_of(words: Iterable[object]) -> str:
    """Return that it is one of these words, letter by letter."""
    return f"({','.join(map(_exact, words))})"


def _said(sentence: str, rest: str) -> str:
    return f"or({_quoted(sentence + '.')},{rest})"


def _any(word: str, parts: Iterable[str]) -> str:
    found = list(parts)
    return found[0] if len(found) == 1 else f"{word}({','.join(found)})"


def _quoted(text: object) -> str:
    return json.dumps(str(text))


def _exact(text: object) -> str:
    return f"'{text}'"
