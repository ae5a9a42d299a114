"""Measures figure and floor in turns until the interval of the median ratio is tight.

The interval is distribution-free: the ratios of pairs, sorted, of which the k-th from below and the
k-th from above enclose the median with a confidence of at least 95 %, since the number of ratios
below the median is binomial (H. A. David and H. N. Nagaraja, Order Statistics, 3rd ed., 2003, §7.1;
J.-Y. Le Boudec, Performance Evaluation of Computer and Communication Systems, 2010, theorem 2.1).
It needs six pairs at least. Measuring stops as soon as the interval is tight, so the confidence is
a little lower than stated; the least number of pairs keeps that small.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

ROUNDS = 21
"""Pairs that are measured at least, after the warm-up."""
WARM_UP = 3
TIGHT = 0.05
"""Half of the width that an interval may have, as part of the median."""
MOST_TIMES = 5
"""How many times the least number of pairs are measured at most."""
EXTRA_S = 3.0
"""How long pairs are repeated beyond the least number [s]."""
_CONFIDENCE = 0.95

Measure: TypeAlias = Callable[[], float]
Pair: TypeAlias = tuple[float, float]


class Spread(NamedTuple):
    """How far single pairs lie apart.

    Attributes:
        pairs: How many pairs were measured.
        interval: Encloses the median ratio with a confidence of 95 %; None for fewer than six.
        figure: Lower and upper quartile of rtkit.
        floor: Lower and upper quartile of what is compared with.
    """

    pairs: int
    interval: tuple[float, float] | None
    figure: tuple[float, float]
    floor: tuple[float, float]

    def as_json(self) -> dict[str, object]:
        """Return the members of a row in JSON."""
        ends = {"interval": self.interval, "figure_quartiles": self.figure,
                "floor_quartiles": self.floor}  # fmt: skip
        rounded = {
            key: None if pair is None else [float(f"{end:.4g}") for end in pair]
            for key, pair in ends.items()
        }
        return {"pairs": self.pairs, **rounded}


class Measured(NamedTuple):
    """Medians of figure, floor and ratio; with their spread when they come from pairs."""

    figure: float
    floor: float
    ratio: float
    spread: Spread | None = None

    @property
    def is_noisy(self) -> bool:
        """Whether pairs were measured, and their interval is wide all the same."""
        interval = self.spread and self.spread.interval
        return interval is not None and not is_tight(interval, self.ratio)


def alone(figure: float, floor: float) -> Measured:
    """Return two values that were measured once, or are not a median of pairs."""
    return Measured(figure, floor, figure / floor if floor else 0.0)


def medians(pairs: Sequence[Pair]) -> Measured:
    """Return the medians of the first, of the second, and of their ratios; and the spread."""
    figures, floors = [a for a, _ in pairs], [b for _, b in pairs]
    ratios = _ratios(pairs)
    spread = Spread(len(pairs), interval(ratios), _quartiles(figures), _quartiles(floors))
    median = statistics.median
    return Measured(median(figures), median(floors), median(ratios), spread)


def paired(
    one: Measure, other: Measure, rounds: int = ROUNDS, *, warm_up: int = WARM_UP
) -> Measured:
    """Let two measurements take turns; return the medians of each and of their ratios."""
    return medians(pairs_of(one, other, rounds, warm_up))


def pairs_of(
    one: Measure, other: Measure, rounds: int = ROUNDS, warm_up: int = WARM_UP
) -> list[Pair]:
    """Let two measurements take turns, after a warm-up, until the ratio is known well."""
    for _ in range(warm_up):
        one()
        other()
    return until_tight(lambda: (one(), other()), rounds)


def until_tight(measure: Callable[[], Pair], rounds: int, extra_s: float = EXTRA_S) -> list[Pair]:
    """Repeat a pair until the interval of its ratio is tight, within bounds of number and time.

    Arguments:
        measure: Measures one pair, independent of the ones before.
        rounds: The least number of pairs; at most five times as many are measured.
        extra_s: How long pairs are repeated after that. A pair that would last longer does not
            begin.
    """
    begin = time.monotonic()
    pairs = [measure() for _ in range(rounds)]
    least = time.monotonic()
    while len(pairs) < MOST_TIMES * rounds:
        ratios = _ratios(pairs)
        now = interval(ratios)
        if now is not None and is_tight(now, statistics.median(ratios)):
            break
        each_s = (time.monotonic() - begin) / len(pairs)
        if time.monotonic() - least + each_s > extra_s:
            break
        pairs.append(measure())
    return pairs


def is_tight(ends: tuple[float, float], median: float) -> bool:
    """Whether an interval is no wider than five per cent of the median to each side."""
    return ends[1] - ends[0] <= 2 * TIGHT * median


def interval(values: Sequence[float]) -> tuple[float, float] | None:
    """Return what encloses the median with a confidence of at least 95 %; None for too few."""
    count = len(values)
    rank, below = 0, 0.0
    while (below := below + math.comb(count, rank) / 2**count) <= (1 - _CONFIDENCE) / 2:
        rank += 1
    if not rank:
        return None
    ordered = sorted(values)
    return ordered[rank - 1], ordered[-rank]


def _ratios(pairs: Sequence[Pair]) -> list[float]:
    return [one / other for one, other in pairs]


def _quartiles(values: Sequence[float]) -> tuple[float, float]:
    if len(values) < 2:
        return values[0], values[0]
    lower, _, upper = statistics.quantiles(values, n=4, method="inclusive")
    return lower, upper
