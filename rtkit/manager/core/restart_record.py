"""Restart history of a component, kept for the next manager too."""

from __future__ import annotations

from rtkit.deployment.facts import RestartStatus
from rtkit.deployment.supervision import Ledger
from rtkit.fast_dataclass import dataclass, field


@dataclass(frozen=True, slots=True)
class RestartRecord:
    """Record of the restarts of a component, past and pending.

    Attributes:
        ledger: By what the law of restarts judges; its times are of this run of the machine.
        restarts: How often its policy made it again.
        why: For which end it was the last time.
        took_s: How long that took [s].
        pending: For which end it is to be restarted; empty when it is not.
        given_up: Why it is restarted no more.
        is_in_error: It is, and that was answered.
        rested: Which rule it broke for which it was deactivated.
        halted: For which loss everything was deactivated, since it is critical.
    """

    ledger: Ledger = field(default_factory=Ledger)
    restarts: int = 0
    why: str = ""
    took_s: float = 0.0
    pending: str = ""
    given_up: str = ""
    is_in_error: bool = False
    rested: str = ""
    halted: str = ""

    @property
    def record(self) -> RestartRecord:
        """Return what remains of the record once all failures are forgiven."""
        return RestartRecord(restarts=self.restarts, why=self.why, took_s=self.took_s)

    @property
    def is_in_hand(self) -> bool:
        """Return whether a restart is pending, or was given up."""
        return bool(self.pending or self.given_up)

    @property
    def due_s(self) -> float:
        """Return when the restart is due, monotonic [s]; 0 without one."""
        return self.ledger.times[-1] if self.pending and self.ledger.times else 0.0

    def told(self, degraded: str) -> RestartStatus:
        """Return the restart status, with the rule of health that it breaks."""
        return RestartStatus(
            self.restarts,
            self.why,
            self.took_s,
            self.pending,
            self.given_up,
            degraded,
            self.rested,
            self.halted,
            self.due_s,
        )
