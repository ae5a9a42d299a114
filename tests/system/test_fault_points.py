"""Every operation, broken off at every named point that it passes, in whichever process."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from typing import Any

import pytest
from faultkit import AtPoints, Operation, Order, Site, State, counted, tried
from operations import OPERATIONS

Shells = Callable[[], AbstractContextManager[Any]]


def try_all(
    shells: Shells, trials: Iterable[tuple[Operation, State, State, Sequence[Order]]]
) -> None:
    """Try things one beside the other, as many as there are processors."""

    def one(trial: tuple[Operation, State, State, Sequence[Order]]) -> None:
        operation, before, after, orders = trial
        with shells() as shell:
            tried(Site(shell), operation, before, after, AtPoints(*orders))

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for outcome in [pool.submit(one, trial) for trial in trials]:
            outcome.result()


MANY_STEPS = (
    "resurrect",
    "apply",
    "start plan",
    "stop plan",
    "teardown",
    "cryo",
    "import",
    "configure",
)
"""What commands do in several steps, or to files; the others ask the manager once."""

DAEMONS = ("manager", "zygote", "slave", "holder")

SHOWN_ELSEWHERE = {
    "find again": r"manager\.(locked|logging|zygote_started|\w+_open|serving|ready)",
    "load": r"(zygote|slave)\.|manager\.(asked_for_slave|signalled|heard_of_end)",
    "create here": r"holder\.|manager\.(sending|answer)",
    "batch": r"(?!zygote\.forked|slave\.greeting|manager\.sending|holder\.did)",
    "disconnect": r"(?!manager\.sending|holder\.did)",
    "activate": r"(?!holder\.did|manager\.answering)",
    "stop": r"manager\.(sending|signalled)|holder\.(?!finalised)|slave\.holds_nothing|zygote\.",
}
"""Points of an operation that are tried at each commit with another one, which does the same."""


def is_usual(name: str, point: str) -> bool:
    """Whether to try a point at each commit: it says something that no other one says."""
    if re.match(SHOWN_ELSEWHERE.get(name, "(?!)"), point):
        return False
    is_daemon = point.partition(".")[0] in DAEMONS
    is_single = name not in MANY_STEPS
    return is_single if is_daemon else not (is_single and point.startswith("command."))


AT_EACH_COMMIT = ("create", "connect", "resurrect", "find again")
"""One operation of each kind: on a slave, on two components, of many steps, of a new manager."""


@pytest.mark.parametrize(
    "name",
    [
        name if name in AT_EACH_COMMIT else pytest.param(name, marks=pytest.mark.campaign)
        for name in OPERATIONS
    ],
)
@pytest.mark.timeout(600)
def test_killed_at_points(shells: Shells, name: str) -> None:
    operation = OPERATIONS[name]
    with shells() as shell:
        before, after, passed = counted(Site(shell), operation)
    points = [point for point in passed if is_usual(name, point)]
    assert points
    try_all(shells, [(operation, before, after, [Order(point, 1)]) for point in points])


@pytest.mark.campaign
@pytest.mark.parametrize("action", ["kill", "raise EIO", "raise ENOSPC", "delay 0.5", "stop"])
@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.timeout(3600)
def test_everything_at_every_pass(shells: Shells, name: str, action: str) -> None:
    operation = OPERATIONS[name]
    with shells() as shell:
        before, after, passed = counted(Site(shell), operation)
    orders = [
        Order(point, number, *action.split())
        for point, count in passed.items()
        for number in range(1, count + 1)
    ]
    try_all(shells, [(operation, before, after, [order]) for order in orders])


def test_who_may_be_broken_off(shell: Any) -> None:
    """A manager of root, only when it is told so; nobody whose orders others could write."""
    site = Site(shell)
    site.points.arm(Order("manager.locked", 1))
    if os.geteuid() == 0:
        why = "rtmgr: RTKIT_FAULT is set: a manager of root wants --allow-faults, too\n"
        assert shell.run("rtmgr start") == (1, "", why)
        assert shell.run("rtmgr start -o rtkit.allow_faults:NO") == (1, "", why)
    folder = shell.folder / "points"
    folder.chmod(0o750)
    status, _, err = shell.run("rtmgr start --allow-faults")
    assert (status, "of others, or open to them" in err) == (1, True)
    folder.chmod(0o700)
    assert "ended at once" in shell.run("rtmgr start -o rtkit.allow_faults:YES").err
    shell.ok("rtmgr start --allow-faults")
