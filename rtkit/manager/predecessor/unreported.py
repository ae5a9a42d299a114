"""Handles unreported slaves of an earlier manager: they hang, or are dead.

Their components are in their checkpoints (see `rtkit.container.slave_checkpoint`).
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping

from rtkit.container.orphans import is_stopped
from rtkit.container.slave_checkpoint import SUFFIX, SlaveCheckpoint, read_checkpoint
from rtkit.link import places, running
from rtkit.manager.core.events import SlaveExitedUnseen, SlaveFound

UNKNOWN = "exit status unknown"


def is_slave(manager: str, pid: int) -> bool:
    """Return whether a process is a slave of a manager of that name, not a stranger with its pid.

    A slave has its own heartbeats in memory, whatever it is called.
    """
    path = os.path.join(places.runtime_dir(), f"{manager}.{pid}.beats")
    try:
        with open(f"/proc/{pid}/maps", encoding="utf-8", errors="replace") as file:
            return any(line.rstrip("\n").endswith(f" {path}") for line in file)
    except OSError:
        return False


def living_slaves(manager: str) -> set[int]:
    """Return the pid of each slave that runs."""
    return {pid for pid in running.traces(manager, "beats") if is_slave(manager, pid)}


def checkpoints_of_the_dead(manager: str, living: Collection[int]) -> dict[int, SlaveCheckpoint]:
    """Return what the other slaves held, by pid; before anybody clears it away."""
    dead = (pid for pid in running.traces(manager, "held") if pid not in living)
    return {pid: held for pid in dead if (held := checkpoint_of(manager, pid)) is not None}


def checkpoint_of(manager: str, pid: int) -> SlaveCheckpoint | None:
    """Return what a slave holds, or held; None if nothing is known of it."""
    return read_checkpoint(os.path.join(places.runtime_dir(), f"{manager}.{pid}{SUFFIX}"))


class UnreportedSlaves:
    """Slaves that have not reported to the manager of that name yet.

    Args:
        dead: Components of processes that ended before it began, by pid.
    """

    def __init__(self, manager: str, dead: Mapping[int, SlaveCheckpoint]) -> None:
        self._manager = manager
        self._dead = dict(dead)
        self._ends: dict[int, str] = {}
        self._left: set[int] = set()
        self._is_settled = False

    def look(self, known: Collection[int]) -> None:
        """Find those that run; those that are known already need not be looked at."""
        others = {*running.traces(self._manager, "beats")} - {*known, os.getpid()}
        self._left = {pid for pid in others if is_slave(self._manager, pid)}

    def ended(self, pid: int, why: str) -> None:
        """Note the end of a process that had not come back, unless all has been reported."""
        if self._is_settled:
            return
        if pid not in self._dead:
            checkpoint = checkpoint_of(self._manager, pid)
            if checkpoint is None:
                return
            self._dead[pid] = checkpoint
        self._ends[pid] = why
        self._left.discard(pid)

    def is_worth_waiting(self, children: Collection[int], known: Collection[int]) -> bool:
        """Return whether a slave may still report: a child of an earlier zygote, or one found."""
        return any(not is_stopped(pid) for pid in (self._left | set(children)) - set(known))

    def settle(
        self, children: Mapping[int, str], known: Collection[int]
    ) -> Iterator[SlaveFound | SlaveExitedUnseen]:
        """Yield who did not come back, living and dead, once; `children` have names, or "" ."""
        for pid in sorted((self._left | set(children)) - set(known)):
            checkpoint = checkpoint_of(self._manager, pid)
            if pid not in children and not is_slave(self._manager, pid):
                self.ended(pid, UNKNOWN)
                continue
            name = (
                checkpoint.name if checkpoint is not None else children.get(pid) or f"slave_{pid}"
            )
            held = checkpoint.components if checkpoint is not None else []
            silence = "stopped" if is_stopped(pid) else "does not answer"
            yield SlaveFound(pid, name, held, [], silence=silence)
        for pid, checkpoint in self._dead.items():
            if checkpoint.components:
                why = self._ends.get(pid, UNKNOWN)
                yield SlaveExitedUnseen(
                    pid, checkpoint.name, checkpoint.components, why, why != UNKNOWN
                )
        self._is_settled = True
        self._dead.clear()
        self._ends.clear()
        self._left.clear()
