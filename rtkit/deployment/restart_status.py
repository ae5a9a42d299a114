"""Restart status: the actions of restart policies and health rules, as users see them."""

from __future__ import annotations

from rtkit.fast_dataclass import dataclass


@dataclass(frozen=True, slots=True)
class RestartStatus:
    """Results of a policy and of health rules; each text is empty where nothing happened.

    Attributes:
        restarts: How often its policy made it again.
        why: For which end its policy made it again the last time.
        took_s: How long that took, from its end until it was as it had been [s].
        returning: For which end it is to be restarted, as long as it is not.
        given_up: Why it is restarted no more.
        degraded: Which rule of health it breaks that says so.
        rested: Which rule it broke for which it was deactivated.
        halted: For which loss everything was deactivated, since it is critical.
        due_s: When it is to be restarted, on the monotonic clock of its host [s]; 0 for never.
    """

    restarts: int = 0
    why: str = ""
    took_s: float = 0.0
    returning: str = ""
    given_up: str = ""
    degraded: str = ""
    rested: str = ""
    halted: str = ""
    due_s: float = 0.0

    @property
    def trouble(self) -> str:
        """Return the trouble of a component that answers; empty for none."""
        return f"degraded: {self.degraded}" if self.degraded else self.given_up

    @property
    def again(self) -> str:
        """Return how often its policy restarted it, and for what the last time; empty for never."""
        times = "once" if self.restarts == 1 else f"{self.restarts} times"
        return f"made again {times}, for {self.why}" if self.why else ""

    @property
    def stops(self) -> str:
        """Return why it, or for its sake everything, was deactivated; empty for nothing."""
        told = [f"deactivated: {self.rested}"] if self.rested else []
        told += [f"all was deactivated: {self.halted}"] if self.halted else []
        return "; ".join(told)

    @property
    def history(self) -> str:
        """Return the actions of its policy and rules so far; empty for none."""
        return "; ".join(filter(None, (self.again, self.stops)))
