"""Measures a hundred managers on one machine: start, listing, memory, and load at rest."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress

from bench.harness import Lines, Row, command, create, folders, process, timed, until_listed
from bench.pairs import alone, medians, pairs_of
from bench.processes import processor_s, pss_mib
from bench.slaves import LEAST_SHARE, idle_sessions
from rtkit.errors import Unreachable
from rtkit.tree import managers
from rtkit.tree.connect import connect

COUNT = 100
COMPONENTS = 100
"""Of each manager, in its own process."""

_AT_ONCE = 10
_PATIENCE_S = 60.0
_ROUNDS = 9
_SETTLE_S = 2.0
_WINDOW_S = 10.0
_NAMES = [f"m{index}" for index in range(COUNT)]
_BARE_IS = "as many bare Python processes with the two zenoh sessions of a manager"
_ONE_IS = "the same for one of these managers"


def _hundred() -> Lines:
    with folders(), _bare_sessions() as (bare, bare_ms):
        pids: list[int] = []
        try:
            started_ms = timed(lambda: _each(_start))
            what = f"{COUNT} managers started, {_AT_ONCE} at once, until they answer: each"
            yield Row(what, "ms", alone(started_ms / COUNT, bare_ms / COUNT), None, False, _BARE_IS)
            _each(lambda name: _fill(name, pids))
            yield _listing()
            what = f"memory of a manager with {COMPONENTS} components, one of {COUNT} (PSS)"
            yield Row(what, "MiB", alone(pss_mib(pids), pss_mib(bare)), None, False, _BARE_IS)
            what = f"{COUNT} idle managers with {COMPONENTS} components each: processor"
            time.sleep(_SETTLE_S)  # the first moments of a manager are no steady state
            loads = alone(_load_percent(pids), _load_percent(bare))
            yield Row(what, "% of a core", loads, None, False, _BARE_IS)
        finally:
            _each(_stop)


def _each(work: Callable[[str], object]) -> None:
    """Do something for each manager, for several at once."""
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        list(pool.map(work, _NAMES))


def _start(name: str) -> None:
    process([command("rtmgr"), "start", name, "--no-door", "--timeout", f"{_PATIENCE_S:g}"])


def _fill(name: str, pids: list[int]) -> None:
    with connect(name, _PATIENCE_S) as tree:
        pids.append(int(tree.get("manager.pid")))
        create(tree, [f"ConsoleIn?instance_name=N{index}" for index in range(COMPONENTS)])
        until_listed(tree, COMPONENTS)


def _stop(name: str) -> None:
    with suppress(Unreachable):  # it has not been started
        managers.stop(name, _PATIENCE_S)


def _listing() -> Row:
    everything = [command("rtls"), "-R", "/"]
    one = [command("rtls"), "-R", f"/localhost/{_NAMES[0]}.mgr"]
    pairs = pairs_of(lambda: process(everything), lambda: process(one), _ROUNDS)
    what = f"rtls -R / of {COUNT * COMPONENTS:,} components of {COUNT} managers, whole process"
    return Row(what, "ms", medians(pairs), 5000.0, False, _ONE_IS)


def _load_percent(pids: list[int]) -> float:
    before = processor_s(pids)
    time.sleep(_WINDOW_S)
    return max((processor_s(pids) - before) / _WINDOW_S * 100, LEAST_SHARE)


@contextmanager
def _bare_sessions() -> Iterator[tuple[list[int], float]]:
    """Start as many bare processes; yield their pids, and how long that took [ms]."""
    pids: list[int] = []
    os.makedirs(os.environ["RTKIT_RUNTIME_DIR"], mode=0o700)
    with ExitStack() as stack:

        def start(name: str) -> None:
            pids.append(stack.enter_context(idle_sessions(f"bare.{name}.sock")))

        yield pids, timed(lambda: _each(start))


PARTS = {"hundred": _hundred}
