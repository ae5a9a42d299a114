"""Measures recovery: from the kill of a slave, or of the manager, until all is restored."""

from __future__ import annotations

import itertools
import os
import signal
import statistics
import time
from collections.abc import Callable

import rtkit
from bench.harness import Lines, Row, create, folders, manager, start_manager, until_listed
from bench.pairs import alone, medians, pairs_of
from rtkit.deployment.actions import (
    Action,
    ChangeState,
    Connect,
    Create,
    Delete,
    SetParameters,
)
from rtkit.manager import launch
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.settings.configuration import CommandLineSettings
from rtkit.tree import managers
from rtkit.tree.client import Tree
from rtkit.tree.subscription import ManagerSubscription, TreeChange

ROUNDS = 41
_MANAGERS = 15
_COMPONENTS = 8
_PATIENCE_S = 30.0
_FLOOR_IS = "creation of the same component in a new slave, asked for and answered: nothing else"
_TAIL_IS = "the same pairs"


def _restart() -> Lines:
    with manager() as tree, ManagerSubscription(tree) as subscription:
        numbers = itertools.count()
        tree.perform(Create("Sensor?instance_name=S&manager_name=s"))
        tree.perform(ChangeState("S", "0", Transition.ACTIVATE))
        pairs = pairs_of(_again(tree, subscription, numbers), _created(tree, numbers), ROUNDS)
    what = "killed slave, no wait: connected, configured, active again, from the kill"
    yield Row(f"{what} (median)", "ms", medians(pairs), 60.0, False, _FLOOR_IS)
    again_ms, bare_ms = (statistics.quantiles(each, n=20)[-1] for each in zip(*pairs, strict=True))
    yield Row(f"{what} (95 of 100)", "ms", alone(again_ms, bare_ms), None, False, _TAIL_IS)


def _next_manager() -> Lines:
    with folders():
        pids = [start_manager()]
        with rtkit.connect() as tree:
            _build(tree)
        metrics = medians(pairs_of(lambda: _succeeded(pids), _begun, _MANAGERS))
        managers.stop("manager", _PATIENCE_S)
        os.waitpid(pids[-1], 0)
    what = f"killed manager: the next one has {_COMPONENTS} components as desired, from its start"
    yield Row(what, "ms", metrics, 1.5, True, "start of a manager that finds nothing")


PARTS = {"slave": _restart, "manager": _next_manager}


def _build(tree: Tree) -> None:
    """Have sensors and controllers connected, set and active: two here, the rest in slaves."""
    places = ["" if n < 2 else f"&manager_name=s{n % 4}" for n in range(_COMPONENTS)]
    types = [("Sensor", "Controller")[n % 2] for n in range(_COMPONENTS)]
    create(
        tree,
        [f"{types[n]}?instance_name=N{n}{place}" for n, place in enumerate(places)],
    )
    actions: list[Action] = []
    for n in range(0, _COMPONENTS, 2):
        ends = (PortRef(f"N{n}", "distance"), PortRef(f"N{n + 1}", "distance"))
        actions += [
            Connect(ConnectorProfile(f"w{n}", f"w{n}", ends)),
            SetParameters(f"N{n + 1}", "default", {"gain": "2.5"}),
        ]
    actions += [ChangeState(f"N{n}", "0", Transition.ACTIVATE) for n in range(_COMPONENTS)]
    for result in tree.apply(actions):
        result.raise_for_error()


def _succeeded(pids: list[int]) -> float:
    """Kill the manager; return how long the next one takes until all is as it was [ms]."""
    os.kill(pids[-1], signal.SIGKILL)
    os.waitpid(pids[-1], 0)
    begin = time.perf_counter()
    pids.append(start_manager())
    with rtkit.connect() as tree:
        until_listed(tree, _COMPONENTS, "Active")
        if len(tree.snapshot().connectors) != _COMPONENTS // 2:
            raise RuntimeError("not all is connected again")
    return (time.perf_counter() - begin) * 1e3


def _begun() -> float:
    """Start a manager that finds nothing, until it has answered [ms]."""
    begin = time.perf_counter()
    pid = launch.start(
        "other", CommandLineSettings(overrides=("net.endpoints:none",)), _PATIENCE_S
    ).pid
    with rtkit.connect("other") as tree:
        tree.listing()
        tree.snapshot()
    elapsed_ms = (time.perf_counter() - begin) * 1e3
    managers.stop("other", _PATIENCE_S)
    os.waitpid(pid, 0)
    return elapsed_ms


def _again(
    tree: Tree, subscription: ManagerSubscription, numbers: itertools.count[int]
) -> Callable[[], float]:
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
        subscription.take()
        begin = time.perf_counter()
        os.kill(pid, signal.SIGKILL)
        while not any(
            each.event == "MADE_AGAIN"
            for heard in subscription.wait(30.0)
            if isinstance(heard, TreeChange)
            for each in heard.user_events
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
