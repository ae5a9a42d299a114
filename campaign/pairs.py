"""Two faults on top of each other: killed and killed again, in a commit, with a full disk.

A value that is set meanwhile holds or does not: it is the same after everything was killed. What
was acknowledged holds.
"""

from __future__ import annotations

import resource
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress

from campaign.arena import Arena, end
from campaign.layout import NAMES, gain
from campaign.schedule import Fault
from rtkit.errors import Unreachable
from rtkit.link import places

_PATIENCE_S = 30.0
_MOST = 1000
"""What is set meanwhile is above what cells have in peace."""


class PromiseBroken(Exception):
    """Something is not as it was promised; says what."""


def kill_twice(arena: Arena, fault: Fault) -> float:
    """Kill the manager, with everything or with a slave, and then the next one in its start."""
    pids = [arena.manager, *(arena.slave(name) for name in fault.slaves)]
    if fault.is_total:
        pids += [arena.zygote(), *arena.slaves().values()]
    end(pids)
    with arena.starting() as start:
        end([_beginning(start)], after_s=fault.length_s)
    began = time.monotonic()
    arena.start_manager()
    return began


def _beginning(start: subprocess.Popen[str]) -> int:
    """Return the manager that is just being started, as soon as it has the lock."""
    deadline = time.monotonic() + _PATIENCE_S
    while time.monotonic() < deadline and start.poll() is None:
        owner = places.owner("manager")
        if owner:
            return owner
        time.sleep(0.001)
    raise TimeoutError("no manager begins")


def kill_in_commit(arena: Arena, fault: Fault) -> float:
    """Kill the manager while it sets a value, then everything."""
    new = str(_MOST + fault.cell)
    answer = arena.begin_to_set(fault.cell, new)
    end([arena.manager], after_s=fault.length_s)
    is_told = _is_acknowledged(answer)
    return _holds(arena, fault, new, must_hold=is_told)


def fill_disk(arena: Arena, fault: Fault) -> float:
    """Have a value set while the disk is full, then kill what the fault says."""
    new = str(_MOST + fault.cell)
    manager = arena.manager
    limits = resource.prlimit(manager, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
    try:
        is_told = _is_acknowledged(arena.begin_to_set(fault.cell, new))
        if fault.length_s:
            end([manager], after_s=fault.length_s)
    finally:
        with suppress(ProcessLookupError):
            resource.prlimit(manager, resource.RLIMIT_FSIZE, limits)
    if fault.length_s:
        return _holds(arena, fault, new, must_hold=True)  # the slave knows
    if is_told:
        raise PromiseBroken("a value was acknowledged that was on no disk")
    try:
        arena.until(lambda: not arena.trouble(), _PATIENCE_S)
    except TimeoutError:
        raise PromiseBroken(f"there is space again, but: {arena.trouble()}") from None
    return _lost_and_restored(arena, fault, new)


def _is_acknowledged(answer: Callable[[], bool]) -> bool:
    try:
        return answer()
    except Unreachable:
        return False


def _holds(arena: Arena, fault: Fault, new: str, *, must_hold: bool) -> float:
    """See what a value is now, and that it is the same after everything was killed."""
    arena.start_manager()
    arena.until(lambda: not arena.lacks(), _PATIENCE_S)
    found = arena.gain(fault.cell)
    if found not in (new, gain(fault.cell)) or (must_hold and found != new):
        raise PromiseBroken(f"{NAMES[fault.cell]}: gain is {found} instead of {new}")
    return _lost_and_restored(arena, fault, found)


def _lost_and_restored(arena: Arena, fault: Fault, found: str) -> float:
    """Kill everything; afterwards have the value set back that cells have in peace."""
    end([arena.manager, arena.zygote(), *arena.slaves().values()])
    began = time.monotonic()
    arena.start_manager()
    arena.until(lambda: not arena.lacks(), _PATIENCE_S)
    took_s = time.monotonic() - began
    now = arena.gain(fault.cell)
    arena.set_gain(fault.cell, gain(fault.cell))
    if now != found:
        raise PromiseBroken(f"{NAMES[fault.cell]}: gain was {found}, and is {now} when made again")
    return time.monotonic() - took_s
