"""Measures the data path: a write inside a process, a round trip through two."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import timeit
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from bench.harness import Lines, Row, manager, medians, paired, pairs_of
from rtkit.component.codec import codec_for
from rtkit.component.geometry import Pose2D, TimedPose2D
from rtkit.component.port import InPort, OutPort
from rtkit.component.types import Time
from rtkit.deployment.actions import Action, ChangeState, Connect, Create, SetParameters
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree

_TRIPS = 200
_ROUNDS = 9
_SETS = 9
_CALLS = 20_000
_COMPONENTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "components")
_CALL_IS = "a method that calls a list of one callback"
_RAW_IS = "bare zenoh between two processes, same bytes, same kind of sockets and sessions"
_WAITING = {
    "dataport.subscription_type": "flush",
    "dataport.buffer.read.empty_policy": "block",
    "dataport.buffer.read.timeout": "1",
}


def _write() -> Lines:
    measured = paired(_write_us, _callbacks_us)
    what = "write to the buffer of an in port, same process"
    yield Row(f"{what}, ratio", "us", *measured, 5.0, True, _CALL_IS)
    yield Row(f"{what}, time", "us", *measured, 1.0, False, _CALL_IS)


def _trip() -> Lines:
    # How the kernel spreads processes over cores stays for their life: take fresh ones, often.
    pairs = [pair for _ in range(_SETS) for pair in _round_trips()]
    what = "round trip of a TimedPose2D through two processes"
    yield Row(what, "us", *medians(pairs), 1.4, True, _RAW_IS)


PARTS = {"write": _write, "trip": _trip}


def _round_trips() -> list[tuple[float, float]]:
    with (
        tempfile.TemporaryDirectory(prefix="rtb") as folder,
        manager(_COMPONENTS) as tree,
        _raw(folder) as raw,
    ):
        return pairs_of(_ping(tree, os.path.join(folder, "median")), raw, _ROUNDS)


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


def _ping(tree: Tree, result: str) -> Callable[[], float]:
    there = PortRef("P", "out"), PortRef("E", "into")
    back = PortRef("E", "out"), PortRef("P", "back")
    _do(
        tree,
        Create("Ping?instance_name=P&manager_name=p"),
        Create("Echo?instance_name=E&manager_name=e"),
        Connect(ConnectorProfile("there", "there", there, _WAITING)),
        Connect(ConnectorProfile("back", "back", back, _WAITING)),
        SetParameters("P", "default", {"result": result, "count": str(_TRIPS)}),
        ChangeState("E", "0", Transition.ACTIVATE),
    )

    def measure() -> float:
        _do(tree, ChangeState("P", "0", Transition.ACTIVATE))
        _do(tree, ChangeState("P", "0", Transition.DEACTIVATE))
        with open(result, encoding="utf-8") as file:
            return float(file.read())

    return measure


def _do(tree: Tree, *actions: Action) -> None:
    for result in tree.apply(actions):
        result.raise_for_error()


@contextmanager
def _raw(folder: str) -> Iterator[Callable[[], float]]:
    payload = codec_for(TimedPose2D).encode(TimedPose2D(Time(), Pose2D())).hex()
    ends = [os.path.join(folder, name) for name in ("a", "b")]
    start = [sys.executable, "-m", "bench.raw"]
    echo = subprocess.Popen([*start, "echo", ends[1], ends[0]])
    ping = subprocess.Popen(
        [*start, "ping", *ends], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert ping.stdin is not None
    assert ping.stdout is not None
    asked, answers = ping.stdin, ping.stdout

    def measure() -> float:
        asked.write(f"{_TRIPS} {payload}\n")
        asked.flush()
        return float(answers.readline())

    try:
        yield measure
    finally:
        ping.communicate()
        echo.wait(10)
