"""Rate limit of one client: a burst of requests at once, then as many a second as are earned."""

from __future__ import annotations


class RateLimit:
    """Requests that one client has left.

    Args:
        rate: Requests in a second; also how many may come at once.
        now: Present time [s, of a clock that never goes back].
    """

    def __init__(self, rate: int, now: float) -> None:
        self._rate = rate
        self._left = float(rate)
        self._at = now

    def takes(self, now: float) -> bool:
        """Return whether one more request may be made; then it counts."""
        self._left = min(self._rate, self._left + (now - self._at) * self._rate)
        self._at = now
        if self._left < 1:
            return False
        self._left -= 1
        return True


def too_fast(rate: int) -> str:
    """Return the refusal for a client that asks too often."""
    return f"more than {rate} requests a second"
