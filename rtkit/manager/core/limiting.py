"""Limits slaves: passes limits to the shell, checks the host, ends slaves that reach one."""

from __future__ import annotations

import logging

from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.limits import (
    NO_LIMITS,
    SlaveLimits,
    exhausted,
    limits_in,
    needs_slave,
    overbooked,
)
from rtkit.errors import Refused
from rtkit.manager.core.deletion import HANGING_S, end_slaves
from rtkit.manager.core.events import OWN_PROCESS, Instruction, LimitSlave
from rtkit.manager.core.state import NOWHERE, ManagerState, Process
from rtkit.manager.core.tasks import Tasks, ignored
from rtkit.rtc.enums import LifeCycleState

_log = logging.getLogger(__name__)
_END_S = 5.0
"""How long the end of a slave may take that has reached a limit [s]."""


class Limiting:
    """Passes the limits of each slave to the shell, and ends slaves that reach one.

    It costs nothing while no component has limits.
    """

    def __init__(self, state: ManagerState, out: list[Instruction], tasks: Tasks) -> None:
        self._state = state
        self._out = out
        self._tasks = tasks
        self._told: dict[int, SlaveLimits] = {}

    def run(self) -> None:
        """Pass on the limits that have changed since the last time."""
        if not self._state.limits and not self._told:
            return
        processes = self._state.processes
        now = dict(_by_process(self._state))
        for key in [key for key in self._told if key not in processes]:
            del self._told[key]
        for key in {**self._told, **now}:
            limits, process = now.get(key, NO_LIMITS), processes.get(key)
            if process is None or not process.is_slave or not (process.is_alive and process.pid):
                continue
            if limits != self._told.get(key, NO_LIMITS):
                self._told[key] = limits
                # Before what is sent to it, or its first component would be made without.
                self._out.insert(0, LimitSlave(key, process.pid, limits))

    def reached(self, key: int, why: str) -> None:
        """End a slave that has reached a limit; what comes back, its loss decides."""
        process = self._state.processes.get(key)
        if process is None or not process.is_alive or not process.is_wanted:
            return
        _log.error("slave %s is ended: %s", process.name, why)
        process.verdict = why
        self._tasks.begin(end_slaves([process], HANGING_S), _END_S, ignored)

    def on_facts(self, facts: ComponentFacts) -> None:
        """Take note of how a component is: one that failed for a limit has reached it."""
        if facts.instance not in self._state.limits or not facts.cause:
            return
        process = self._state.process_of(facts.instance)
        is_in_error = any(each.state is LifeCycleState.ERROR for each in facts.contexts)
        if process is not None and is_in_error:
            why = exhausted(self._told.get(process.key, NO_LIMITS), facts.cause)
            if why:
                self.reached(process.key, why)


def _by_process(state: ManagerState) -> dict[int, SlaveLimits]:
    """Return the limits of processes: the sum of the limits of the components in each."""
    found: dict[int, SlaveLimits] = {}
    for instance, limits in list(state.limits.items()):
        claim = state.claims.get(instance)
        if claim is None and instance not in state.components:
            del state.limits[instance]
            continue
        key = state.containers.get(instance, NOWHERE) if claim is None else claim.key
        found[key] = found.get(key, NO_LIMITS) + limits
    return found


def note_limits(state: ManagerState, instance: str, create: str) -> None:
    """Record the limits in a create string, from now on."""
    limits = limits_in(create)
    if limits:
        state.limits[instance] = limits
    else:
        state.limits.pop(instance, None)


def reserve(
    state: ManagerState, instance: str, create: str, process: Process | None = None
) -> None:
    """Note the limits of a component, if the host has as much and its process can be limited.

    Raises:
        Refused: It has not, with what living components may use already; or it is the manager's.
    """
    limits = limits_in(create)
    if limits:
        if process is not None and process.key == OWN_PROCESS:
            raise Refused(needs_slave(instance))
        reserved = {each: had for each, had in state.limits.items() if _is_there(state, each)}
        why = overbooked({**reserved, instance: limits}, state.capacity())
        if why:
            raise Refused(why)
    note_limits(state, instance, create)


def _is_there(state: ManagerState, instance: str) -> bool:
    facts = state.components.get(instance)
    is_alive = facts is not None and not facts.zombie
    return is_alive or instance in state.claims or instance in state.returning
