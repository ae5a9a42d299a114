"""Measures the time from the kill of a slave to its mark in the listing."""

from __future__ import annotations

import os
import select
import signal
import sys
import time

from bench.harness import Lines, Row, manager
from bench.pairs import paired
from rtkit.deployment.actions import Create
from rtkit.tree.client import Tree

_FLOOR_IS = "kill of a bare Python process until its pidfd tells"


def _killed() -> Lines:
    with manager() as tree:
        measured = paired(lambda: _slave_ms(tree), _bare_ms)
        what = "dead slave (small) marked in the listing, from the kill"
        yield Row(what, "ms", measured, 50.0, False, _FLOOR_IS)


PARTS = {"killed": _killed}


def _slave_ms(tree: Tree) -> float:
    tree.perform(Create("ConsoleIn?instance_name=Z&manager_name=z"))
    (pid,) = [p.pid for p in tree.snapshot().processes if p.name == "z"]
    begin = time.perf_counter()
    os.kill(pid, signal.SIGKILL)
    while not any(row.zombie for row in tree.listing().rows):
        pass
    elapsed_ms = (time.perf_counter() - begin) * 1e3
    tree.delete("/localhost/Z.rtc")
    return elapsed_ms


def _bare_ms() -> float:
    reading, writing = os.pipe()
    os.set_inheritable(writing, True)
    code = f"import os, time; os.write({writing}, b'x'); time.sleep(60)"
    pid = os.posix_spawn(sys.executable, [sys.executable, "-c", code], os.environ)
    os.close(writing)
    os.read(reading, 1)
    os.close(reading)
    descriptor = os.pidfd_open(pid)
    begin = time.perf_counter()
    os.kill(pid, signal.SIGKILL)
    select.select([descriptor], [], [])
    elapsed_ms = (time.perf_counter() - begin) * 1e3
    os.close(descriptor)
    os.waitpid(pid, 0)
    return elapsed_ms
