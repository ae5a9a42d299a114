"""System calls that fail, or at which a process is killed: the N-th of each kind, from outside.

The rule is that of named points (see `docs/faults.md`).
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from typing import Any

import pytest
import syscallkit
from faultkit import Operation, Site, State, counted, tried
from operations import OPERATIONS
from syscallkit import AtCall, Strike, numbers_of

Shells = Callable[[], AbstractContextManager[Any]]
KILL, EIO, ENOSPC = "signal=KILL", "error=EIO", "error=ENOSPC"
EMFILE, EAGAIN = "error=EMFILE", "error=EAGAIN"

HERE_AND_THERE: dict[str, dict[Strike, str]] = {
    "start": {
        Strike("command", "execve", EIO, 1): "cannot start a manager: .*Input/output error",
        Strike("command", "openat", EMFILE, 1, "run/manager.lock"): "Too many open files",
        Strike("command", "openat", ENOSPC, 1, "state/manager.log"): "",
    },
    "create": {
        Strike("zygote", "clone", EAGAIN, 1): "cannot fork: Resource temporarily unavailable",
        Strike("zygote", "sendmsg", KILL, 1): "",
        Strike("loop", "sendmsg", KILL, 1): "",
    },
    "activate": {Strike("slave", "clone", EAGAIN, 1): "no thread can be had"},
    "connect": {Strike("slave", "clone", EAGAIN, 1): "Failed to make connection"},
    "delete": {Strike("loop", "sendmsg", KILL, 2): ""},
    "cryo": {
        Strike("command", "fsync", EIO, 1): "cannot write out.xml: Input/output error",
        Strike("command", "rename", KILL, 1): "",
    },
    "resurrect": {Strike("command", "sendmsg", KILL, 4): ""},
}
"""What to try at each commit, and what is told then."""

DAEMONS = ("manager", "zygote", "slave")

pytestmark = pytest.mark.skipif(bool(syscallkit.missing()), reason=syscallkit.missing())


def known(shells: Shells, operation: Operation) -> tuple[State, State]:
    """Carry an operation out in peace; return what lived before and after."""
    with shells() as shell:
        return counted(Site(shell, has_points=False), operation)[:2]


def struck(shells: Shells, operation: Operation, states: tuple[State, State], at: AtCall) -> AtCall:
    """Carry an operation out with something happening."""
    with shells() as shell:
        tried(Site(shell, has_points=False), operation, *states, at)
    return at


@pytest.mark.parametrize("name", HERE_AND_THERE)
def test_calls_here_and_there(shells: Shells, name: str) -> None:
    operation = OPERATIONS[name]
    states = known(shells, operation)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        breaches = [AtCall(strike) for strike in HERE_AND_THERE[name]]
        trials = [pool.submit(struck, shells, operation, states, breach) for breach in breaches]
    for trial, (strike, why) in zip(trials, HERE_AND_THERE[name].items(), strict=True):
        breach = trial.result()
        assert breach.has_struck, f"{strike}: there was no such call"
        assert re.search(why, breach.told), f"{strike}: {breach.told!r}"


@pytest.mark.campaign
@pytest.mark.parametrize("action", [KILL, ENOSPC, EIO, EMFILE, EAGAIN])
@pytest.mark.parametrize("call", syscallkit.CALLS)
@pytest.mark.parametrize(
    "name", [name for name in OPERATIONS if name not in ("start", "find again")]
)
@pytest.mark.timeout(3600)
def test_every_call_of_a_daemon(shells: Shells, name: str, call: str, action: str) -> None:
    """N counts up until there was no such call any more."""
    operation = OPERATIONS[name]
    states = known(shells, operation)
    for target in DAEMONS:
        number = 1
        while struck(
            shells, operation, states, AtCall(Strike(target, call, action, number))
        ).has_struck:
            number += 1


@pytest.mark.campaign
@pytest.mark.parametrize("action", [KILL, ENOSPC, EIO, EMFILE, EAGAIN])
@pytest.mark.parametrize("call", syscallkit.CALLS)
@pytest.mark.parametrize("name", ["start", "find again", "resurrect", "cryo", "start plan"])
@pytest.mark.timeout(3600)
def test_every_call_of_a_command(shells: Shells, name: str, call: str, action: str) -> None:
    """Of the files that it opens only rtkit's own, not those that Python imports."""
    operation = OPERATIONS[name]
    states = known(shells, operation)
    with shells() as shell:
        site = Site(shell, has_points=False)
        operation.prepare(site)
        numbers = numbers_of(site, operation.line, "command", call)
    for number in numbers:
        struck(shells, operation, states, AtCall(Strike("command", call, action, number)))
