"""Deletes components and ends slaves: in order where they answer, by force where requested.

A component cannot be ended while one of its callbacks does not come back: only its process can,
with everything else in it.
"""

from __future__ import annotations

from collections.abc import Generator
from contextlib import suppress
from typing import Any

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.errors import NotFound, Refused, RtkitError, Unreachable
from rtkit.manager.core.effects import Call, Effect, Procedure
from rtkit.manager.core.events import OWN_PROCESS
from rtkit.manager.core.name_reservations import at_rest
from rtkit.manager.core.state import ManagerState, Process
from rtkit.manager.core.stopping import end_slaves, grace_s, retire
from rtkit.manager.core.wiring import cut

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
        raise NotFound(f"no component named {instance}")
    if action.slave not in ("", process.name):
        raise NotFound(f"no component named {instance} in {action.slave}: it is in {process.name}")
    if instance in state.ending and not action.is_forced:
        raise Refused(f"{instance} is just being deleted")
    if process.unfit and not facts.zombie and not action.is_forced:
        raise Unreachable(f"{process.unfit}; {remedy(state, process, instance)}")
    state.ending.add(instance)
    others: list[str] = []
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
    return Result(value=",".join(others))


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
    yield from end_slaves([process], grace_s(state))
    if process.is_alive:
        raise Unreachable(f"slave {process.name} has not ended, though it was killed")
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
