"""Measures many processes: cost of idle ones, rediscovery, and the end of all."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager

import rtkit
from bench.forks import Forks
from bench.harness import (
    Lines,
    Row,
    command,
    create,
    folders,
    manager,
    process,
    start_manager,
    timed,
    until_listed,
)
from bench.pairs import alone, medians, paired
from bench.processes import living, parent, processor_s, pss_mib
from rtkit.deployment.actions import Connect
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree import managers
from rtkit.tree.client import Tree

COUNT = 100
_SETTLE_S = 1.0
_WINDOW_S = 10.0
_WINDOWS = 3
LEAST_SHARE = 0.0001
"""Of a core [%]: one wake-up in a window, so that a floor that had none still is a floor."""
_FORKS_ARE = "resting forks of a Python process that has the same modules"
_STOPPED_ARE = "TERM to as many resting forks of a Python process, until they are waited for"
_IDLE_IS = "a bare Python process with the two zenoh sessions of a manager, which have no traffic"
_START_IS = "start of a manager that finds nothing, until it answers"
_SESSIONS = """
import sys
from rtkit.link.zenoh import open_listener, unix_endpoint
import json
inner = open_listener(unix_endpoint(sys.argv[1]))
more = {"connect/endpoints": json.dumps([unix_endpoint(sys.argv[1])])}
front = open_listener("tcp/127.0.0.1:0", more=more)
print("ready", flush=True)
sys.stdin.read()
front.close()
inner.close()
"""


def _memory() -> Lines:
    with manager(has_door=True) as tree, closing(Forks()) as forks:
        time.sleep(_SETTLE_S)  # the first moments of a manager are no steady state
        create(tree, [_source(index) for index in range(0, COUNT, 2)])
        create(tree, [_sink(index) for index in range(1, COUNT, 2)])
        until_listed(tree, COUNT)
        pids = list(_slaves(tree).values())
        bare = forks.ask("memory", COUNT)
        what = f"memory of an idle slave, of {COUNT}, "
        yield _memory_row(f"{what}without connectors (PSS)", pss_mib(pids), bare, 4.0)
        for index in range(0, COUNT, 2):
            tree.perform(Connect(_wire(index)))
        time.sleep(_SETTLE_S)
        yield _memory_row(f"{what}each with a connector (PSS)", pss_mib(pids), bare, 4.5)


def _memory_row(what: str, mib: float, bare: float, target: float) -> Row:
    return Row(what, "MiB", alone(mib, bare), target, False, _FORKS_ARE)


def _idle() -> Lines:
    with manager(has_door=True) as tree, idle_sessions() as sessions:
        create(tree, [_source(index) for index in range(COUNT)])
        until_listed(tree, COUNT)
        slaves = list(_slaves(tree).values())
        own = int(tree.get("manager.pid"))
        ours = [own, parent(slaves[0]), *slaves]
        time.sleep(_SETTLE_S)
        pairs = []
        for _ in range(_WINDOWS):
            before = processor_s(ours), processor_s([sessions])
            time.sleep(_WINDOW_S)
            after = processor_s(ours), processor_s([sessions])
            shares = [(b - a) / _WINDOW_S * 100 for a, b in zip(before, after, strict=True)]
            pairs.append((shares[0], max(shares[1], LEAST_SHARE)))
        what = f"{COUNT} idle slaves, their manager and its zygote: processor"
        yield Row(what, "% of a core", medians(pairs), 2.0, False, _IDLE_IS)


@contextmanager
def idle_sessions(socket_name: str = "bare.sock") -> Iterator[int]:
    """Run a bare process with the two zenoh sessions of a manager; yield its pid."""
    socket = os.path.join(os.environ["RTKIT_RUNTIME_DIR"], socket_name)
    bare = subprocess.Popen(
        [sys.executable, "-c", _SESSIONS, socket],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert bare.stdout is not None
    bare.stdout.readline()
    try:
        yield bare.pid
    finally:
        bare.communicate()


def _found() -> Lines:
    with folders():
        pid = start_manager(has_door=True)
        try:
            with rtkit.connect() as tree:
                create(tree, [_source(index) for index in range(COUNT)])
                until_listed(tree, COUNT)

            def again() -> float:
                nonlocal pid
                _kill(pid)
                begin = time.perf_counter()
                pid = start_manager(has_door=True)
                with rtkit.connect() as tree:
                    until_listed(tree, COUNT)
                return time.perf_counter() - begin

            measured = paired(again, _start_s, 5)
        finally:
            managers.stop("manager", 30.0)
            os.waitpid(pid, 0)
    what = f"{COUNT} slaves found again by the next manager after a kill -9, from its start"
    yield Row(what, "s", measured, 2.0, False, _START_IS)


def _start_s() -> float:
    """Return how long another manager, of a folder of its own, takes until it answers [s]."""
    kept = {name: os.environ[name] for name in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR")}
    try:
        with folders():
            begin = time.perf_counter()
            pid = start_manager(has_door=True)
            with rtkit.connect() as tree:
                tree.listing()
            elapsed_s = time.perf_counter() - begin
            managers.stop("manager", 30.0)
            os.waitpid(pid, 0)
            return elapsed_s
    finally:
        os.environ.update(kept)


def _kill(pid: int) -> None:
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)


def _stop() -> Lines:
    with folders(), closing(Forks()) as forks:
        for count, target, rounds in ((10, 200.0, 9), (COUNT, 500.0, 7)):
            what = f"rtmgr stop of {count} slaves, whole process, until none is left"

            def ours(count: int = count) -> float:
                return _stopped_ms(count)

            def bare(count: int = count) -> float:
                return forks.ask("stop", count)

            measured = paired(ours, bare, rounds)
            yield Row(what, "ms", measured, target, False, _STOPPED_ARE)


def _stopped_ms(count: int) -> float:
    pid = start_manager(has_door=True)
    with rtkit.connect() as tree:
        create(tree, [_source(index) for index in range(count)])
        until_listed(tree, count)
        pids = list(_slaves(tree).values())
    pids.append(parent(pids[0]))

    def stop() -> None:
        process([command("rtmgr"), "stop"])
        while living(pids):
            pass

    elapsed_ms = timed(stop)
    os.waitpid(pid, 0)
    return elapsed_ms


PARTS = {"memory": _memory, "idle": _idle, "found": _found, "stop": _stop}


def _source(index: int) -> str:
    return f"ConsoleIn?instance_name=N{index}&manager_name=n{index}"


def _sink(index: int) -> str:
    return f"ConsoleOut?instance_name=N{index}&manager_name=n{index}"


def _wire(index: int) -> ConnectorProfile:
    ports = PortRef(f"N{index}", "out"), PortRef(f"N{index + 1}", "in")
    return ConnectorProfile(f"c{index}", f"c{index}", ports, {})


def _slaves(tree: Tree) -> dict[str, int]:
    return {p.name: p.pid for p in tree.snapshot().processes if p.name.startswith("n")}
