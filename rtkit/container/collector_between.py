"""Collects garbage in the time between two periods, where Python would do it within one."""

from __future__ import annotations

import gc
import time

_MOST_YOUNG = 100
"""How often the threshold of young objects may be passed until a collection waits no longer."""


class CollectorBetween:
    """Garbage collector of a process for the pauses of one execution context.

    A collection that lasted too long the last time waits for a longer pause. The memory stays
    bounded: when enough young objects have come together they are looked through all the same.
    """

    def __init__(self) -> None:
        self._took_ns = [0, 0, 0]

    def collect(self, until_ns: int) -> None:
        """Collect if it is time and there is time until then [ns]."""
        counts, thresholds = gc.get_count(), gc.get_threshold()
        if counts[0] <= thresholds[0]:
            return
        due = max(each for each in range(3) if counts[each] > thresholds[each])
        began_ns = time.monotonic_ns()
        left_ns = until_ns - began_ns
        generation = next((g for g in range(due, -1, -1) if 2 * self._took_ns[g] < left_ns), None)
        if generation is None and counts[0] > _MOST_YOUNG * thresholds[0]:
            generation = 0
        if generation is not None:
            gc.collect(generation)
            self._took_ns[generation] = time.monotonic_ns() - began_ns
