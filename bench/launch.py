"""Measures bringing components up: from one call, or command, until all are Inactive."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing

from bench.forks import Forks
from bench.harness import (
    Lines,
    Row,
    command,
    create,
    manager,
    process,
    remove,
    timed,
    until_alone,
    until_listed,
)
from bench.pairs import paired
from rtkit.deployment.actions import Load, Unload
from rtkit.resources import resource
from rtkit.tree.client import Tree

_FORK_IS = "fork of a Python process that has the same modules, until the child is heard, each"
_MADE_IS = "the same components made by a plain loop in one process, each"


def _batches() -> Lines:
    with manager() as tree, closing(Forks()) as forks:
        here, apart, forked = _in_manager, _in_slaves, _forked(forks)
        yield _row(tree, "10 components, one batch, same process", 10, here, 3.0, made)
        yield _row(tree, "100 components, one batch, same process", 100, here, 2.0, made)
        yield _row(tree, "10 components, one batch, own slave each", 10, apart, 4.0, forked)
        yield _row(tree, "100 components, one batch, own slave each", 100, apart, 4.0, forked, 7)


def _commands() -> Lines:
    with manager() as tree, closing(Forks()) as forks:
        forked = _forked(forks)
        here, apart = _in_manager, _in_slaves
        yield _command_row(tree, "10 components, one rtmgr, same process", here, None, made)
        yield _command_row(tree, "10 components, one rtmgr, own slave each", apart, 12.0, forked)
        yield _trial_row(tree, forked)
        yield _system_row(tree)


PARTS = {"batches": _batches, "commands": _commands}


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
    texts = [place(index) for index in range(count)]

    def launch() -> float:
        def call() -> None:
            create(tree, texts)
            until_listed(tree, count)

        elapsed_ms = timed(call)
        remove(tree, count)
        return elapsed_ms / count

    measured = paired(launch, lambda: floor(count) / count, rounds)
    floor_is = _MADE_IS if floor is made else _FORK_IS
    return Row(f"{what}, each until Inactive", "ms", measured, target, False, floor_is)


def _command_row(
    tree: Tree,
    what: str,
    place: Callable[[int], str],
    target: float | None,
    floor: Callable[[int], float],
) -> Row:
    count = 10
    line = [command("rtmgr"), "/localhost/manager.mgr"]
    for index in range(count):
        line += ["-c", place(index)]

    def launch() -> float:
        elapsed_ms = process(line)
        until_listed(tree, count)
        remove(tree, count)
        return elapsed_ms / count

    measured = paired(launch, lambda: floor(count) / count, 15)
    floor_is = _MADE_IS if floor is made else _FORK_IS
    return Row(f"{what}, whole process, each", "ms", measured, target, False, floor_is)


def _trial_row(tree: Tree, floor: Callable[[int], float]) -> Row:
    def load() -> float:
        elapsed_ms = timed(lambda: tree.perform(Load("ConsoleIn.py")))
        tree.perform(Unload("ConsoleIn.py"))
        return elapsed_ms

    measured = paired(load, lambda: floor(1), 15)
    what = "a module imported by a process of its own, one call, until it is known"
    return Row(what, "ms", measured, None, False, _FORK_IS)


def _system_row(tree: Tree) -> Row:
    profile = resource("profiles", "systems", "sensor-controller-motor.xml")
    bring_up, rtls = [command("rtresurrect"), profile], [command("rtls"), "/localhost"]

    def launch() -> float:
        elapsed_ms = process(bring_up)
        process([command("rtteardown"), "--exit", profile])
        until_alone(tree)
        return elapsed_ms

    measured = paired(launch, lambda: process(rtls), 15)
    what = "rtresurrect of three connected components, own slave each, whole process"
    return Row(what, "ms", measured, 1.7, True, "rtls")


def made(count: int) -> float:
    """Return how long a plain loop takes to make so many components [ms]."""
    from rtkit.component import TimedLong
    from rtkit.component.base import Component
    from rtkit.component.ports.out_port import OutPort

    class Source(Component):
        """What the samples' console source declares."""

        out = OutPort(TimedLong)

    def make() -> None:
        for index in range(count):
            Source(f"N{index}").initialize()

    return timed(make)


def _forked(forks: Forks) -> Callable[[int], float]:
    return lambda count: forks.ask("fork", count)
