"""Measures streams between processes: one writer, one to sixteen readers, no value lost.

Told is the time for each value and reader, and the processor time of all processes for it. The
floor is a bare socket to each reader, with the same octets.
"""

from __future__ import annotations

import multiprocessing
import os
import socket
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import TypeAlias

from bench.harness import Lines, Row, manager
from bench.pairs import medians
from rtkit.deployment.actions import Action, ChangeState, Connect, Create, Load, SetParameters
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree

_COMPONENTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "components")
_SIZES = {
    "64 B": (64, 4000),
    "4 kB": (4096, 4000),
    "1 MB": (1_000_000, 100),
    "8 MB": (8_000_000, 20),
}
_READERS = (1, 4, 16)
_ROUNDS = 5
_PATIENCE_S = 60.0
_PIECE = 1 << 16
_FLOOR_IS = "a bare socket to each reader, with the same octets"
_LOSSLESS = {
    "dataport.subscription_type": "flush",
    "dataport.inport.buffer.write.full_policy": "block",
    "dataport.inport.buffer.write.timeout": "60",
    "dataport.inport.buffer.read.empty_policy": "block",
    "dataport.inport.buffer.read.timeout": "1",
}
Cost: TypeAlias = tuple[float, float]
"""Time and processor time of a value at one reader [us]."""


def _streams(name: str) -> Lines:
    size, count = _SIZES[name]
    for readers in _READERS:
        with manager(_COMPONENTS) as tree, tempfile.TemporaryDirectory(prefix="rtb") as folder:
            ours = _Stream(tree, folder, readers, size, count)
            costs = [(ours.measure(), _bare(readers, size, count)) for _ in range(_ROUNDS + 1)][1:]
        what = f"stream of {name} to {readers} reader{'s' * (readers > 1)}, for each"
        for index, part in enumerate(("", ", processor")):
            pairs = [(one[index], other[index]) for one, other in costs]
            yield Row(f"{what}{part}", "us", medians(pairs), None, True, _FLOOR_IS)


PARTS = {name.replace(" ", ""): partial(_streams, name) for name in _SIZES}


class _Stream:
    """A writer and its readers, a process each."""

    def __init__(self, tree: Tree, folder: str, readers: int, size: int, count: int) -> None:
        self._tree = tree
        self._number = readers * count
        self._sinks = [f"S{index}" for index in range(readers)]
        self._results = [os.path.join(folder, name) for name in self._sinks]
        named = {"count": str(count), "size": str(size)}
        _do(
            tree,
            Load("Images.py", "ImagesInit"),
            Create("ImageFlood?instance_name=F&manager_name=f"),
            *(Create(f"ImageSink?instance_name={s}&manager_name={s}") for s in self._sinks),
        )
        _do(
            tree,
            SetParameters("F", "default", named),
            *(
                SetParameters(name, "default", {"count": str(count), "result": result})
                for name, result in zip(self._sinks, self._results, strict=True)
            ),
            *(
                Connect(
                    ConnectorProfile(s, s, (PortRef("F", "out"), PortRef(s, "into")), _LOSSLESS)
                )
                for s in self._sinks
            ),
        )
        self._pids = [each.pid for each in tree.snapshot().processes if each.pid]

    def measure(self) -> Cost:
        """Let all be written, and return what each value and reader has cost."""
        _do(self._tree, *(ChangeState(s, "0", Transition.ACTIVATE) for s in self._sinks))
        spent_s, begin_ns = _spent_s(self._pids), time.monotonic_ns()
        _do(self._tree, ChangeState("F", "0", Transition.ACTIVATE))
        until = time.monotonic() + _PATIENCE_S
        while not all(map(os.path.exists, self._results)):
            if time.monotonic() > until:
                raise TimeoutError("not all values have come")
            time.sleep(0.001)
        spent_s = _spent_s(self._pids) - spent_s
        end_ns = max(int(_read(result)) for result in self._results)
        names = ["F", *self._sinks]
        _do(self._tree, *(ChangeState(name, "0", Transition.DEACTIVATE) for name in names))
        for result in self._results:
            os.unlink(result)
        return (end_ns - begin_ns) * 1e-3 / self._number, spent_s * 1e6 / self._number


def _read(path: str) -> str:
    with open(path, encoding="utf-8") as file:
        return file.read()


def _spent_s(pids: list[int]) -> float:
    """Return the processor time of processes so far [s]."""
    tick_s = 1.0 / os.sysconf("SC_CLK_TCK")
    fields = [_read(f"/proc/{pid}/stat").rpartition(")")[2].split() for pid in pids]
    return sum(int(each[11]) + int(each[12]) for each in fields) * tick_s


def _bare(readers: int, size: int, count: int) -> Cost:
    with _drains(readers, size * count) as ends:
        payload = os.urandom(size)
        begin, spent_s = time.perf_counter(), time.process_time()
        for _ in range(count):
            for end in ends:
                end.sendall(payload)
        costs_s = [float(end.recv(64)) for end in ends]
        elapsed_s, spent_s = time.perf_counter() - begin, time.process_time() - spent_s
    number = readers * count
    return elapsed_s * 1e6 / number, (spent_s + sum(costs_s)) * 1e6 / number


@contextmanager
def _drains(readers: int, length: int) -> Iterator[list[socket.socket]]:
    """Fork processes that read so many bytes each, and then say what that took [s]."""
    context = multiprocessing.get_context("fork")
    pairs = [socket.socketpair() for _ in range(readers)]
    drains = [context.Process(target=_drain, args=(pair[1], length)) for pair in pairs]
    for drain in drains:
        drain.start()
    try:
        yield [pair[0] for pair in pairs]
    finally:
        for drain in drains:
            drain.join()
        for pair in pairs:
            for end in pair:
                end.close()


def _drain(end: socket.socket, length: int) -> None:
    left, room = length, bytearray(_PIECE)
    spent_s = time.process_time()
    while left:
        left -= end.recv_into(room, min(left, _PIECE))
    end.sendall(str(time.process_time() - spent_s).encode())


def _do(tree: Tree, *actions: Action) -> None:
    for result in tree.apply(actions, timeout_s=_PATIENCE_S):
        result.raise_for_error()
