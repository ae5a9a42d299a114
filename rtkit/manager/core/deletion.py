"""Ends components and slaves: in order where they answer, by force where requested.

A component cannot be ended while one of its callbacks does not come back: only its process can,
with everything else in it. Slaves that hold nothing any more end, too; at the end everything does.
"""

from __future__ import annotations

import signal
from collections.abc import Collection, Generator, Iterable, Mapping
from contextlib import suppress
from functools import partial
from itertools import pairwise
from typing import Any

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.errors import NotFound, Refused, RtkitError, Unreachable
from rtkit.manager.core.effects import (
    Call,
    Effect,
    Gather,
    Procedure,
    ReadClock,
    SendSignal,
    Sleep,
    WaitForEnds,
    WaitUntil,
)
from rtkit.manager.core.events import OWN_PROCESS
from rtkit.manager.core.registration import at_rest
from rtkit.manager.core.state import ManagerState, Process, no_component
from rtkit.manager.core.wiring import cut
from rtkit.rtc.far_ends import peer_of

FORCE_S = 1.0
"""How long a component that is ended by force has to end by itself [s]."""


def delete(state: ManagerState, action: act.Delete) -> Procedure:
    """Finalise a component and forget it; by force its process ends if it does not.

    Raises:
        NotFound: There is no such component, or it is in another process than the one named.
        Refused: It is being deleted, or its process is none that may be ended.
        Unreachable: It does not end; names what is stuck, and a fix.
    """
    instance = action.instance
    if instance not in state.ending:
        yield from at_rest(state, instance)
    facts = state.components.get(instance)
    process = state.process_of(instance)
    if facts is None or process is None:
        raise no_component(state, instance)
    if action.slave not in ("", process.name):
        raise NotFound(f"no component named {instance} in {action.slave}: it is in {process.name}")
    if instance in state.ending and not action.is_forced:
        raise Refused(f"{instance} is just being deleted")
    if process.unfit and not facts.zombie and not action.is_forced:
        raise Unreachable(f"{process.unfit}; {remedy(state, process, instance)}")
    state.ending.add(instance)
    others: list[str] = []
    note = _note_on_halves(state, instance)
    try:
        yield from _finalise(state, process, instance, FORCE_S * action.is_forced)
    except Unreachable as error:
        if not action.is_forced:
            raise _hopeful(state, process, instance, error) from error
        others = yield from _end_container(state, process, instance, error)
    finally:
        state.ending.discard(instance)
    state.forget(instance)
    state.kept.forget(instance)
    yield from retire(state, process)
    return Result(value=",".join(others), note=note)


def _note_on_halves(state: ManagerState, instance: str) -> str:
    """Return which managers that are away still have halves of connectors of a component."""
    peers = {peer_of(each) for each in state.connectors_of(instance)} - {"", *state.peers}
    away = ", ".join(sorted(peers))
    return f"other halves of its connections go when {away} is back" if away else ""


def _finalise(
    state: ManagerState, process: Process, instance: str, timeout_s: float
) -> Generator[Effect, Any, None]:
    if process.is_alive:
        with suppress(NotFound):  # an earlier request that was given up has come through
            yield Call(process, {"op": "delete", "instance": instance}, timeout_s, is_lasting=True)
    # Only now: if the manager is killed on the way, the component is there with its connectors or
    # not at all, for the next one cuts ends that lead nowhere.
    for connector in state.connectors_of(instance):
        yield from cut(state, connector)


def _end_container(
    state: ManagerState, process: Process, instance: str, why: RtkitError
) -> Generator[Effect, Any, list[str]]:
    """End the process of a component; return what else it held, which are zombies from then on."""
    if not process.is_alive:
        return []
    if not process.is_slave:
        whose = "the manager's own" if process.key == OWN_PROCESS else "a guest's"
        end = "; only rtmgr restart or rtmgr stop ends it" if process.key == OWN_PROCESS else ""
        raise Refused(f"{why}; it is in {whose} process, which is not ended by force{end}")
    others = [each for each in state.held_by(process.key) if each != instance]
    process.verdict = f"ended by force, with {instance}"
    yield from _end_slave(state, process)
    return others


def _hopeful(
    state: ManagerState, process: Process, instance: str, error: Unreachable
) -> RtkitError:
    """Return the error of a request that is given up, and done when it can be."""
    if not process.is_alive:
        return error
    queued = "the request stays queued and is done when that returns"
    return Unreachable(f"{error}; {queued}; {remedy(state, process, instance)}")


def remedy(state: ManagerState, process: Process, instance: str) -> str:
    """Return what a user can do about a component of a process that does not answer."""
    if process.key == OWN_PROCESS:
        return "only rtmgr restart or rtmgr stop ends the manager's own process, which it is in"
    if not process.is_slave:
        return f"it is in {process.name}, which came by itself (process {process.pid})"
    others = [each for each in state.held_by(process.key) if each != instance]
    along = f", and with it {', '.join(others)}" if others else ""
    return f"rtexit --force ends its slave {process.name}{along}"


def end_slave(state: ManagerState, action: act.EndSlave) -> Procedure:
    """End a slave with all that it holds; by force at once.

    Raises:
        NotFound: There is no such slave.
        Refused: It has ended already, or is none.
        Unreachable: Something in it does not end; names what is stuck, and a fix.
    """
    process = _slave(state, action.name)
    if not action.is_forced:
        if process.unfit:
            raise Unreachable(f"{process.unfit}; rtexit --force ends it")
        for instance in reversed(state.held_by(process.key)):
            yield from delete(state, act.Delete(instance))
    for instance in state.held_by(process.key):
        state.kept.forget(instance)
    return (yield from _end_slave(state, process))


def _end_slave(state: ManagerState, process: Process) -> Procedure:
    yield from end_slaves([process], grace_s(state))
    if process.is_alive:
        raise Unreachable(f"slave {process.name} has not ended, though it was killed")
    return Result()


def _slave(state: ManagerState, name: str) -> Process:
    named = [process for process in state.processes.values() if process.name == name]
    living = [process for process in named if process.is_alive and process.is_wanted]
    if not named:
        raise NotFound(f"no slave named {name}")
    if not living:
        raise Refused(f"slave {name} has ended already" + f": {named[0].reason}".rstrip(": "))
    if not living[0].is_slave:
        raise Refused(f"{name} is no slave: only slaves are ended so")
    return living[0]


FINALISE_S = 5.0
"""Grace that all components together have to finalise [s]."""

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
        try:
            yield WaitForEnds(meant, term_s)
        except Unreachable:
            for process in meant:
                process.is_overdue = process.is_alive
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
    """End all components, then all slaves.

    A component ends after those that were made later and are in its process, or connected with it;
    all others end side by side (decision 93). It never fails and never takes longer than its
    graces: components that did not come to their turn are finalised by their own process when it
    is asked to end.
    """
    began: float = yield ReadClock()
    ranks = {instance: number for number, instance in enumerate(state.components)}
    turns: dict[int, list[str]] = {}
    for instance in reversed(ranks):
        process = state.process_of(instance)
        if process is not None:
            turns.setdefault(process.key, []).append(instance)
    later, silent = _connected_later(state, ranks), set[int]()
    yield Gather(
        tuple(
            _finalise_in_turn(state, state.processes[key], each, later, silent, began + FINALISE_S)
            for key, each in turns.items()
        )
    )
    slaves = [p for p in state.processes.values() if p.is_slave and p.is_alive]
    yield from end_slaves(slaves, grace_s(state))
    return Result()


def _connected_later(state: ManagerState, ranks: Mapping[str, int]) -> dict[str, set[str]]:
    """Return the components that are connected with each and were made after it."""
    later: dict[str, set[str]] = {}
    for connector in state.connectors.values():
        ends = sorted(
            {end.instance for end in connector.ports} & ranks.keys(), key=ranks.__getitem__
        )
        for first, second in pairwise(ends):
            later.setdefault(first, set()).add(second)
    return later


def _finalise_in_turn(
    state: ManagerState,
    process: Process,
    instances: Iterable[str],
    later: Mapping[str, Collection[str]],
    silent: set[int],
    until: float,
) -> Procedure:
    """End the components of one process; in a process that is `silent` nothing is waited for."""

    def may_end(others: Collection[str]) -> bool:
        left = (state.process_of(each) for each in others)
        busy = (each for each in left if each is not None and each.is_alive)
        return state.is_in_haste or all(each.key in silent for each in busy)

    for instance in instances:
        yield WaitUntil(partial(may_end, later.get(instance, ())), "what it is connected with")
        now: float = yield ReadClock()
        if now >= until or state.is_in_haste or not process.is_alive:
            return Result()
        try:
            message = {"op": "delete", "instance": instance}
            yield Call(process, message, until - now, is_lasting=True)
        except RtkitError:
            silent.add(process.key)
            return Result()
        state.forget(instance)
    if process.is_slave and not state.held_by(process.key):
        yield from _terminate(process)  # it ends while others still finalise
    return Result()
