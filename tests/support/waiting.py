"""Waits for what other processes bring about, and tells of processes what tests ask most often."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from rtkit.deployment.facts import ComponentFacts
from rtkit.tree.client import Tree

if TYPE_CHECKING:
    from shells import Shell

T = TypeVar("T")
BOUND_S = 50.0
"""How long anything may take on a machine with other work; less than a test may take in all."""


def until(is_so: Callable[[], T], what: str) -> T:
    """Wait for something to be so, and return it."""
    deadline = time.monotonic() + BOUND_S
    while not (found := is_so()):
        assert time.monotonic() < deadline, what
        time.sleep(0.005)
    return found


def has_ended(pid: int) -> bool:
    """Return whether a process runs no more."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return True


def facts_of(tree: Tree, instance: str) -> ComponentFacts:
    """Return what a manager tells of a component that there is."""
    facts = tree.snapshot().component(instance)
    assert facts is not None
    return facts


def slave_pid(tree: Tree, name: str) -> int:
    """Return the process id of a slave."""
    (pid,) = [process.pid for process in tree.snapshot().processes if process.name == name]
    return pid


def told_pid(shell: Shell, slave: str = "") -> int:
    """Return the process id that `rtcat` tells of a slave, or of the manager."""
    path = "/localhost/manager.mgr" + f"/{slave}.mgr" * bool(slave)
    pid: int = json.loads(shell.ok(f"rtcat --json {path}"))["pid"]
    return pid
