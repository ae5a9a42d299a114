"""Applies the settings of an execution context to the thread that drives it, and to its process.

What the system refuses is told, and the components run without it.
"""

from __future__ import annotations

import os
import resource
from _thread import get_native_id
from collections.abc import Mapping

from rtkit.component.contexts.context import ExecutionContext
from rtkit.container import processors
from rtkit.container.collector_between import CollectorBetween
from rtkit.container.process_wishes import USUAL_SWITCH_S, Wish, freeze, wishes
from rtkit.errors import Malformed, Refused
from rtkit.logs.late import late
from rtkit.rtc.context_settings import (
    CPU_AFFINITY,
    PRIORITY,
    SCHED_POLICY,
    CollectorMode,
    SchedulingPolicy,
    ThreadSettings,
    check_settings,
    is_setting,
    read_thread_settings,
)

_log = late(__name__)
_USUAL_SLACK_NS = 50_000
_LEAST_SWITCH_S = 100e-6
_POLICIES = {
    SchedulingPolicy.OTHER: os.SCHED_OTHER,
    SchedulingPolicy.FIFO: os.SCHED_FIFO,
    SchedulingPolicy.RR: os.SCHED_RR,
}


def check(options: Mapping[str, str]) -> None:
    """Refuse settings of contexts that make no sense, before a component is made.

    Raises:
        Malformed: One cannot be read; names it.
        Refused: A processor is not there.
    """
    check_settings(options)
    for key, text in options.items():
        if key.endswith(f".{CPU_AFFINITY}") and is_setting(key) and text.strip():
            _check_processors(key, text)


def _check_processors(key: str, text: str) -> None:
    from rtkit.settings.values import processors as read

    there = range(os.cpu_count() or 1)
    try:
        wanted = read(text)
    except Malformed as error:
        raise Malformed(f"{key}: {error}") from None
    if wanted.isdisjoint(there):
        known = ",".join(map(str, there))
        raise Refused(f"{key}: no such processors: {text} (there are {known})")


class ContextThread:
    """Settings of the thread that drives a context; used by that thread only.

    Attributes:
        is_collecting: Whether the thread is to collect garbage between two periods.
    """

    def __init__(self, context: ExecutionContext) -> None:
        self._context = context
        self._applied: tuple[Mapping[str, str], float] | None = None
        self._settings = ThreadSettings()
        self._mode = CollectorMode.ON
        self._has_slack = False
        self._collector = CollectorBetween()
        self.is_collecting = False

    @property
    def is_current(self) -> bool:
        """Return whether the settings are those that the context has now."""
        return self._applied == (self._context.properties, self._context.rate)

    def apply(self) -> None:
        """Apply the settings that the context has now, and note what the system refuses."""
        context = self._context
        self._applied = context.properties, context.rate
        period_s = 1 / context.rate if context.is_periodic else 0.0
        refused = []
        try:
            wanted = read_thread_settings(context.properties)
        except Malformed as error:  # in a profile that a stand-in was made from
            wanted = ThreadSettings()
            refused.append(str(error))
        refused += [
            processors.begin(context.properties.get(CPU_AFFINITY, "")),
            self._schedule(wanted),
            wishes.state(
                self,
                Wish(wanted.locks_memory, wanted.collector, _switch_s(period_s)),
            ),
        ]
        if period_s:
            self._limit_slack(int(period_s * 1e6))
        self._mode = wanted.collector
        self.is_collecting = context.is_periodic and self._mode is CollectorMode.BETWEEN
        self._note_trouble("; ".join(filter(None, refused)))

    def begin_cycles(self) -> None:
        """Freeze what components made when they were activated, before the first cycle."""
        if self._mode is not CollectorMode.ON:
            freeze()

    def end(self) -> None:
        """Leave the thread and the process as they were."""
        self._schedule(ThreadSettings())
        wishes.drop(self)
        processors.end()
        if self._has_slack:
            _set_slack(0)
            self._has_slack = False
        self._applied = None

    def collect(self, until_ns: int) -> None:
        """Collect garbage if it is time and there is time until then [ns]."""
        self._collector.collect(until_ns)

    def _note_trouble(self, trouble: str) -> None:
        context = self._context
        if trouble == context.trouble:
            return
        context.trouble = trouble
        context.notify()
        if trouble:
            _log().warning("context %s of %s runs without %s", context.id, context.owner, trouble)

    def _schedule(self, wanted: ThreadSettings) -> str:
        """Have the present thread scheduled like that; return why not."""
        before = self._settings
        if (wanted.policy, wanted.priority) == (before.policy, before.priority):
            return ""
        # Threads and processes that a component starts do not inherit it.
        policy = _POLICIES[wanted.policy] | os.SCHED_RESET_ON_FORK
        try:
            os.sched_setscheduler(0, policy, os.sched_param(wanted.priority))
        except OSError as error:
            limit, _ = resource.getrlimit(resource.RLIMIT_RTPRIO)
            asked = f"{SCHED_POLICY} {wanted.policy}, {PRIORITY} {wanted.priority}"
            return f"{asked}: {error.strerror} (RLIMIT_RTPRIO is {limit})"
        self._settings = wanted
        return ""

    def _limit_slack(self, slack_ns: int) -> None:
        """Have the kernel wake this thread at most so late, to save power [ns]."""
        if self._has_slack or slack_ns < _USUAL_SLACK_NS:
            self._has_slack = _set_slack(min(_USUAL_SLACK_NS, slack_ns))


def _switch_s(period_s: float) -> float:
    """Return how long another thread may compute until one of this period goes on [s]."""
    return min(USUAL_SWITCH_S, max(_LEAST_SWITCH_S, period_s / 10)) if period_s else USUAL_SWITCH_S


def _set_slack(slack_ns: int) -> bool:
    """Set the slack of timers of the present thread, 0 for the usual one; False if it cannot be."""
    try:
        with open(f"/proc/{get_native_id()}/timerslack_ns", "w", encoding="ascii") as file:
            file.write(str(slack_ns))
    except OSError as error:  # a sandbox without that file; the thread is woken 50 us later
        _log().debug("the slack of timers stays as it is: %s", error)
        return False
    return True
