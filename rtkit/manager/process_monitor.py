"""Sees how the processes of a manager fare: stuck callbacks, limits, halts, what they started."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from rtkit.container.stacks import ASK, STACK_SIGNAL, open_stacks, write_stacks
from rtkit.deployment.message import Message
from rtkit.link import places
from rtkit.logs.outputs import cut
from rtkit.manager.core import events as ev
from rtkit.manager.core.state import ManagerState
from rtkit.manager.duty import Duty
from rtkit.manager.ended_slave import with_exit_diagnostics
from rtkit.manager.predecessor.descendants import Descendants
from rtkit.manager.slaves.slave_supervisor import SlaveSupervisor
from rtkit.manager.slaves.watchdog import DEADLINE_S, Watchdog, callback_deadline_s, remove_traces

if TYPE_CHECKING:
    from rtkit.manager.limits.limiter import Limiter

TIDY_S = 1.0
"""Period in which processes are checked that report nothing of themselves [s]."""


class ProcessMonitor:
    """Watches the manager's own process, and its slaves.

    Args:
        state: The manager's.
        slave_supervisor: Has started the slaves.
        handle: Takes an event on the thread of the loop.
        post: Takes one from any thread.
        send: Sends a message to a slave of that key.
    """

    def __init__(
        self,
        state: ManagerState,
        slave_supervisor: SlaveSupervisor,
        handle: Callable[[ev.Event], object],
        post: Callable[[ev.Event], object],
        send: Callable[[int, Message], object],
    ) -> None:
        self._state = state
        self._slave_supervisor = slave_supervisor
        self._handle, self._post, self._send = handle, post, send
        self._watchdog = Watchdog(
            slave_supervisor.data_pattern, self._deadline_s, self._shortest_s, self._ask_for_stack
        )
        self._watchdog.watch(ev.OWN_PROCESS, state.pid)
        self._stacks = open_stacks(slave_supervisor.data_pattern, state.pid)
        self._limiter: Limiter | None = None  # made for the first slave with limits
        self._descendants: Descendants | None = None
        self._tidy_at = 0.0

    def duties(self) -> tuple[Duty, ...]:
        """Return what is to be done at certain times."""
        return (
            Duty("callbacks", self._look_at, self._look),
            Duty("limits", self._next_look_at_limits, self._look_at_limits),
            Duty("tidying", lambda: self._tidy_at if self._state.components else None, self._tidy),
        )

    def watch(self, key: int, pid: int, *, is_guest: bool = False) -> None:
        """Watch the callbacks of a process from now on."""
        self._watchdog.watch(key, pid, is_guest=is_guest)

    def hasten(self, key: int) -> None:
        """Look at a process soon: it has just said something."""
        self._watchdog.hasten(key)

    def halted(self, key: int, *, is_halted: bool) -> None:
        """Note that a process was stopped, or goes on."""
        self._watchdog.halted(key, is_halted=is_halted)

    def forget(self, key: int) -> None:
        """Watch a process no more: it has ended."""
        self._watchdog.forget(key)
        if self._limiter is not None:
            self._limiter.forget(key)

    def limit(self, instruction: ev.LimitSlave) -> None:
        """Keep a slave below its limits from now on."""
        if self._limiter is None:
            from rtkit.manager.limits.limiter import Limiter

            self._limiter = Limiter()
        self._limiter.limit(instruction.key, instruction.pid, instruction.limits)

    def inspect(self, key: int, age_s: float) -> None:
        """Post what callbacks of a process are at work for so long [s]."""
        for event in self._watchdog.inspect(key, age_s):
            self._post(event)

    def explained(self, event: ev.SlaveEnded) -> ev.SlaveEnded:
        """Return the end of a slave with its reason and last words."""
        limit_reason = self._limiter.reason if self._limiter is not None else None
        return with_exit_diagnostics(self._state, event, self._watchdog.instance_on, limit_reason)

    def close(self) -> None:
        """Leave no trace of the manager's own process."""
        self._watchdog.forget(ev.OWN_PROCESS)
        remove_traces(self._slave_supervisor.data_pattern, self._state.pid)  # watched or not
        os.close(self._stacks)

    # callbacks

    def _look_at(self) -> float | None:
        return self._watchdog.look_at if self._has_callbacks else None

    def _look(self) -> None:
        """See whether a callback is stuck."""
        for event in list(self._watchdog.poll()):
            self._handle(event)

    @property
    def _has_callbacks(self) -> bool:
        """Return whether there are components, or anything else that could be stuck."""
        state = self._state
        return bool(state.components or state.claims) or len(state.processes) > 1

    def _ask_for_stack(self, key: int, is_urgent: bool) -> None:
        if key == ev.OWN_PROCESS:
            write_stacks(self._stacks)
        elif is_urgent:
            process = self._state.processes.get(key)
            # A stopped one gets it later, and an attached one may do with signals what it likes.
            if process is not None and process.state == "up" and not process.is_guest:
                self._slave_supervisor.signal(key, STACK_SIGNAL)
        else:
            self._send(key, {"op": ASK})

    def _deadline_s(self, instance: str) -> float:
        facts = self._state.components.get(instance)
        return callback_deadline_s(facts.create if facts is not None else "")

    def _shortest_s(self) -> float:
        creates = (facts.create for facts in self._state.components.values())
        return min(map(callback_deadline_s, creates), default=DEADLINE_S)

    # limits

    def _next_look_at_limits(self) -> float | None:
        return self._limiter.look_at if self._limiter is not None else None

    def _look_at_limits(self) -> None:
        """See whether a slave has reached a limit."""
        assert self._limiter is not None
        for reached in self._limiter.look():
            self._handle(reached)

    # what reports nothing of itself

    def _tidy(self) -> None:
        """See who is stopped, and keep short what is written past logs."""
        self._tidy_at = time.monotonic() + TIDY_S
        for event in list(self._slave_supervisor.halts()):
            self._handle(event)
        self._note_descendants()
        for process in self._state.processes.values():
            if not process.is_guest:
                name = process.name if process.is_slave else ""
                cut(places.output_file(self._state.name, name))

    def _note_descendants(self) -> None:
        """Note what components in this process have started, should the manager be killed."""
        if self._descendants is None and ev.OWN_PROCESS in self._state.containers.values():
            self._descendants = Descendants(self._state.name)
        if self._descendants is not None:
            self._descendants.note(self._slave_supervisor.processes)
