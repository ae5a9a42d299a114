"""Measures the values of a stream: rate, intervals, sizes, and age by time stamp."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import NamedTuple

from rtkit.component.types import Time
from rtkit.component.values.type_layout import StructLayout, layout_of
from rtkit.probe.tap import Arrival
from rtkit.recording.time_stamps import stamp_of

_KEPT = 100_000
"""Number of latest values that percentiles are computed of."""

Stamp = Callable[[bytes], "int | None"]
Number = Callable[[bytes], float]
NO_NUMBERS: Mapping[str, Number] = {}


class Spread(NamedTuple):
    """Distribution of one quantity; `deviation` is the standard deviation."""

    mean: float
    deviation: float
    least: float
    median: float
    p99: float
    most: float


class Summary(NamedTuple):
    """Statistics of a stream.

    Attributes:
        rate_hz: Values per second, 0 for fewer than two.
        interval_s: Between arrivals [s]; None for fewer than two values.
        size_bytes: Of the values in CDR; None without any.
        latency_s: From time stamp to arrival [s]; None where values have no stamp.
        fields: Of the numbers in the selected fields.
    """

    values: int
    rate_hz: float
    bytes_per_s: float
    interval_s: Spread | None
    size_bytes: Spread | None
    latency_s: Spread | None
    fields: Mapping[str, Spread | None] = {}


class Stats:
    """Computes statistics of one stream's arrivals in bounded memory."""

    def __init__(
        self, stamp: Stamp, numbers: Mapping[str, Number] = NO_NUMBERS, ahead_ns: int = 0
    ) -> None:
        """Begin; time stamps are of a clock that is so much ahead of the one here [ns]."""
        self._stamp = stamp
        self._ahead_ns = ahead_ns
        self._numbers = numbers
        self._fields: dict[str, deque[float]] = {name: deque(maxlen=_KEPT) for name in numbers}
        self._first_ns = self._last_ns = 0
        self._bytes = 0
        self.count = 0
        self._intervals: deque[float] = deque(maxlen=_KEPT)
        self._sizes: deque[float] = deque(maxlen=_KEPT)
        self._latencies: deque[float] = deque(maxlen=_KEPT)

    def take(self, arrival: Arrival) -> None:
        """Count one value."""
        size = len(arrival.payload)
        if self.count:
            self._intervals.append((arrival.time_ns - self._last_ns) * 1e-9)
        else:
            self._first_ns = arrival.time_ns
        self._last_ns = arrival.time_ns
        self.count += 1
        self._bytes += size
        self._sizes.append(size)
        stamp = self._stamp(arrival.payload)
        if stamp:
            self._latencies.append((arrival.time_ns + self._ahead_ns - stamp) * 1e-9)
        for name, number in self._numbers.items():
            value = number(arrival.payload)
            if math.isfinite(value):
                self._fields[name].append(value)

    def summary(self) -> Summary:
        """Return the statistics of the values so far."""
        span_s = (self._last_ns - self._first_ns) * 1e-9
        steps = self.count - 1
        rate = steps / span_s if steps > 0 and span_s > 0 else 0.0
        mean_size = self._bytes / self.count if self.count else 0.0
        return Summary(
            self.count,
            rate,
            rate * mean_size,
            _spread(self._intervals),
            _spread(self._sizes),
            _spread(self._latencies),
            {name: _spread(values) for name, values in self._fields.items()},
        )


def stamp_reader(cls: type) -> Stamp:
    """Return a reader of a CDR value's time stamp, Unix time [ns]; None for a type without one."""
    if cls is bytes:
        return lambda _payload: None
    fields = layout_of(cls).fields
    head = fields[0][1] if fields else None
    if not isinstance(head, StructLayout) or head.cls is not Time:
        return lambda _payload: None

    return stamp_of


def _spread(values: deque[float]) -> Spread | None:
    if not values:
        return None
    ranked = sorted(values)
    count = len(ranked)
    mean = math.fsum(ranked) / count
    deviation = math.sqrt(math.fsum((value - mean) ** 2 for value in ranked) / count)
    p99 = ranked[min(count - 1, math.ceil(0.99 * count) - 1)]
    return Spread(mean, deviation, ranked[0], ranked[count // 2], p99, ranked[-1])
