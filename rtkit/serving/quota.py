"""Quota of an endpoint: access rules, rates and subscriptions of its clients."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from time import monotonic
from typing import Protocol

from rtkit.property.access import DEFAULT_LIMITS, AccessPolicy, AccessRule, EndpointLimits
from rtkit.property.codes import PropertyError
from rtkit.property.requests import ListeningRequester
from rtkit.property.subscription import Listener


class QuotaClient(Protocol):
    """Client that may listen."""

    @property
    def listening(self) -> int:
        """Return how many subscriptions it has."""


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
        if self.wait_s(now) > 0:
            return False
        self._left -= 1
        return True

    def wait_s(self, now: float) -> float:
        """Return how long to wait until one more request may be made [s]."""
        self._left = min(self._rate, self._left + (now - self._at) * self._rate)
        self._at = now
        return max(0.0, (1 - self._left) / self._rate)


def too_fast(rate: int) -> str:
    """Return the refusal for a client that asks too often."""
    return f"more than {rate} requests a second"


class EndpointQuota:
    """Rules and limits of one endpoint.

    Args:
        policy: Of all endpoints.
        endpoint: Name of the endpoint there.
        clients: Those there are now.
        last: Rules of the endpoint itself, behind those of the policy.
        limits: Where the policy says nothing else.

    Attributes:
        access: Access rules.
        limits: How much there is room for.
    """

    def __init__(
        self,
        policy: AccessPolicy,
        endpoint: str,
        clients: Callable[[], Sequence[QuotaClient]],
        last: Iterable[AccessRule] = (),
        limits: EndpointLimits = DEFAULT_LIMITS,
    ) -> None:
        self.access = policy.access(endpoint, last)
        self.limits = policy.limits(endpoint, limits)
        self._clients = clients

    def pace(self) -> RateLimit | None:
        """Return what bounds how often one client asks, None if nothing does."""
        return RateLimit(self.limits.rate, monotonic()) if self.limits.rate else None

    def check_listeners(self, listening: int) -> None:
        """Refuse one more listener.

        Raises:
            PropertyError: ``denied``: its client has enough, or all together have.
        """
        limits = self.limits
        if listening >= limits.listeners:
            raise PropertyError("denied", f"more than {limits.listeners} listeners")
        if sum(each.listening for each in self._clients()) >= limits.door_listeners:
            raise PropertyError(
                "denied", f"more than {limits.door_listeners} listeners at an endpoint"
            )


class SubscribingClient(ListeningRequester):
    """Client of an endpoint that may listen.

    Args:
        quota: How much there is room for, and what may be done.
    """

    def __init__(self, quota: EndpointQuota, identity: str = "") -> None:
        super().__init__(identity)
        self.access = quota.access
        self._quota = quota

    def listen(self, listener: Listener) -> None:
        """See `Requester.listen`."""
        self._quota.check_listeners(self.listening)
        super().listen(listener)
