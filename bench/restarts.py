"""From the kill of a slave until what it held is there again: connected, configured, active."""

from __future__ import annotations

import itertools
import os
import signal
import statistics
import time
from collections.abc import Callable

from bench.harness import Lines, Row, manager, medians, pairs_of
from rtkit.deployment.actions import ChangeState, Connect, Create, Delete, SetParameters
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree
from rtkit.tree.listening import Change, Ear

ROUNDS = 41
_FLOOR_IS = "creation of the same component in a new slave, asked for and answered: nothing else"
_TAIL_IS = "the same pairs"


def _restart() -> Lines:
    with manager() as tree, Ear(tree) as ear:
        numbers = itertools.count()
        tree.perform(Create("Sensor?instance_name=S&manager_name=s"))
        tree.perform(ChangeState("S", "0", Transition.ACTIVATE))
        pairs = pairs_of(_again(tree, ear, numbers), _created(tree, numbers), ROUNDS)
    what = "killed slave, no wait: connected, configured, active again, from the kill"
    yield Row(f"{what} (median)", "ms", *medians(pairs), 60.0, False, _FLOOR_IS)
    again_ms, bare_ms = (statistics.quantiles(each, n=20)[-1] for each in zip(*pairs, strict=True))
    ratio = again_ms / bare_ms
    yield Row(f"{what} (95 of 100)", "ms", again_ms, bare_ms, ratio, None, False, _TAIL_IS)


PARTS = {"slave": _restart}


def _again(tree: Tree, ear: Ear, numbers: itertools.count[int]) -> Callable[[], float]:
    def again() -> float:
        number = next(numbers)
        name = f"C{number}"
        ends = (PortRef("S", "distance"), PortRef(name, "distance"))
        policy = "rtkit.restart=on-failure&rtkit.restart.delay=0"
        tree.perform(Create(f"Controller?instance_name={name}&manager_name=c{number}&{policy}"))
        tree.perform(Connect(ConnectorProfile(f"w{number}", f"w{number}", ends)))
        tree.perform(SetParameters(name, "default", {"gain": "2.5"}))
        tree.perform(ChangeState(name, "0", Transition.ACTIVATE))
        (pid,) = (each.pid for each in tree.snapshot().processes if each.name == f"c{number}")
        ear.take()
        begin = time.perf_counter()
        os.kill(pid, signal.SIGKILL)
        while not any(
            each.event == "MADE_AGAIN"
            for heard in ear.wait(30.0)
            if isinstance(heard, Change)
            for each in heard.happenings
        ):
            pass
        elapsed_ms = (time.perf_counter() - begin) * 1e3
        tree.perform(Delete(name))
        return elapsed_ms

    return again


def _created(tree: Tree, numbers: itertools.count[int]) -> Callable[[], float]:
    def created() -> float:
        number = next(numbers)
        begin = time.perf_counter()
        tree.perform(Create(f"Controller?instance_name=B{number}&manager_name=b{number}"))
        elapsed_ms = (time.perf_counter() - begin) * 1e3
        tree.perform(Delete(f"B{number}"))
        return elapsed_ms

    return created
