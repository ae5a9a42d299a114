"""Measures the data path: a write inside a process, a round trip through two."""

from __future__ import annotations

import importlib.util
import os
import statistics
import subprocess
import sys
import tempfile
import timeit
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from typing import NamedTuple, TypeAlias

from bench.harness import Lines, Missing, Row, manager
from bench.pairs import Measured, Pair, medians, paired, until_tight
from bench.placement import pin
from bench.raw import KINDS
from rtkit.component.geometry import Pose2D, TimedPose2D
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.out_port import OutPort
from rtkit.component.types import Time
from rtkit.component.values.codec import codec_for
from rtkit.deployment.actions import Action, ChangeState, Connect, Create, Load, SetParameters
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree

_ROUNDS = 3
_SETS = 7
_EXTRA_S = 15.0
_CALLS = 20_000
COMPONENTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "components")
_CALL_IS = "a method that calls a list of one callback"
_RAW_IS = "the same octets between two processes"
_WAITING = {
    "dataport.subscription_type": "flush",
    "dataport.buffer.read.empty_policy": "block",
    "dataport.buffer.read.timeout": "1",
}


def _write() -> Lines:
    measured = paired(_write_us, _callbacks_us)
    what = "write to the buffer of an in port, same process"
    yield Row(f"{what}, ratio", "us", measured, 5.0, True, _CALL_IS)
    yield Row(f"{what}, time", "us", measured, 1.0, False, _CALL_IS)


def _trip() -> Lines:
    what = "round trip of a TimedPose2D through two processes"
    for kind, target in (("socket", 1.5), ("zenoh", None)):
        yield from by_placement(
            f"{what}, beside {kind}", SMALL, partial(raw, kind), _floor_is(kind), target
        )


def _image() -> Lines:
    what = f"round trip of an image of {IMAGE.size // 1_000_000} MB through two processes"
    # It imports the second one without declaring it.
    absent = [
        each for each in ("iceoryx2", "flatbuffers") if importlib.util.find_spec(each) is None
    ]
    if absent:
        yield Missing(what, f"pip install {' '.join(absent)}")
        return
    kind = "iceoryx2"
    yield from by_placement(what, IMAGE, partial(raw, kind), _floor_is(kind), 1.2)


def _floor_is(kind: str) -> str:
    return f"{KINDS[kind]}, {_RAW_IS}"


PARTS = {"write": _write, "trip": _trip, "image": _image}


class Trip(NamedTuple):
    """What travels: its module, types of both ends, size of a value [bytes], how many at a time."""

    module: str
    ping: str
    echo: str
    size: int
    trips: int


SMALL = Trip(
    "Ping", "Ping", "Echo", len(codec_for(TimedPose2D).encode(TimedPose2D(Time(), Pose2D()))), 200
)
IMAGE = Trip("Images", "ImagePing", "ImageEcho", 1_000_000, 100)


Floor: TypeAlias = Callable[
    [str, Trip], AbstractContextManager[tuple[Callable[[], float], tuple[int, int]]]
]
"""Runs two ends with a folder of theirs; gives what measures a round trip, and their pids."""


def by_placement(what: str, trip: Trip, floor: Floor, floor_is: str, target: float | None) -> Lines:
    """Measure both pairs of ends at the same processors: one, then two.

    Where the scheduler puts them decides the figure more than all else, and it puts each pair
    where it likes.
    """
    yield from on_each_placement(
        what, lambda processors: round_trip(trip, floor, processors), floor_is, target
    )


def on_each_placement(
    what: str,
    measure: Callable[[Sequence[int]], Measured],
    floor_is: str,
    target: float | None,
) -> Lines:
    """Measure with the ends of both on one processor, then on two."""
    allowed = sorted(os.sched_getaffinity(0))
    for name, processors in (("one processor", allowed[:1] * 2), ("two processors", allowed[:2])):
        if len(processors) < 2:
            yield Missing(f"{what}, on {name}", "only one processor may be used")
            continue
        measured = measure(processors)
        placement = f"ends of both on processors {processors[0]} and {processors[1]}"
        yield Row(f"{what}, on {name}", "us", measured, target, True, floor_is, placement)


def round_trip(trip: Trip, floor: Floor, processors: Sequence[int]) -> Measured:
    """Measure a round trip of rtkit beside another, both with their ends on two processors.

    Each pair is one of medians that fresh processes take. The processors may be the same.
    """

    def in_fresh_processes() -> Pair:
        with (
            tempfile.TemporaryDirectory(prefix="rtb") as folder,
            manager(COMPONENTS) as tree,
            floor(folder, trip) as (bare, bare_pids),
        ):
            ours = ping(tree, trip, os.path.join(folder, "median"))
            ours(), bare()  # a warm-up, after which all threads are there
            pids = {process.name: process.pid for process in tree.snapshot().processes}
            for ends in (pids["p"], pids["e"]), bare_pids:
                for pid, to in zip(ends, processors, strict=True):
                    pin(pid, to)
            pairs = [(ours(), bare()) for _ in range(_ROUNDS)]
        return statistics.median(a for a, _ in pairs), statistics.median(b for _, b in pairs)

    return medians(until_tight(in_fresh_processes, _SETS, _EXTRA_S))


def _write_us() -> float:
    out = OutPort(TimedPose2D, "out")
    into = InPort(TimedPose2D, "in")
    wire = ConnectorProfile("c", "c", (PortRef("A", "out"), PortRef("B", "in")), {})
    out.attach("c", into.open(wire))
    value = TimedPose2D(Time(), Pose2D())
    return _each_us(lambda: out.write(value), {"out": out, "value": value}, "out.write(value)")


class _Caller:
    def __init__(self, callback: Callable[[object], object]) -> None:
        self._callbacks = [callback]

    def write(self, value: object) -> None:
        for callback in self._callbacks:
            callback(value)


def _callbacks_us() -> float:
    def take(value: object) -> None:
        return None

    caller = _Caller(take)
    return _each_us(lambda: None, {"out": caller, "value": 1}, "out.write(value)")


def _each_us(check: Callable[[], object], names: dict[str, object], call: str) -> float:
    check()
    return timeit.timeit(call, globals=names, number=_CALLS) / _CALLS * 1e6


def ping(tree: Tree, trip: Trip, result: str, mark: str = "") -> Callable[[], float]:
    """Make both ends, in slaves ``p`` and ``e``; return what measures a round trip.

    With a mark, which their names end with, there may be several pairs in one manager.
    """
    one, other = f"P{mark}", f"E{mark}"
    there = PortRef(one, "out"), PortRef(other, "into")
    back = PortRef(other, "out"), PortRef(one, "back")
    _do(
        tree,
        Load(f"{trip.module}.py", f"{trip.module}Init"),
        Create(f"{trip.ping}?instance_name={one}&manager_name={one.lower()}"),
        Create(f"{trip.echo}?instance_name={other}&manager_name={other.lower()}"),
        Connect(ConnectorProfile(f"there{mark}", "there", there, _WAITING)),
        Connect(ConnectorProfile(f"back{mark}", "back", back, _WAITING)),
        SetParameters(one, "default", {"result": result, "count": str(trip.trips)}),
        ChangeState(other, "0", Transition.ACTIVATE),
    )

    def measure() -> float:
        _do(tree, ChangeState(one, "0", Transition.ACTIVATE))
        _do(tree, ChangeState(one, "0", Transition.DEACTIVATE))
        with open(result, encoding="utf-8") as file:
            return float(file.read())

    return measure


def _do(tree: Tree, *actions: Action) -> None:
    for result in tree.apply(actions):
        result.raise_for_error()


@contextmanager
def raw(
    kind: str, folder: str, trip: Trip, python: str = sys.executable
) -> Iterator[tuple[Callable[[], float], tuple[int, int]]]:
    """Run two bare ends; yield what measures a round trip of theirs, and their process ids."""

    def start(role: str) -> subprocess.Popen[str]:
        words = [python, "-m", "bench.raw", kind, role, folder, str(trip.size)]
        pipe = subprocess.PIPE
        return subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True)

    echo = start("echo")
    assert echo.stdout is not None
    echo.stdout.readline()  # it is there
    ping = start("ping")
    assert ping.stdin is not None
    assert ping.stdout is not None
    asked, answers = ping.stdin, ping.stdout

    def measure() -> float:
        asked.write(f"{trip.trips}\n")
        asked.flush()
        return float(answers.readline())

    try:
        yield measure, (ping.pid, echo.pid)
    finally:
        ping.communicate()
        echo.communicate(timeout=10)
