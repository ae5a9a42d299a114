"""Stops slaves that hold nothing any more, and at the end everything, in order."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Generator, Iterable

from rtkit.deployment.actions import Result
from rtkit.errors import RtkitError, Unreachable
from rtkit.manager.core.effects import Call, Procedure, ReadClock, SendSignal, Sleep, WaitForEnds
from rtkit.manager.core.state import ManagerState, Process

FINALISE_S = 5.0
"""Grace that all components together have to finalise, one after the other [s]."""

TERM_S = 2.0
"""Grace between TERM and KILL, and after KILL [s]."""


HANGING_S = 0.1
"""The same for one in which something hangs: the rest of it has time to finalise [s]."""


def retire(state: ManagerState, process: Process) -> Procedure:
    """End a slave that holds nothing any more (``manager.shutdown_on_nortcs``)."""
    may_end = state.settings.flag("manager.shutdown_on_nortcs")
    if may_end and process.is_slave and process.is_ready and not state.is_needed(process.key):
        yield from end_slaves([process], grace_s(state))
    return Result()


def retire_unused(state: ManagerState, process: Process) -> Procedure:
    """End a slave in which nothing was made for long (``manager.shutdown_auto``)."""
    yield Sleep(state.settings.number("manager.auto_shutdown_duration"))
    if state.settings.flag("manager.shutdown_auto"):
        yield from retire(state, process)
    return Result()


def grace_s(state: ManagerState) -> float:
    """Return the grace between TERM and KILL from the manager's properties [s]."""
    return state.settings.number("manager.termination_waittime")


def end_slaves(slaves: Iterable[Process], term_s: float = TERM_S) -> Procedure:
    """End these processes: TERM, a grace, KILL; return when the kernel reported their end."""
    meant = tuple(slaves)
    for process in meant:
        yield from _terminate(process)
    try:
        yield WaitForEnds(meant, term_s)
    except Unreachable:
        for process in meant:
            if process.is_alive:
                yield SendSignal(process, signal.SIGKILL)
        with contextlib.suppress(Unreachable):
            yield WaitForEnds(meant, term_s)
    return Result()


def _terminate(process: Process) -> Generator[SendSignal, None, None]:
    """Send TERM, once, to a process that is wanted no longer."""
    if not process.is_wanted or not process.is_alive:
        return
    process.is_wanted = False
    yield SendSignal(process, signal.SIGTERM)
    if process.is_stopped:
        yield SendSignal(process, signal.SIGCONT)


def stop_everything(state: ManagerState) -> Procedure:
    """End all components in reverse order of their creation, then all slaves.

    It never fails and never takes longer than its graces: components that did not come to their
    turn are finalised by their own process when it is asked to end.
    """
    began: float = yield ReadClock()
    silent: set[int] = set()
    for instance in reversed(list(state.components)):
        process = state.process_of(instance)
        now: float = yield ReadClock()
        left_s = began + FINALISE_S - now
        if left_s <= 0 or state.is_in_haste:
            break
        if process is None or not process.is_alive or process.key in silent:
            continue
        try:
            yield Call(process, {"op": "delete", "instance": instance}, left_s, is_lasting=True)
        except RtkitError:
            silent.add(process.key)
        else:
            state.forget(instance)
            if process.is_slave and not state.held_by(process.key):
                yield from _terminate(process)  # it ends while others still finalise
    slaves = [p for p in state.processes.values() if p.is_slave and p.is_alive]
    yield from end_slaves(slaves, grace_s(state))
    return Result()
