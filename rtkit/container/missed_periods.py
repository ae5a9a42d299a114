"""Counts the periods of an execution context at which nothing was done, and reports them."""

from __future__ import annotations

from rtkit.component.contexts.context import ExecutionContext
from rtkit.logs.late import late

_log = late(__name__)
_WINDOW_NS = 1_000_000_000
"""For how long periods are counted until they are reported."""
_BETWEEN_LINES_NS = 60_000_000_000
_WORTH_A_LINE = 0.01
"""Share of periods that is logged when it is missed; any is counted."""


class MissedPeriods:
    """Missed periods of one context; used by the thread that drives it.

    They are counted in the context, reported at most once a second, and logged once a minute.
    """

    def __init__(self, context: ExecutionContext) -> None:
        self._context = context
        self._before = context.missed
        self._began_ns = 0
        self._logged_ns = -_BETWEEN_LINES_NS

    def add(self, count: int, now_ns: int) -> None:
        """Count periods that were missed just now."""
        if self._context.missed == self._before:
            self._began_ns = now_ns
        self._context.missed += count

    def report(self, now_ns: int, *, is_last: bool = False) -> None:
        """Report what was missed if it is time for that."""
        context = self._context
        if context.missed == self._before:
            return
        elapsed_ns = now_ns - self._began_ns
        if elapsed_ns < _WINDOW_NS and not is_last:
            return
        missed = context.missed - self._before
        self._before = context.missed
        context.notify()
        periods = max(missed, round(max(elapsed_ns, _WINDOW_NS) / 1e9 * context.rate))
        is_time = now_ns - self._logged_ns >= _BETWEEN_LINES_NS
        if is_time and missed >= _WORTH_A_LINE * periods:
            self._logged_ns = now_ns
            _log().warning(
                "context %s of %s missed %d of %d periods (%g Hz), %d in all",
                context.id,
                context.owner,
                missed,
                periods,
                context.rate,
                context.missed,
            )
