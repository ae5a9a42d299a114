"""Measures data tools at fast streams: a counting ``rtprint`` and ``rtlog``, and their losses.

A source writes as fast as values are taken, so the time that a fixed number takes tells the rate.
``rtlog`` stands beside writers that have the values at hand and only store them.
"""

from __future__ import annotations

import json
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from bench.harness import Lines, Row, command, manager
from bench.pairs import alone, medians, pairs_of
from bench.writers import BARE_IS, PACKAGE_IS, Cost, writer
from rtkit.deployment.actions import Action, ChangeState, Create, SetParameters
from rtkit.recording.mcap_file import CHUNK_S, RecordingReader
from rtkit.rtc.enums import Transition
from rtkit.tree.client import Tree

_COMPONENTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "components")
_ROUNDS = 5
_PATIENCE_S = 60.0
_FLOOR_IS = "bare zenoh that counts the same bytes, same kind of sockets and sessions"
_OVERHEAD = 16
"""What the form of data adds to the octets of a value [bytes]."""

_STREAMS = (("10,000 values of 64 B", 10_000, 64), ("200 MB as 1 MB images", 200, 1_000_000))
_TARGET_MS = 1000.0
_LARGE = 1000
_LIKE_THE_PACKAGE = 1.3
_TURNS = 9
_KILLS = 12
_CLOSED_IS = "after which what was recorded can be read, whatever happens"


def _printing() -> Lines:
    words = [command("rtprint"), "--stats", "--lossless", "-n"]
    with flooding() as flood, _bare() as bare:
        for what, count, size in _STREAMS:

            def ours(count: int = count, size: int = size) -> float:
                return flood.measure([*words, str(count), Flood.PORT], count, size)[0]

            measured = medians(pairs_of(ours, partial(bare, count, size), _ROUNDS))
            yield Row(f"rtprint --stats, {what}", "ms", measured, _TARGET_MS, False, _FLOOR_IS)


def _recording() -> Lines:
    with (
        flooding() as flood,
        tempfile.TemporaryDirectory(prefix="rtb") as folder,
        writer("package", os.path.join(folder, "package")) as package,
        writer("bare", os.path.join(folder, "bare")) as bare,
    ):
        ours = partial(_recorded, flood, os.path.join(folder, "x.mcap"))
        for what, count, size in _STREAMS:
            takers = ours, package, bare
            turns = [tuple(each(count, size) for each in takers) for _ in range(_TURNS + 1)][1:]
            yield from _beside_writers(f"rtlog, {what}", turns, count, is_large=size > _LARGE)


def _beside_writers(
    what: str, turns: list[tuple[Cost, ...]], count: int, *, is_large: bool
) -> Lines:
    """Yield rows of time beside both writers, and of processor time beside the package."""
    each = 1e3 / count
    times = [[cost.elapsed_ms for cost in turn] for turn in turns]
    spent = [(ours.spent_ms * each, package.spent_ms * each) for ours, package, _ in turns]
    bound = (_LIKE_THE_PACKAGE, True) if is_large else (_TARGET_MS, False)
    beside_package = medians([(ours, package) for ours, package, _ in times])
    beside_bare = medians([(ours, bare) for ours, _, bare in times])
    yield Row(what, "ms", beside_package, *bound, PACKAGE_IS)
    yield Row(f"{what}, beside bare writes", "ms", beside_bare, None, True, BARE_IS)
    yield Row(f"{what}, processor time of each", "us", medians(spent), None, True, PACKAGE_IS)


def _recorded(flood: Flood, file: str, count: int, size: int) -> Cost:
    words = [command("rtlog"), "--lossless", "-i", "-f", file, "-e", str(count), Flood.PORT]
    elapsed_ms, told = flood.measure(words, count, size)
    os.unlink(file)
    spent = re.search(r", (\d+) us of processor time each", told)
    if spent is None:
        raise RuntimeError(f"rtlog tells no processor time: {told}")
    return Cost(elapsed_ms, int(spent[1]) * count / 1e3)


def _losing() -> Lines:
    with flooding() as flood:
        for what, count, size in _STREAMS:
            args = ["--stats", "--json", "-t", "4", Flood.PORT]
            told = flood.told([command("rtprint"), *args], count, size)
            missing = abs(count - told["values"] - told["lost"])
            text = f"{what}, overwriting: neither counted nor told as lost"
            yield Row(text, "values", alone(missing, count), 0.0, False, "what was sent")


def _killing() -> Lines:
    with manager() as tree, tempfile.TemporaryDirectory(prefix="rtb") as folder:
        _do(tree, Create("Motor?instance_name=M&manager_name=m"))
        _do(tree, ChangeState("M", "0", Transition.ACTIVATE))
        chance = random.Random(1)
        paths = [os.path.join(folder, f"{number}.mcap") for number in range(_KILLS)]
        lost_ms = [_lost_ms(path, chance.uniform(0.6, 2.0)) for path in paths]
        worst = max(lost_ms)
        closed_ms = CHUNK_S * 1e3
        text = f"rtlog killed at {_KILLS} random moments, the last that is lost of what came"
        yield Row(text, "ms", alone(worst, closed_ms), 1000.0, False, _CLOSED_IS)


def _lost_ms(path: str, after_s: float) -> float:
    """Record for so long, kill the recorder, and return what of the end is not in the file [ms]."""
    tool = [command("rtlog"), "-f", path, "/localhost/M.rtc:pose"]
    process = _connected(tool)
    time.sleep(after_s)
    process.kill()
    died_ns = time.time_ns()
    process.communicate()
    last_ns = max(entry.arrived_ns for entry in RecordingReader(path).entries())
    return (died_ns - last_ns) * 1e-6


PARTS = {"print": _printing, "log": _recording, "lose": _losing, "kill": _killing}


class Flood:
    """A source in a slave, and tools at its port.

    Attributes:
        tree: The manager.
    """

    PORT = "/localhost/F.rtc:out"

    def __init__(self, tree: Tree) -> None:
        self.tree = tree
        _do(tree, Create("Flood?instance_name=F&manager_name=f"))

    def measure(self, tool: list[str], count: int, size: int) -> tuple[float, str]:
        """Return how long it takes from the first value until the tool has ended [ms].

        And what it tells meanwhile.
        """
        process = self.connected(tool, count, size)
        begin = time.perf_counter()
        _do(self.tree, ChangeState("F", "0", Transition.ACTIVATE))
        _, told = process.communicate(timeout=_PATIENCE_S)
        elapsed_ms = (time.perf_counter() - begin) * 1e3
        self.end(process)
        return elapsed_ms, told

    def told(self, tool: list[str], count: int, size: int) -> dict[str, int]:
        """Return what the tool tells as JSON of a stream that it may lose values of."""
        process = self.connected(tool, count, size)
        _do(self.tree, ChangeState("F", "0", Transition.ACTIVATE))
        out, _ = process.communicate(timeout=_PATIENCE_S)
        self.end(process)
        record: dict[str, int] = json.loads(out)
        return record

    def connected(self, tool: list[str], count: int, size: int) -> subprocess.Popen[str]:
        """Start a tool for so many values of so many bytes, and wait until it is connected."""
        settings = {"count": str(count), "size": str(size - _OVERHEAD)}
        _do(self.tree, SetParameters("F", "default", settings))
        return _connected(tool)

    def end(self, process: subprocess.Popen[str]) -> None:
        """Check how a tool has ended, and let the source rest."""
        if process.returncode:
            raise RuntimeError(f"{process.args!r} ended with status {process.returncode}")
        _do(self.tree, ChangeState("F", "0", Transition.DEACTIVATE))


def _connected(tool: list[str]) -> subprocess.Popen[str]:
    """Start a tool and wait until it is connected."""
    pipe = subprocess.PIPE
    process = subprocess.Popen([*tool, "-v"], stdout=pipe, stderr=pipe, text=True)
    assert process.stderr is not None
    line = process.stderr.readline()
    if "is connected" not in line:
        raise RuntimeError(line + process.communicate()[1])
    return process


@contextmanager
def flooding() -> Iterator[Flood]:
    with manager(_COMPONENTS) as tree:
        yield Flood(tree)


@contextmanager
def _bare() -> Iterator[Callable[[int, int], float]]:
    with tempfile.TemporaryDirectory(prefix="rtb") as folder:
        path = os.path.join(folder, "flow")
        start, pipe = [sys.executable, "-m", "bench.flow"], subprocess.PIPE
        drain = subprocess.Popen([*start, "drain", path], stdin=pipe, stdout=pipe, text=True)
        pour = subprocess.Popen([*start, "pour", path], stdin=pipe, text=True)
        assert drain.stdin is not None
        assert drain.stdout is not None
        assert pour.stdin is not None
        asked, answers, told = drain.stdin, drain.stdout, pour.stdin

        def measure(count: int, size: int) -> float:
            asked.write(f"{count}\n")
            asked.flush()
            answers.readline()
            told.write(f"{count} {size}\n")
            told.flush()
            return float(answers.readline())

        try:
            yield measure
        finally:
            pour.communicate()
            drain.communicate()


def _do(tree: Tree, *actions: Action) -> None:
    for result in tree.apply(actions, timeout_s=_PATIENCE_S):
        result.raise_for_error()
