"""Bringing components up: from one call, or one command, until all are listed Inactive."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing

from bench.harness import Row, command, manager, paired, process, timed
from rtkit.deployment.actions import Action, Create, Delete, Load, Unload
from rtkit.resources import resource
from rtkit.tree.client import Tree

_FORK_IS = "fork of a Python process that has the same modules, until the child is heard, each"
_MADE_IS = "the same components made by a plain loop in one process, each"


def rows() -> Iterator[Row]:
    """Measure launching in one process and in slaves; figures are per component."""
    with manager() as tree, closing(_Forks()) as forked:
        here, apart = _in_manager, _in_slaves
        yield _row(tree, "10 components, one batch, same process", 10, here, 3.0, _made)
        yield _row(tree, "100 components, one batch, same process", 100, here, 2.0, _made)
        yield _row(tree, "10 components, one batch, own slave each", 10, apart, 12.0, forked)
        yield _row(tree, "100 components, one batch, own slave each", 100, apart, None, forked, 7)
        yield _command_row(tree, "10 components, one rtmgr, same process", here, _made)
        yield _command_row(tree, "10 components, one rtmgr, own slave each", apart, forked)
        yield _trial_row(tree, forked)
        yield _system_row(tree)


def _in_manager(index: int) -> str:
    return f"ConsoleIn?instance_name=N{index}"


def _in_slaves(index: int) -> str:
    return f"ConsoleIn?instance_name=N{index}&manager_name=n{index}"


def _row(
    tree: Tree,
    what: str,
    count: int,
    place: Callable[[int], str],
    target: float | None,
    floor: Callable[[int], float],
    rounds: int = 15,
) -> Row:
    creates: list[Action] = [Create(place(index)) for index in range(count)]

    def launch() -> float:
        def call() -> None:
            for result in tree.apply(creates, is_ordered=False, timeout_s=60.0):
                result.raise_for_error()
            _until_listed(tree, count)

        elapsed_ms = timed(call)
        _remove(tree, count)
        return elapsed_ms / count

    measured = paired(launch, lambda: floor(count) / count, rounds)
    floor_is = _MADE_IS if floor is _made else _FORK_IS
    return Row(f"{what}, each until Inactive", "ms", *measured, target, False, floor_is)


def _command_row(
    tree: Tree, what: str, place: Callable[[int], str], floor: Callable[[int], float]
) -> Row:
    count = 10
    line = [command("rtmgr"), "/localhost/manager.mgr"]
    for index in range(count):
        line += ["-c", place(index)]

    def launch() -> float:
        elapsed_ms = process(line)
        _until_listed(tree, count)
        _remove(tree, count)
        return elapsed_ms / count

    measured = paired(launch, lambda: floor(count) / count, 15)
    floor_is = _MADE_IS if floor is _made else _FORK_IS
    return Row(f"{what}, whole process, each", "ms", *measured, None, False, floor_is)


def _trial_row(tree: Tree, floor: Callable[[int], float]) -> Row:
    def load() -> float:
        elapsed_ms = timed(lambda: tree.perform(Load("ConsoleIn.py")))
        tree.perform(Unload("ConsoleIn.py"))
        return elapsed_ms

    measured = paired(load, lambda: floor(1), 15)
    what = "a module imported by a process of its own, one call, until it is known"
    return Row(what, "ms", *measured, None, False, _FORK_IS)


def _system_row(tree: Tree) -> Row:
    profile = resource("profiles", "systems", "sensor-controller-motor.xml")
    bring_up, rtls = [command("rtresurrect"), profile], [command("rtls"), "/localhost"]

    def launch() -> float:
        elapsed_ms = process(bring_up)
        process([command("rtteardown"), "--exit", profile])
        _until_alone(tree)
        return elapsed_ms

    measured = paired(launch, lambda: process(rtls), 15)
    what = "rtresurrect of three connected components, own slave each, whole process"
    return Row(what, "ms", *measured, None, True, "rtls")


def _until_alone(tree: Tree) -> None:
    while tree.listing().slaves:
        pass


def _until_listed(tree: Tree, count: int) -> None:
    while True:
        rows = [row for row in tree.listing().rows if row.instance.startswith("N")]
        if len(rows) == count and all(row.state == "Inactive" for row in rows):
            return


def _remove(tree: Tree, count: int) -> None:
    deletes: list[Action] = [Delete(f"N{index}") for index in range(count)]
    for result in tree.apply(deletes, is_ordered=False, timeout_s=60.0):
        result.raise_for_error()
    _until_alone(tree)


def _made(count: int) -> float:
    from rtkit.component.base import Component
    from rtkit.component.port import OutPort
    from rtkit.component.types import TimedLong

    class Source(Component):
        """What the samples' console source declares."""

        out = OutPort(TimedLong)

    def make() -> None:
        for index in range(count):
            Source(f"N{index}").initialize()

    return timed(make)


class _Forks:
    """The process that forks (see `bench.forks`)."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "bench.forks"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def __call__(self, count: int) -> float:
        """Return how long that many forks take [ms]."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{count}\n")
        self._process.stdin.flush()
        return float(self._process.stdout.readline())

    def close(self) -> None:
        """End it."""
        self._process.communicate()
