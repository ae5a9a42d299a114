"""Measures how late the cycles of a periodic execution context begin, beside a bare loop.

Late is a cycle by the time from its deadline to its begin. A context and a loop over the same
deadlines take turns, each in a process that does nothing else; at rest, beside as many programs
that compute as there are processors, and there with a priority before them. The cycles of all
turns count together: half of them, 99 of 100, 999 of 1000 were at most so late, and the latest.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from array import array
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from random import Random

from bench.harness import Lines, Missing, Row, manager
from bench.pairs import Measured
from rtkit.component.contexts.period import Period
from rtkit.deployment.actions import Action, ChangeState, Create, SetParameters
from rtkit.rtc.enums import Transition
from rtkit.tree.client import Tree

_COUNTS = {100: 300, 1000: 1000}
"""Cycles of a turn, by rate."""
_ROUNDS = 9
_NS = 1_000_000_000
_PRIORITY = 20
_COMPONENTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "components")
_OVERRUNS = 0.001
_SUM_IS = "a loop that sleeps a period after each tick, of up to 60 us"
_LOOP_IS = "a bare loop that sleeps until absolute deadlines, in a process of its own"
_BURN = "while True: pass"
_PERCENTILES = {"median": 0.5, "99 of 100": 0.99, "999 of 1000": 0.999, "the latest": 1.0}
_TARGET = 3.0


def _lateness(rate: int, *, is_loaded: bool = False, has_priority: bool = False) -> Lines:
    where = ", beside programs that compute" * is_loaded + ", with a priority" * has_priority
    why = _refusal() if has_priority else ""
    if why:
        yield Missing(f"lateness of a cycle at {rate} Hz{where}", why)
        return
    with _load(os.cpu_count() or 1 if is_loaded else 0):
        ours, bare = _turns(rate, has_priority=has_priority)
    both = [sorted(late for turn in turns for late in turn[1:]) for turns in (ours, bare)]
    floor_is = _LOOP_IS + ", with that priority" * has_priority
    for name, share in _PERCENTILES.items():
        figure, floor = (each[min(len(each) - 1, int(len(each) * share))] / 1e3 for each in both)
        target = None if share == 1.0 else _TARGET
        what = f"lateness of a cycle at {rate} Hz{where}, {name}"
        yield Row(
            what, "us", Measured(figure, floor, figure / max(floor, 1e-3)), target, True, floor_is
        )
    figure, floor = (
        sum(turn[0] for turn in turns) * 1000 / sum(len(turn) - 1 + turn[0] for turn in turns)
        for turns in (ours, bare)
    )
    what = f"periods missed at {rate} Hz{where}, of 1000"
    yield Row(
        what, "", Measured(figure, floor, figure / floor if floor else 1.0), None, False, floor_is
    )


def _drift() -> Lines:
    for rate in _COUNTS:
        ours, summed = _drifts_us(rate)
        ratio = ours / summed if summed else 1.0
        what = f"drift of a context at {rate} Hz after an hour, simulated"
        yield Row(what, "us", Measured(ours, summed, ratio), 1.0, False, _SUM_IS)


PARTS = {
    "100Hz": lambda: _lateness(100),
    "1kHz": lambda: _lateness(1000),
    "100Hz-load": lambda: _lateness(100, is_loaded=True),
    "1kHz-load": lambda: _lateness(1000, is_loaded=True),
    "100Hz-priority": lambda: _lateness(100, is_loaded=True, has_priority=True),
    "1kHz-priority": lambda: _lateness(1000, is_loaded=True, has_priority=True),
    "drift": _drift,
}


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


Turn = Sequence[int]
"""How many periods were missed, and how late each cycle began [ns]."""


def _turns(rate: int, *, has_priority: bool) -> tuple[list[Turn], list[Turn]]:
    count = _COUNTS[rate]
    ours: list[Turn] = []
    bare: list[Turn] = []
    with tempfile.TemporaryDirectory(prefix="rtb") as folder, manager(_COMPONENTS) as tree:
        options = f"exec_cxt.periodic.rate={rate}"
        options += f"&exec_cxt.priority={_PRIORITY}" * has_priority
        measure = _beat(tree, options, count, os.path.join(folder, "turn"))
        measure()
        for _ in range(_ROUNDS):
            ours.append(measure())
            bare.append(_bare(rate, count, _PRIORITY * has_priority))
    return ours, bare


def _beat(tree: Tree, options: str, count: int, result: str) -> Callable[[], Turn]:
    os.mkfifo(result)
    _do(
        tree,
        Create(f"Beat?instance_name=B&manager_name=beat&{options}"),
        SetParameters("B", "default", {"result": result, "count": str(count)}),
    )

    def measure() -> Turn:
        _do(tree, ChangeState("B", "0", Transition.ACTIVATE))
        with open(result, "rb") as file:
            turn = array("q", file.read())
        _do(tree, ChangeState("B", "0", Transition.DEACTIVATE))
        return turn

    return measure


def _do(tree: Tree, *actions: Action) -> None:
    for result in tree.apply(actions):
        result.raise_for_error()


def _bare(rate: int, count: int, priority: int) -> Turn:
    line = [sys.executable, "-m", "bench.rates", str(rate), str(count), str(priority)]
    done = subprocess.run(line, capture_output=True, check=True)
    return array("q", done.stdout)


def loop(rate: int, count: int) -> array[int]:
    """Sleep until absolute deadlines; what the context is compared with.

    A deadline that has passed when the next one has, too, is missed.
    """
    turn = array("q", [0])
    start, index = time.monotonic_ns(), 0
    while len(turn) <= count:
        deadline = start + index * _NS // rate
        delay = deadline - time.monotonic_ns()
        if delay > 0:
            time.sleep(delay / _NS)
        turn.append(time.monotonic_ns() - deadline)
        last = (time.monotonic_ns() - start) * rate // _NS
        turn[0] += max(0, last - index - 1)
        index = max(index + 1, last)
    return turn


@contextmanager
def _load(count: int) -> Iterator[None]:
    """Have so many programs compute."""
    programs = [subprocess.Popen([sys.executable, "-c", _BURN]) for _ in range(count)]
    try:
        yield
    finally:
        for each in programs:
            each.kill()
            each.wait()


def _refusal() -> str:
    """Return why no program of this user can have a priority; empty if it can."""
    line = [sys.executable, "-m", "bench.rates", "1000", "1", str(_PRIORITY)]
    done = subprocess.run(line, capture_output=True, text=True, errors="replace", check=False)
    return done.stderr.strip().rpartition("\n")[2] if done.returncode else ""


if __name__ == "__main__":
    if int(sys.argv[3]):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(int(sys.argv[3])))
    sys.stdout.buffer.write(loop(int(sys.argv[1]), int(sys.argv[2])).tobytes())
