"""System calls that fail, or at which a process is killed: the N-th of each kind, from outside.

The rule is that of named points (see `docs/faults.md`). N counts up until nothing has failed any
more; of the files that a command opens only rtkit's own are tried, not those that Python imports.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import pytest
import syscallkit
from faultkit import Operation, Site, State, counted, tried
from operations import OPERATIONS
from syscallkit import AtCall, Strike

Shells = Callable[[], AbstractContextManager[Any]]

KILL = "signal=KILL"


def try_one(
    shells: Shells, operation: Operation, before: State, after: State, strike: Strike
) -> bool:
    """Try one; False when there was no such call any more."""
    with shells() as shell:
        breach = AtCall(strike)
        tried(Site(shell), operation, before, after, breach)
    return breach.has_struck


@pytest.mark.campaign
@pytest.mark.parametrize("action", [KILL, "error=ENOSPC", "error=EIO", "error=EMFILE"])
@pytest.mark.parametrize("call", syscallkit.CALLS)
@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.timeout(3600)
def test_every_call_of_a_daemon(shells: Shells, name: str, call: str, action: str) -> None:
    operation = OPERATIONS[name]
    with shells() as shell:
        before, after, _ = counted(Site(shell), operation)
    for target in ("manager", "zygote"):
        number = 1
        while try_one(shells, operation, before, after, Strike(target, call, action, number)):
            number += 1
