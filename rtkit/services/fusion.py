"""Fusion of markers: which of them are one thing, and where it is, given how sure each one is.

Each sighting of a thing is weighted by the inverse of its covariance, so the order does not matter.
It is of the nearest thing of its type, as far as its Mahalanobis distance is within the gate; no
two sightings by one sensor at one time are of one thing. A thing may drift: the longer ago it was
seen, the less sure its place. Pure: the time is handed in, frames are those of the caller.

Source: `property-service` reference, section 9.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from typing import Any, NamedTuple

from rtkit import Marker, PropertyError
from rtkit.services.frames import Rows, applied

_TURNS = 3
"""From this number of a pose on they are angles."""


class Estimate(NamedTuple):
    """Location [m, rad] with its covariance."""

    mean: tuple[float, ...]
    covariance: Rows


def inverse(rows: Sequence[Sequence[float]]) -> Rows:
    """Return the inverse of a symmetric matrix all of whose eigenvalues are above 0.

    Raises:
        PropertyError: ``bad-value``: it is another one.
    """
    size = len(rows)
    work = [[*(rows[max(i, j)][min(i, j)] for j in range(size)),
             *(float(i == j) for j in range(size))] for i in range(size)]  # fmt: skip
    for i in range(size):  # eliminates column by column
        pivot = work[i][i]
        if not 0.0 < pivot < math.inf:
            raise PropertyError("bad-value", "a covariance is symmetric and above 0")
        work[i] = [each / pivot for each in work[i]]
        for j in range(size):
            if j != i and work[j][i]:
                work[j] = [a - work[j][i] * b for a, b in zip(work[j], work[i], strict=True)]
    return tuple(
        tuple((work[i][size + j] + work[j][size + i]) / 2 for j in range(size)) for i in range(size)
    )


def fuse(one: Estimate, other: Estimate) -> Estimate:
    """Return what two estimates of one location tell together; one may have fewer numbers."""
    wide, narrow = (one, other) if len(one.mean) >= len(other.mean) else (other, one)
    size, seen = len(wide.mean), len(narrow.mean)
    information = inverse(narrow.covariance)
    summed = [list(row) for row in inverse(wide.covariance)]
    for i in range(seen):
        for j in range(seen):
            summed[i][j] += information[i][j]
    apart = difference(narrow.mean, wide.mean)
    pull = applied(information, apart) + (0.0,) * (size - seen)
    covariance = inverse(summed)
    return Estimate(_moved(wide.mean, applied(covariance, pull)), covariance)


def distance(
    one: Estimate, other: Estimate, drift: float = 0.0, bound: float = math.inf
) -> float | None:
    """Return the Mahalanobis distance of two estimates, of the numbers that both have.

    Args:
        one: An estimate.
        other: Another one.
        drift: Variance to be added.
        bound: None is returned for more than this.
    """
    far = one.mean[0] - other.mean[0]
    if far * far > bound * bound * (one.covariance[0][0] + other.covariance[0][0] + drift):
        return None  # as nearly all are
    apart = difference(one.mean, other.mean)
    size = len(apart)
    spreads = drifted(one, drift).covariance, other.covariance
    both = [[spreads[0][i][j] + spreads[1][i][j] for j in range(size)] for i in range(size)]
    square = sum(a * b for a, b in zip(apart, applied(inverse(both), apart), strict=True))
    return math.sqrt(square) if square <= bound * bound else None


def drifted(estimate: Estimate, variance: float) -> Estimate:
    """Return what is known after the thing may have moved by a variance."""
    if variance <= 0.0:
        return estimate
    rows = enumerate(estimate.covariance)
    wider = (tuple(each + (i == j) * variance for j, each in enumerate(row)) for i, row in rows)
    return estimate._replace(covariance=tuple(wider))


def difference(one: Sequence[float], other: Sequence[float]) -> tuple[float, ...]:
    """Return by how much locations differ, in the numbers that both have; angles the short way."""
    pairs = enumerate(zip(one, other, strict=False))
    return tuple(math.remainder(a - b, math.tau) if i >= _TURNS else a - b for i, (a, b) in pairs)


def _moved(mean: Sequence[float], step: Sequence[float]) -> tuple[float, ...]:
    to = enumerate(a + b for a, b in zip(mean, step, strict=True))
    return tuple(math.remainder(each, math.tau) if i >= _TURNS else each for i, each in to)


@dataclass(frozen=True)
class Seen:
    """One look at a thing, or all looks of another model together.

    Attributes:
        kind: The type of the marker.
        key: The sensor, and by what it knows the thing; that is empty if it does not.
        time: When it was seen last [s since 1970].
        doubt: Probability that there is nothing of the kind; None if nobody said.
        count: How many looks it stands for.
    """

    marker: Marker
    kind: str
    key: tuple[str, str]
    estimate: Estimate
    time: float
    doubt: float | None
    count: int


@dataclass
class Track:
    """Thing that was seen, with all that is known of it."""

    id: str
    seen: Seen
    keys: dict[str, str] = field(default_factory=dict)
    _shown: tuple[Seen, Marker] | None = None

    def marker(self, frame: str) -> Marker:
        """Return it as a marker; feature ``count`` says how often it was seen."""
        if self._shown is None or self._shown[0] is not self.seen:
            self._shown = (self.seen, self._marker(frame))
        return self._shown[1]

    def _marker(self, frame: str) -> Marker:
        seen = self.seen
        spread = seen.estimate.covariance
        first = spread[0][0]
        is_even = all(
            math.isclose(each, first * (i == j), rel_tol=1e-9, abs_tol=1e-12 * first)
            for i, row in enumerate(spread)
            for j, each in enumerate(row)
        )
        about: dict[str, Any] = {"variance": first} if is_even else {"covariance": spread}
        if seen.doubt is not None:
            about["confidence"] = 1.0 - seen.doubt
        return seen.marker.with_(
            location=seen.estimate.mean,
            id=self.id,
            time=seen.time,
            source=None,
            frame=frame,
            count=seen.count,
            **about,
        )


class MarkerFusion:
    """Things that markers tell of, in one frame.

    Args:
        variance: Of each coordinate of a marker that tells none [m², rad²].
        gate: Mahalanobis distance up to which a marker may be of a thing.
        drift: Growth of the variance of the place of a thing [m²/s, rad²/s].
        most: How many things are kept; those not seen for longest go first.
        frame: In which all is.

    Attributes:
        count: How many markers were seen.
    """

    def __init__(
        self,
        variance: float = 0.01,
        gate: float = 3.4,
        drift: float = 0.0,
        most: int = 1000,
        frame: str = "world",
    ) -> None:
        self.frame, self.count = frame, 0
        self.variance, self.gate, self.drift, self.most = variance, gate, drift, most
        self._things: dict[str, Track] = {}
        self._numbers: dict[str, int] = {}
        self._merged: dict[tuple[str, str], Seen] = {}

    def observe(self, markers: Iterable[Marker], now: float) -> None:
        """Take what was seen, all of it or nothing.

        Raises:
            PropertyError: ``bad-value``: a marker has no location, or no covariance that is one.
        """
        looks = sorted((self._look(each, now) for each in markers), key=_of_one_look)
        self.count += len(looks)
        for _, group in groupby(looks, _of_one_look):
            self._take(list(group))
        for thing in sorted(self._things.values(), key=lambda each: -each.seen.time)[self.most :]:
            del self._things[thing.id]

    def merge(self, model: str, markers: Iterable[Marker], now: float) -> None:
        """Take what another model has seen by itself, but for what is known from before.

        Raises:
            PropertyError: ``bad-value``: as `observe`.
        """
        reported = [self._look(each.with_(source=model), now) for each in markers]
        news = [new for each in reported if (new := self._news(each)) is not None]
        self._take(news)
        self._merged |= {each.key: each for each in reported}

    def _news(self, report: Seen) -> Seen | None:
        """Return what a model tells of a thing beyond what it told the last time."""
        last = self._merged.get(report.key)
        if last is None or len(last.estimate.mean) != len(report.estimate.mean):
            return report
        count = report.count - last.count
        if count <= 0:
            return None if report.estimate == last.estimate else report
        mean, covariance = report.estimate
        known = inverse(last.estimate.covariance)
        pairs = zip(inverse(covariance), known, strict=True)
        try:
            spread = inverse([[a - b for a, b in zip(*rows, strict=True)] for rows in pairs])
            step = applied(spread, applied(known, difference(mean, last.estimate.mean)))
            estimate = Estimate(_moved(mean, step), spread)
        except PropertyError:  # it has drifted: new is the share of what was seen since
            estimate = _weighted(report.estimate, count / report.count)
        return replace(report, estimate=estimate, count=count)

    def things(self) -> Iterator[Marker]:
        """Yield all things as markers, in the order in which they came."""
        return (each.marker(self.frame) for each in self._things.values())

    def forget(self, before: float) -> None:
        """Forget the things that were not seen since a time [s since 1970]."""
        for thing in [each for each in self._things.values() if each.seen.time < before]:
            del self._things[thing.id]
        self._merged = {key: each for key, each in self._merged.items() if each.time >= before}

    def _look(self, marker: Marker, now: float) -> Seen:
        mean = marker.location
        if mean is None or not all(map(math.isfinite, mean)):
            raise PropertyError("bad-value", "a marker with a location is needed")
        variance = self.variance if marker.variance is None else marker.variance
        rows = marker.covariance or tuple(
            tuple(variance * (i == j) for j in range(len(mean))) for i in range(len(mean))
        )
        sure = marker.confidence
        if sure is not None and not 0.0 < sure <= 1.0:
            raise PropertyError("bad-value", "a confidence is above 0, and 1 at most")
        inverse(rows)  # refuses what is none
        estimate, count = Estimate(mean, rows), marker.features.get("count", 1)
        if "count" not in marker.features and sure is not None:  # else it is weighted already
            estimate = _weighted(estimate, sure)
        time = now if marker.time is None else marker.time
        time = now if time > now else time  # a clock that is ahead would never let it age
        if not math.isfinite(time) or not isinstance(count, int) or count < 1:
            raise PropertyError("bad-value", "a time is finite, and a count 1 at least")
        doubt = None if sure is None else 1.0 - sure
        key = marker.source, marker.id
        return Seen(marker, marker.type, key, estimate, time, doubt, count)

    def _take(self, group: list[Seen]) -> None:
        """Give each look of one sensor at one time the thing that it is of, nearest ones first."""
        pairs = []
        for number, look in enumerate(group):
            for thing in self._things.values():
                far = self._distance(thing, look)
                if far is not None:
                    pairs.append((far, number, thing))
        things: dict[int, Track] = {}
        given: set[str] = set()
        for _, number, thing in sorted(pairs, key=lambda each: each[:2]):
            if number not in things and thing.id not in given:
                things[number] = thing
                given.add(thing.id)
        for number, look in enumerate(group):
            self._join(things.get(number), look)

    def _distance(self, thing: Track, look: Seen) -> float | None:
        """Return how far a look is from a thing, -1 if it is told to be of it; None for too far."""
        source, id = look.key
        if thing.seen.kind != look.kind:
            return None
        known = thing.keys.get(source)
        if known is not None and id:
            return -1.0 if known == id else None
        drift = self.drift * abs(thing.seen.time - look.time)
        return distance(thing.seen.estimate, look.estimate, drift, self.gate)

    def _join(self, thing: Track | None, look: Seen) -> None:
        source, id = look.key
        keys = {source: id} if id else {}
        if thing is None:
            name = self._name(look.marker)
            self._things[name] = Track(name, look, keys)
            return
        thing.keys |= keys
        before = thing.seen
        late = max(before.time, look.time)
        known = drifted(before.estimate, self.drift * (late - before.time))
        new = drifted(look.estimate, self.drift * (late - look.time))
        has_moved = distance(known, new, bound=self.gate) is None
        is_later = look.time >= before.time
        doubts = [each for each in (before.doubt, look.doubt) if each is not None]
        thing.seen = Seen(
            _together(before.marker, look.marker) if is_later else before.marker,
            before.kind,
            before.key,
            (new if is_later else known) if has_moved else fuse(known, new),
            late,
            math.prod(doubts) if doubts else None,
            before.count + look.count,
        )

    def _name(self, marker: Marker) -> str:
        """Return a name that no thing has had: the marker's own, or its type with a number."""
        name, kind = marker.id, marker.type or "thing"
        while not name or name in self._things:
            self._numbers[kind] = number = self._numbers.get(kind, 0) + 1
            name = f"{kind}-{number}"
        return name


def _weighted(estimate: Estimate, weight: float) -> Estimate:
    """Return an estimate that counts only by a weight."""
    rows = tuple(tuple(each / weight for each in row) for row in estimate.covariance)
    return estimate._replace(covariance=rows)


def _of_one_look(seen: Seen) -> tuple[float, str]:
    return seen.time, seen.marker.source


def _together(old: Marker, new: Marker) -> Marker:
    """Return the features of both markers, those of the new one where both have some."""
    more = {name: getattr(old, name) for name in ("name", "size") if not getattr(new, name)}
    kept = {name: each for name, each in old.features.items() if name not in new.features}
    return new.with_(**more, **kept)
