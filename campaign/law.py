"""How long the law of restarts has each cell wait, counted along with the manager."""

from __future__ import annotations

from campaign.layout import MANAGER, NAMES, members
from campaign.schedule import Fault
from rtkit.deployment.supervision import (
    WINDOW_S,
    Ledger,
    RestartPolicy,
    RestartRule,
    at_end,
    at_health,
)

_POLICY = RestartPolicy(RestartRule.ON_FAILURE)
_NEVER_ALONE = frozenset(members(MANAGER))
"""Cells that die with the manager, whatever slaves die too."""


class Law:
    """What has been done about the ends of each cell so far."""

    def __init__(self) -> None:
        self._ledgers = [Ledger()] * len(NAMES)

    def room_at_s(self, fault: Fault) -> float:
        """Return when the cells that a fault ends may be made again once more, monotonic [s]."""
        times = [self._ledgers[cell].times for cell in self._by_law(fault)]
        least = _POLICY.limit - int(fault.is_pair)
        full = [each[-least] for each in times if len(each) >= least]
        return max(full, default=-WINDOW_S) + WINDOW_S

    def longest_wait_s(self, fault: Fault, now: float) -> float:
        """Take note of a fault at monotonic time `now` [s]; return how long its cells may wait."""
        longest_s = 0.0
        # What was due when the next manager is killed counts as tried.
        for cell in [*self._by_law(fault)] * (2 if fault.is_pair else 1):
            self._ledgers[cell], wait_s = at_end(self._ledgers[cell], _POLICY, now, 1.0)
            assert wait_s is not None, f"there is no room for {fault}"
            longest_s = max(longest_s, wait_s)
        return longest_s

    def well(self, now: float) -> None:
        """Take note that all are well at monotonic time `now` [s]."""
        self._ledgers = [at_health(each, now, is_well=True) for each in self._ledgers]

    def _by_law(self, fault: Fault) -> frozenset[int]:
        """Return the cells that a fault ends and that are made again as the law says."""
        if fault.is_total or fault.kind == "kill the manager":
            return frozenset()  # what dies with its manager is made again by the next one, at once
        return fault.renewed - _NEVER_ALONE if fault.slaves else fault.renewed
