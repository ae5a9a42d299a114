"""Assemblies: variants as data, each made of operations by their names, read and checked here."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from math import nan
from pathlib import Path
from typing import Any

from rtkit.errors import NotFound, Refused

SHIPPED = Path(__file__).parent / "variants.json"

STRAIGHT, LINE, TANGENT = "straight", "m-line", "tangent"
ANYWHERE, NEAREST_POINT = "anywhere", "nearest point"
HIT, LINE_POINTS, ALL_POINTS, SINCE_HIT, NOTHING = (
    "hit point",
    "points of the m-line",
    "all points",
    "points since the hit",
    "nothing",
)
FREE_WAY, FREE_RANGE, VISIBLE_POINTS = "free way", "free range", "visible points"
AT_ONCE, CIRCUIT = "at once", "whole circuit"
FIXED, ALTERNATE, SLOPE, SLIDING = "fixed", "alternate", "slope", "sliding"
NO_MEMORY, TURN_ROUND = "none", "turn round"

WORDS: Mapping[str, Sequence[str]] = {
    "motion": (STRAIGHT, LINE, TANGENT),
    "leave": (ANYWHERE, LINE, NEAREST_POINT),
    "nearer_than": (HIT, LINE_POINTS, ALL_POINTS, SINCE_HIT, NOTHING),
    "by": (FREE_WAY, FREE_RANGE, VISIBLE_POINTS),
    "research": (AT_ONCE, CIRCUIT),
    "direction": (FIXED, ALTERNATE, SLOPE, SLIDING),
    "memory": (NO_MEMORY, TURN_ROUND),
}
"""The operations by what they are for; the first of each is taken where nothing is said."""
KEYS = (*WORDS, "gain", "bound", "source", "summary")
"""All that an assembly may say."""
MOST_GAIN = 10
OVER = ("m-line", "disc")
PERIMETERS = ("each", "crossing", "minimum")


@dataclass(frozen=True, slots=True)
class Bound:
    """A published bound of the path: how many perimeters of the obstacles that count.

    Attributes:
        over: Which count: those the ``m-line`` crosses, or those that meet the ``disc`` round the
            goal on whose rim the start is.
        each: Perimeters for each obstacle.
        crossing: More of them for each crossing of the m-line.
        minimum: More of them for each local minimum of the distance to the goal.
    """

    over: str
    each: float = 0.0
    crossing: float = 0.0
    minimum: float = 0.0


@dataclass(frozen=True, slots=True)
class Assembly:
    """A variant: which operation it takes for each part of the algorithm.

    Attributes:
        motion: How it goes to the goal.
        leave: Where it may leave an obstacle.
        nearer_than: What the leave point must be nearer to the goal than.
        by: How near it is taken to be: it itself, or what is free from there.
        research: How much of the boundary it must know before.
        direction: Which way round it goes.
        memory: What it does at earlier hit and leave points.
        gain: How much nearer at least [m].
        bound: Published bound of the path; None where there is none.
        source: Where it was published.
        summary: What it does, in a few words.
    """

    motion: str = STRAIGHT
    leave: str = ANYWHERE
    nearer_than: str = HIT
    by: str = FREE_WAY
    research: str = AT_ONCE
    direction: str = FIXED
    memory: str = NO_MEMORY
    gain: float = 0.0
    bound: Bound | None = None
    source: str = ""
    summary: str = ""

    @property
    def is_complete(self) -> bool:
        """Whether it reaches each goal that can be reached; else it may go in circles."""
        return self.nearer_than != NOTHING or self.leave == NEAREST_POINT


def read_assembly(value: Mapping[str, Any], name: str = "assembly") -> Assembly:
    """Return an assembly, checked.

    Args:
        value: Operations by name, as in ``variants.json``.
        name: What to call it in messages.

    Raises:
        Refused: It cannot work, or has a word that there is not; one sentence says why.
    """
    if not isinstance(value, Mapping):
        raise Refused(f"{name}: operations by their names are needed, not {value!r}")
    value = {key: word.strip() if isinstance(word, str) else word for key, word in value.items()}
    for key, word in value.items():
        if key in WORDS:
            _known(name, key, word, WORDS[key])
        else:
            _known(name, "key", key, KEYS)
    words = {key: value.get(key, choices[0]) for key, choices in WORDS.items()}
    gain = _number(value.get("gain", 0.0))
    if not 0 <= gain <= MOST_GAIN:
        raise Refused(f"{name}: gain is from 0 to {MOST_GAIN} m, not {value['gain']!r}")
    made = Assembly(
        **words,
        gain=gain,
        bound=_bound(name, value["bound"]) if "bound" in value else None,
        source=str(value.get("source", "")),
        summary=str(value.get("summary", "")),
    )
    for is_broken, why in _rules(made):
        if is_broken:
            raise Refused(f"{name}: {why}")
    return made


def _rules(made: Assembly) -> tuple[tuple[bool, str], ...]:
    """Return what makes an assembly one that cannot work, and why."""
    on_line, nearest = made.leave == LINE, made.leave == NEAREST_POINT
    tangent, range_, seen = (
        made.motion == TANGENT,
        made.by == FREE_RANGE,
        made.by == VISIBLE_POINTS,
    )
    return (
        (
            on_line != (made.motion == LINE),
            "leave and motion are both m-line or neither: hit points lie beside the line else",
        ),
        (
            made.nearer_than == LINE_POINTS and not on_line,
            "points of the m-line are passed only with leave m-line",
        ),
        (
            nearest != (made.research == CIRCUIT),
            "the nearest point is known after a whole circuit only, so one needs the other",
        ),
        (
            nearest and (made.memory == TURN_ROUND or made.by != FREE_WAY),
            "after a whole circuit it leaves at the nearest point, so by and memory have no use",
        ),
        (
            nearest and made.nearer_than != HIT,
            "the nearest point is nearer than the hit point, so nearer_than has no other word",
        ),
        (range_ and on_line, "a free range counts anywhere, not only on the m-line"),
        (
            (range_ or seen) and not made.gain,
            f"by {made.by} needs a gain above 0 m, or it may leave without end",
        ),
        (
            made.by == FREE_WAY and made.gain > 0,
            "a gain needs by free range or visible points: the last leave point may gain less",
        ),
        (
            tangent != seen,
            "motion tangent and by visible points need each other: both follow what is seen",
        ),
        (
            made.direction == SLIDING and not tangent,
            "direction sliding needs motion tangent: nothing slides along a wall before a hit else",
        ),
        (
            made.memory == TURN_ROUND and tangent,
            "motion tangent leaves at no point of the boundary that memory could know again",
        ),
        (
            made.nearer_than == NOTHING and (range_ or seen or made.memory == TURN_ROUND),
            "nearer_than nothing makes no progress that a gain or memory could be held against",
        ),
    )


def _bound(name: str, value: Any) -> Bound:
    if not isinstance(value, Mapping) or "over" not in value:
        raise Refused(f"{name}: a bound says over what, {' or '.join(OVER)}")
    for key, number in value.items():
        _known(name, "key of bound", key, ("over", *PERIMETERS))
        if key != "over" and not _number(number) >= 0:
            raise Refused(f"{name}: {key} of bound is a number of perimeters, not {number!r}")
    _known(name, "over", value["over"], OVER)
    return Bound(value["over"], **{k: _number(value[k]) for k in PERIMETERS if k in value})


def _number(value: Any) -> float:
    """Return a number, also of a text, as constraints compare them; NaN for what is none."""
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        return nan
    try:
        return float(value)
    except (ValueError, OverflowError):
        return nan


def _known(name: str, what: str, word: Any, choices: Sequence[str]) -> None:
    if word in choices:
        return
    near = get_close_matches(str(word), choices, 1)
    hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(choices)}"
    raise Refused(f"{name}: no {what} {word!r}; {hint}")


def read_variants(document: str, name: str = SHIPPED.name) -> dict[str, Assembly]:
    """Return the assemblies of a document by their names.

    Raises:
        Refused: It is no JSON of assemblies by names, or one of them is invalid.
    """
    try:
        found = json.loads(document)
    except ValueError as error:
        raise Refused(f"{name}: {error}") from None
    if not isinstance(found, Mapping):
        raise Refused(f"{name}: an object of assemblies by their names is needed")
    return {key: read_assembly(value, key) for key, value in found.items()}


@cache
def variants() -> dict[str, Assembly]:
    """Return the shipped assemblies by their names."""
    return read_variants(SHIPPED.read_text("utf-8"))


def assembly_of(text: str) -> Assembly:
    """Return the assembly of a shipped name, or of JSON with operations by their names.

    Raises:
        Refused: The JSON is none, or what it says cannot work.
        NotFound: There is no such name.
    """
    text = text.strip()
    if text.startswith("{"):
        try:
            return read_assembly(json.loads(text))
        except ValueError as error:
            raise Refused(f"assembly: {error}") from None
    if text not in variants():
        near = get_close_matches(text, variants(), 1)
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(variants())}"
        raise NotFound(f"no variant {text!r}; {hint}")
    return variants()[text]
