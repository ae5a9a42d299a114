"""Drives one execution context by a thread, only while the context has work.

A periodic one is driven at absolute deadlines, an event-driven one when an event arrives. A context
whose components are all at rest costs no thread at all.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import NamedTuple, Protocol

from rtkit.component.contexts.context import ExecutionContext
from rtkit.component.contexts.period import Period
from rtkit.component.contexts.waiting import DrivenThread, grant_by
from rtkit.container.bell import Bell
from rtkit.container.context_thread import ContextThread
from rtkit.container.missed_periods import MissedPeriods
from rtkit.link.threads import start_thread


class Work(NamedTuple):
    """Work of a context: its cycles, their time, the longest and the latest one of late [ns]."""

    ticks: int = 0
    busy_ns: int = 0
    longest_ns: int = 0
    latest_ns: int = 0


class Driver(Protocol):
    """Thread at the work of a pacer, or the part of a borrowed one's time."""

    def join(self, timeout: float | None = None) -> None:
        """Wait until the work is done."""

    def is_alive(self) -> bool:
        """Return whether the work is under way."""


StartDriver = Callable[[Callable[[], object], str], Driver]


class Pacer:
    """Drives one execution context.

    Args:
        context: The one that is driven.
        name: Name of its thread.
        grant: Grants the callback that is under way more time [ns].
        start: Starts its work; by default on a thread of its own.
    """

    def __init__(
        self,
        context: ExecutionContext,
        name: str,
        grant: Callable[[int], object] | None = None,
        start: StartDriver = start_thread,
    ) -> None:
        self._context = context
        self._name = name
        self._grant = grant
        self._start = start
        self._lock = threading.Lock()
        self._thread: Driver | None = None
        self._alarm = Bell()
        self._is_closed = False
        self._ticks = 0
        self._busy_ns = 0
        self._longest_ns = 0
        self._latest_ns = 0
        self._driven: DrivenThread | None = None
        context.wake = self.wake

    def wake(self) -> None:
        """Have pending requests served at once, by the thread or by a new one.

        Raises:
            Refused: None can be had; the next `wake` tries again.
        """
        self._alarm.ring()
        with self._lock:
            if self._thread is None and not self._is_closed:
                self._thread = self._start(self._run, self._name)

    @property
    def is_resting(self) -> bool:
        """Return whether nothing is done, and nothing was requested."""
        with self._lock:
            return self._thread is None and not self._alarm.is_ringing

    def work(self) -> Work:
        """Return what was done so far; longest and latest cycle are those since the last call."""
        longest_ns, self._longest_ns = self._longest_ns, 0
        latest_ns, self._latest_ns = self._latest_ns, 0
        return Work(self._ticks, self._busy_ns, longest_ns, latest_ns)

    def stop(self) -> None:
        """Have the thread end after its present tick, and none begin."""
        with self._lock:
            self._is_closed = True
        self._alarm.ring()

    def close(self, timeout_s: float) -> bool:
        """Let the thread end after its present tick; False if it does not within `timeout_s`."""
        self.stop()
        thread = self._thread
        if thread is None or thread is threading.current_thread():
            return True
        thread.join(timeout_s)
        return not thread.is_alive()

    def _run(self) -> None:
        self._driven = grant_by(self._grant)
        thread = ContextThread(self._context)
        try:
            thread.apply()
            if self._context.is_periodic:
                self._run_at_rate(thread)
            else:
                self._run_when_due(thread)
        except BaseException:  # only what may end the process: another thread ends what is left
            self._thread = None
            raise
        finally:
            thread.end()
            grant_by(None)

    def _run_when_due(self, thread: ContextThread) -> None:
        context, alarm = self._context, self._alarm
        while not self._rest():
            alarm.silence()
            if not thread.is_current:
                thread.apply()
            began_ns = time.monotonic_ns()
            context.tick()
            self._count(time.monotonic_ns() - began_ns - self._idle_ns())
            if not context.is_due and not context.is_idle:
                alarm.wait()

    def _run_at_rate(self, thread: ContextThread) -> None:
        context, missed = self._context, MissedPeriods(self._context)
        period = Period(context.rate, time.monotonic_ns())
        while not self._rest():
            self._alarm.silence()
            if context.has_requests:
                is_to_begin = not context.has_work
                context.serve_requests()
                if is_to_begin and context.has_work:
                    thread.begin_cycles()
                if is_to_begin:  # while a component was activated there was no period to miss
                    period.restart(time.monotonic_ns())
            if context.rate != period.rate:
                period.change_rate(context.rate, time.monotonic_ns())
            if not thread.is_current:
                thread.apply()
            self._keep(period, thread, missed)
        missed.report(time.monotonic_ns(), is_last=True)

    def _keep(self, period: Period, thread: ContextThread, missed: MissedPeriods) -> None:
        """Have a cycle whenever one is due, until the alarm rings or nothing is to be done.

        All that can be done before the thread waits is done there: less is left after it.
        """
        context, alarm = self._context, self._alarm
        while True:
            began_ns = time.monotonic_ns()
            if began_ns >= period.deadline_ns:
                context.deadline_ns = period.deadline_ns
                context.tick()
                ended_ns = time.monotonic_ns()
                idle_ns = self._idle_ns()
                self._count(ended_ns - began_ns - idle_ns)
                self._latest_ns = max(self._latest_ns, began_ns - period.deadline_ns)
                if idle_ns:  # while somebody was waited for there was no period to miss
                    period.restart(ended_ns)
                skipped = period.skipped
                period.advance(ended_ns, began_ns)
                if period.skipped != skipped:
                    missed.add(period.skipped - skipped, ended_ns)
                missed.report(ended_ns)
                if thread.is_collecting:
                    thread.collect(period.deadline_ns)
            if context.is_idle:
                return
            delay = period.wait_s(time.monotonic_ns())
            if delay:
                alarm.wait(delay)
            if alarm.is_ringing:
                return

    def _idle_ns(self) -> int:
        """Return how long the last cycle waited for people [ns]."""
        return self._driven.take_idle_ns() if self._driven is not None else 0

    def _count(self, spent_ns: int) -> None:
        self._ticks += 1
        self._busy_ns += spent_ns
        if spent_ns > self._longest_ns:
            self._longest_ns = spent_ns

    def _rest(self) -> bool:
        """End the thread when nothing is to be done; a later `wake` makes another."""
        with self._lock:
            if self._is_closed or (self._context.is_idle and not self._alarm.is_ringing):
                self._thread = None
                return True
            return False
