"""Holds what measurements share: rows, managers of their own, processes.

Machines are noisy, so a figure means little alone: figure and floor take turns (A B A B …) in one
run and on one interpreter, and the median of the ratios of neighbours is judged. Rows
whose target is an absolute time keep their floor beside them all the same.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import rtkit
from bench.pairs import Measured
from rtkit.deployment.actions import Action, Create, Delete
from rtkit.link.tcp_endpoint import free_port
from rtkit.manager import launch
from rtkit.settings.configuration import CommandLineSettings
from rtkit.tree import managers
from rtkit.tree.client import Tree

_START_S = 20.0
_PATIENCE_S = 30.0
_IN_MEMORY = "/dev/shm"

# Where byte code is not kept, each command and each slave would compile what it imports anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


class Row(NamedTuple):
    """One measured line.

    Attributes:
        what: What was measured.
        unit: Of figure and floor.
        measured: Medians of rtkit and of what is compared with, of their ratio, and the spread.
        target: Upper bound; None when the row only informs.
        is_ratio: Whether the target bounds the ratio, else the figure itself.
        floor_is: What the floor is.
        placement: Where both ends ran, if known.
    """

    what: str
    unit: str
    measured: Measured
    target: float | None
    is_ratio: bool
    floor_is: str
    placement: str = ""

    @property
    def verdict(self) -> str:
        """Whether the target is met; that the machine is too noisy to tell, where it is."""
        if self.target is None:
            return "too noisy" if self.measured.is_noisy else "-"
        interval = self.measured.spread and self.measured.spread.interval
        is_open = interval is not None and interval[0] <= self.target < interval[1]
        if self.is_ratio and self.measured.is_noisy and is_open:
            return "too noisy"
        bounded = self.measured.ratio if self.is_ratio else self.measured.figure
        return "ok" if bounded <= self.target else "MISSED"

    @property
    def ratio(self) -> str:
        """The median ratio for people, with its interval."""
        interval = self.measured.spread and self.measured.spread.interval
        ends = "" if interval is None else f" ({interval[0]:.2f}-{interval[1]:.2f})"
        return f"{self.measured.ratio:.2f}{ends}"

    def as_json(self) -> str:
        """Return the row as one line of JSON."""
        figure, floor, ratio, spread = self.measured
        members: dict[str, object] = {
            "schema": "rtkit.bench/1",
            "what": self.what,
            "unit": self.unit,
            "figure": float(f"{figure:.4g}"),
            "floor": float(f"{floor:.4g}"),
            "ratio": float(f"{ratio:.4g}"),
            "target": self.target,
            "target_bounds": "ratio" if self.is_ratio else "figure",
            "floor_is": self.floor_is,
            "verdict": self.verdict,
        }
        if spread is not None:
            members |= spread.as_json()
            members["noisy"] = self.measured.is_noisy
        if self.placement:
            members["placement"] = self.placement
        return json.dumps(members)


class Missing(NamedTuple):
    """A line that could not be measured on this machine."""

    what: str
    why: str

    def as_json(self) -> str:
        """Return the line as one line of JSON."""
        return json.dumps({"schema": "rtkit.bench/1", **self._asdict(), "verdict": "not measured"})


Lines = Iterator[Row | Missing]


def timed(work: Callable[[], object]) -> float:
    """Return how long a call takes [ms]."""
    begin = time.perf_counter()
    work()
    return (time.perf_counter() - begin) * 1e3


def process(arguments: list[str]) -> float:
    """Run a whole process, its output thrown away, and return how long it takes [ms]."""
    begin = time.perf_counter()
    _run(arguments)
    return (time.perf_counter() - begin) * 1e3


def work(arguments: list[str]) -> float:
    """Run a whole process likewise and return how much processor time it takes [ms].

    Of what waits for nobody but a manager that answers at once, and so is done when its work is:
    on a machine where others are at work this can be told apart, and time on the clock cannot.
    """
    usage = _run(arguments)
    return (usage.ru_utime + usage.ru_stime) * 1e3


def _run(arguments: list[str]) -> resource.struct_rusage:
    actions = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    pid = os.posix_spawn(arguments[0], arguments, os.environ, file_actions=actions)
    _, status, usage = os.wait4(pid, 0)
    if status:
        raise RuntimeError(f"{' '.join(arguments)} ended with status {status}")
    return usage


def command(name: str) -> str:
    """Return the path of an installed command of this interpreter."""
    path = os.path.join(os.path.dirname(sys.executable), name)
    if not os.path.exists(path):
        raise RuntimeError(f"{name} is not installed beside {sys.executable}: run make bench")
    return path


@contextmanager
def folders(*module_paths: str) -> Iterator[str]:
    """Have runtime and state folders of our own, which go with everything in them.

    The first is in memory, as the runtime folder of a login session is; the second, with logs, lies
    on disk in a folder that is yielded.
    """
    with (
        tempfile.TemporaryDirectory(prefix="rtb") as base,
        tempfile.TemporaryDirectory(prefix="rtb", dir=_memory()) as memory,
    ):
        os.environ["RTKIT_RUNTIME_DIR"] = os.path.join(memory, "r")
        os.environ["RTKIT_STATE_DIR"] = os.path.join(base, "s")
        os.environ["RTKIT_MODULE_PATH"] = os.pathsep.join(module_paths)
        yield base


def _memory() -> str | None:
    """Return a folder in memory; None where there is none."""
    return _IN_MEMORY if os.access(_IN_MEMORY, os.W_OK) else None


def start_manager(*, has_door: bool = False) -> int:
    """Start a manager in the present folders, with a TCP door if wanted; return its pid."""
    endpoints = f":{free_port()}" if has_door else "none"
    return launch.start(
        "manager", CommandLineSettings(overrides=(f"net.endpoints:{endpoints}",)), _START_S
    ).pid


@contextmanager
def manager(*module_paths: str, has_door: bool = False) -> Iterator[Tree]:
    """Run a manager of its own for one group of rows, leaving nothing behind."""
    with folders(*module_paths):
        pid = start_manager(has_door=has_door)
        try:
            with rtkit.connect() as tree:
                yield tree
            managers.stop("manager", _START_S)
        except BaseException:
            os.kill(pid, signal.SIGTERM)
            raise
        finally:
            os.waitpid(pid, 0)


def create(tree: Tree, texts: Sequence[str]) -> None:
    """Have components made by one call, and all of them."""
    actions: list[Action] = [Create(text) for text in texts]
    for result in tree.apply(actions, is_ordered=False, timeout_s=60.0):
        result.raise_for_error()


def until_listed(tree: Tree, count: int, state: str = "Inactive") -> None:
    """Wait until the benchmark's components, ``N0`` and so on, are all listed in a state."""
    deadline = time.monotonic() + _PATIENCE_S
    while True:
        rows = [row for row in tree.listing().rows if row.instance.startswith("N")]
        if len(rows) == count and all(row.state == state and not row.zombie for row in rows):
            return
        if time.monotonic() > deadline:
            raise TimeoutError(f"{len(rows)} of {count} components within {_PATIENCE_S:g} s")


def remove(tree: Tree, count: int) -> None:
    """End the benchmark's components, and their slaves."""
    actions: list[Action] = [Delete(f"N{index}") for index in range(count)]
    for result in tree.apply(actions, is_ordered=False, timeout_s=60.0):
        result.raise_for_error()
    until_alone(tree)


def until_alone(tree: Tree) -> None:
    """Wait until there is no slave any more."""
    while tree.listing().slaves:
        pass


def table(rows: Sequence[Row | Missing]) -> str:
    """Return the rows for people."""
    cells = [("", "figure", "floor", "ratio", "target", "")]
    for row in rows:
        if isinstance(row, Missing):
            cells.append((row.what, "-", "-", "-", "-", f"not measured: {row.why}"))
            continue
        bound = "" if row.target is None else f"{row.target:g}"
        unit = " x" if row.is_ratio else f" {row.unit}"
        cells.append(
            (
                row.what,
                f"{row.measured.figure:.3g} {row.unit}",
                f"{row.measured.floor:.3g} {row.unit}",
                row.ratio,
                f"<= {bound}{unit}" if bound else "-",
                _told(row),
            )
        )
    return columns(cells)


def _told(row: Row) -> str:
    """Return the verdict, and that the interval is wide where the verdict does not say it."""
    if row.measured.is_noisy and row.verdict != "too noisy":
        return f"{row.verdict}, too noisy"
    return row.verdict


def columns(cells: Sequence[Sequence[str]]) -> str:
    """Return lines of cells, one below the other."""
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = ["  ".join(f"{c:<{w}}" for c, w in zip(line, widths, strict=True)) for line in cells]
    return "\n".join(line.rstrip() for line in lines)


@contextmanager
def servers(*lines: Sequence[str]) -> Iterator[None]:
    """Run modules with these words, each a process that serves until its input ends."""
    ends: list[subprocess.Popen[str]] = []
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    try:
        for line in lines:
            words = [sys.executable, "-m", *line]
            pipe = subprocess.PIPE
            end = subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True, env=environment)
            ends.append(end)
        for end in ends:
            assert end.stdout is not None
            if end.stdout.readline() != "ready\n":
                raise RuntimeError("a server of the benchmark did not start")
        yield
    finally:
        for end in ends:
            end.communicate("", timeout=20)
