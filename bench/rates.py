"""Measures the jitter of a periodic execution context, beside a bare loop over deadlines.

Jitter is how much the time from one period to the next differs from a whole number of periods.
Both take turns, each in a process that does nothing else; what counts is the median, and the
value that 99 of 100 periods stay below.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from array import array
from collections.abc import Callable, Sequence
from itertools import pairwise
from random import Random

from bench.harness import Lines, Row, manager, medians
from rtkit.component.period import Period
from rtkit.deployment.actions import Action, ChangeState, Create, SetParameters
from rtkit.rtc.enums import Transition
from rtkit.tree.client import Tree

_RATES = {100: 100, 1000: 1000}
_ROUNDS = 9
_NS = 1_000_000_000
_NONE = 0.1
_COMPONENTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "components")
_OVERRUNS = 0.001
_SUM_IS = "a loop that sleeps a period after each tick, of up to 60 us"
_LOOP_IS = "a bare loop that sleeps until absolute deadlines, in a process of its own"


def _jitter(rate: int) -> Lines:
    pairs = _pairs(rate, _RATES[rate])
    for at, name in enumerate(("median", "99 of 100")):
        both = [(one[at], other[at]) for one, other in pairs]
        what = f"jitter of a period at {rate} Hz, {name}"
        yield Row(what, "us", *medians(both), 3.0, True, _LOOP_IS)
    missing = [(max(one[2], _NONE), max(other[2], _NONE)) for one, other in pairs]
    what = f"periods left out at {rate} Hz, of 1000"
    yield Row(what, "", *medians(missing), None, False, _LOOP_IS)


def _drift() -> Lines:
    for rate in _RATES:
        ours, summed = _drifts_us(rate)
        ratio = ours / summed if summed else 1.0
        what = f"drift of a context at {rate} Hz after an hour, simulated"
        yield Row(what, "us", ours, summed, ratio, 1.0, False, _SUM_IS)


PARTS = {"100Hz": lambda: _jitter(100), "1kHz": lambda: _jitter(1000), "drift": _drift}


def _drifts_us(rate: int) -> tuple[float, float]:
    """Return how far the last deadline of an hour is off, and how far summed periods are [us].

    Each tick takes some time, now and then more than a period; the clock is not a real one.
    """
    chance = Random(rate)
    period = Period(rate, 0)
    now_ns, summed_ns, ticks = 0, 0, 0
    while period.deadline_ns < 3600 * _NS:
        now_ns = max(now_ns, period.deadline_ns) + chance.randrange(60_000)
        if chance.random() < _OVERRUNS:
            now_ns += chance.randrange(3 * _NS // rate)
        ticks += 1
        summed_ns += round(1e6 / rate) * 1000 + chance.randrange(60_000)
        period.advance(now_ns)
    index = round(period.deadline_ns * rate / _NS)
    return abs(period.deadline_ns - index * _NS / rate) / 1e3, (
        summed_ns - ticks * _NS / rate
    ) / 1e3


Told = tuple[float, float, float]


def _pairs(rate: int, count: int) -> list[tuple[Told, Told]]:
    with tempfile.TemporaryDirectory(prefix="rtb") as folder, manager(_COMPONENTS) as tree:
        measure = _beat(tree, rate, count, os.path.join(folder, "stamps"))
        measure()
        return [(measure(), _bare(rate, count)) for _ in range(_ROUNDS)]


def _beat(tree: Tree, rate: int, count: int, result: str) -> Callable[[], Told]:
    rated = f"exec_cxt.periodic.rate={rate}"
    os.mkfifo(result)
    _do(
        tree,
        Create(f"Beat?instance_name=B&manager_name=beat&{rated}"),
        SetParameters("B", "default", {"result": result, "count": str(count)}),
    )

    def measure() -> Told:
        _do(tree, ChangeState("B", "0", Transition.ACTIVATE))
        with open(result, "rb") as file:
            stamps = array("q", file.read())
        _do(tree, ChangeState("B", "0", Transition.DEACTIVATE))
        return told(stamps, rate)

    return measure


def _do(tree: Tree, *actions: Action) -> None:
    for result in tree.apply(actions):
        result.raise_for_error()


def _bare(rate: int, count: int) -> Told:
    line = [sys.executable, "-m", "bench.rates", str(rate), str(count)]
    done = subprocess.run(line, capture_output=True, check=True)
    return told(array("q", done.stdout), rate)


def loop(rate: int, count: int) -> array[int]:
    """Take the time at absolute deadlines; what the context is compared with."""
    stamps = array("q")
    start = time.monotonic_ns()
    for index in range(count):
        delay = start + index * _NS // rate - time.monotonic_ns()
        if delay > 0:
            time.sleep(delay / _NS)
        stamps.append(time.monotonic_ns())
    return stamps


def told(stamps: Sequence[int], rate: int) -> Told:
    """Return median and 99th percentile of the jitter [us], and how many periods are missing."""
    period = _NS / rate
    spans = [b - a for a, b in pairwise(stamps)]
    jitter = sorted(abs(span - max(1, round(span / period)) * period) / 1e3 for span in spans)
    missing = (stamps[-1] - stamps[0]) / period - len(spans)
    at = min(len(jitter) - 1, len(jitter) * 99 // 100)
    return statistics.median(jitter), jitter[at], missing * 1000 / len(spans)


if __name__ == "__main__":
    sys.stdout.buffer.write(loop(int(sys.argv[1]), int(sys.argv[2])).tobytes())
