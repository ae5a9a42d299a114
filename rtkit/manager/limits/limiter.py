"""Keeps slaves within their limits: samples their usage and reports the limit that one reaches.

Looks are the law. Between two of them resource limits of the kernel, with room above, hold a
process, and so does a control group where there can be one.

See decision 44.
"""

from __future__ import annotations

import logging
import resource
import time
from collections import deque
from math import inf

from rtkit.deployment.limits import (
    NO_LIMITS,
    WINDOW_S,
    SlaveLimits,
    TreeUsage,
    memory_reached,
    reached,
)
from rtkit.fast_dataclass import dataclass, field
from rtkit.manager.core.events import SlaveOverLimit
from rtkit.manager.limits import usage as tree
from rtkit.manager.limits.control_groups import ControlGroups, control_groups

LOOK_S = 0.05
"""How often what can run away is looked at [s]."""
_SLOWLY_S = 0.5
"""How often processor time is [s]."""
_DATA_ROOM = 512 << 20
"""How much more than its memory a slave may ask for: stacks of threads, mostly unused [bytes]."""
_FILE_ROOM = 64
"""How many more descriptors it can open until the next look."""
_NO_MEMORY = ("memory allocation of", "bad_alloc", "MemoryError", "out of memory")
"""Output of programs that could get no more, before they abort."""

_log = logging.getLogger(__name__)


@dataclass(slots=True)
class _Limited:
    """A slave with limits.

    Attributes:
        times: Processor time of the last `WINDOW_S`, as (moment, used) [s].
        shared_at: When what its processes share was last counted apart, monotonic [s].
        shared: How much that was [bytes].
    """

    pid: int
    limits: SlaveLimits
    look_at: float = 0.0
    is_reported: bool = False
    times: deque[tuple[float, float]] = field(default_factory=deque)
    shared_at: float = -inf
    shared: int = 0


class Limiter:
    """Observations of the slaves that have limits, by key."""

    def __init__(self, groups: ControlGroups | None = None) -> None:
        self._groups = control_groups() if groups is None else groups
        self._slaves: dict[int, _Limited] = {}

    @property
    def look_at(self) -> float:
        """Return when the next `look` has something to do, monotonic [s]."""
        return min((each.look_at for each in self._slaves.values()), default=inf)

    def limit(self, key: int, pid: int, limits: SlaveLimits) -> None:
        """Keep a slave within these limits from now on; without any, within none."""
        known = self._slaves.get(key)
        before = known.limits if known is not None else NO_LIMITS
        self._hold(pid, before, limits)
        if not limits:
            self._slaves.pop(key, None)
        elif known is None:
            self._slaves[key] = _Limited(pid, limits)
        else:
            known.limits, known.is_reported = limits, False

    def forget(self, key: int) -> None:
        """Let go of a slave that ended."""
        known = self._slaves.pop(key, None)
        if known is not None and self._groups is not None:
            self._groups.forget(known.pid)

    def look(self) -> list[SlaveOverLimit]:
        """Return which slaves have reached a limit since the last look; each is reported once."""
        now = time.monotonic()
        found = []
        for key, slave in self._slaves.items():
            if slave.look_at > now:
                continue
            why = "" if slave.is_reported else reached(slave.limits, _usage(slave, now))
            if why:
                slave.is_reported = True
                found.append(SlaveOverLimit(key, why))
            bare = SlaveLimits(processor=slave.limits.processor)
            slave.look_at = now + (_SLOWLY_S if slave.limits == bare else LOOK_S)
        return found

    def reason(self, key: int, reason: str, last: str) -> str:
        """Return why a slave ended, for which the kernel reports a reason."""
        slave = self._slaves.get(key)
        if slave is None or not slave.limits.memory:
            return reason
        groups, is_memory_named = self._groups, any(words in last for words in _NO_MEMORY)
        if groups is not None and groups.was_out_of_memory(slave.pid):
            return memory_reached(slave.limits, "the kernel gave no more")
        if is_memory_named and reason.startswith("signal"):
            return memory_reached(slave.limits, f"{reason}: {last}")
        return reason

    def _hold(self, pid: int, before: SlaveLimits, limits: SlaveLimits) -> None:
        """Have the kernel hold what runs away between two looks."""
        rooms = (
            (resource.RLIMIT_DATA, before.memory, limits.memory, tree.data_bytes(pid) + _DATA_ROOM),
            (resource.RLIMIT_NOFILE, before.descriptors, limits.descriptors, _FILE_ROOM),
        )
        try:
            for what, was, most, room in rooms:
                if was != most:
                    _set_limit(pid, what, most + room if most else 0)
            if self._groups is not None:
                self._groups.limit(pid, limits)
        except ProcessLookupError:
            _log.debug("process %d ended before it was limited", pid)
        except OSError as error:
            _log.warning("the kernel does not limit process %d, looks do: %s", pid, error)


def _set_limit(pid: int, what: int, most: int) -> None:
    """Set the soft limit of a process; 0 for that of this one. The hard one stays as it is."""
    _, hard = resource.prlimit(pid, what)
    own, _ = resource.getrlimit(what)
    soft = most or own
    if hard != resource.RLIM_INFINITY:
        soft = hard if soft == resource.RLIM_INFINITY else min(soft, hard)
    resource.prlimit(pid, what, (soft, hard))


def _usage(slave: _Limited, now: float) -> TreeUsage:
    """Return what a slave uses of what is limited; nothing when it is gone."""
    used, limits = tree.tree_usage(slave.pid), slave.limits
    if not used.pids:
        return TreeUsage()
    return TreeUsage(
        _memory(slave, used, now),
        len(used.pids),
        tree.descriptors(used.pids) if limits.descriptors else 0,
        _share(slave.times, now, used.cpu_s) if limits.processor else 0.0,
    )


def _memory(slave: _Limited, used: tree.Used, now: float) -> int:
    """Return the memory of a slave; what its processes share counts once where that decides."""
    most = slave.limits.memory
    if not most or used.memory < most or used.largest >= most:
        return used.memory
    if now - slave.shared_at >= _SLOWLY_S:
        slave.shared_at = now
        slave.shared = used.memory - tree.proportional_memory(used.pids)
    return max(used.largest, used.memory - slave.shared)


def _share(times: deque[tuple[float, float]], now: float, cpu_s: float) -> float:
    """Return the mean number of processors in use; 0 until it is that of the whole window."""
    times.append((now, cpu_s))
    while len(times) > 1 and now - times[1][0] >= WINDOW_S:
        times.popleft()
    began, had = times[0]
    return (cpu_s - had) / (now - began) if now - began >= WINDOW_S else 0.0
