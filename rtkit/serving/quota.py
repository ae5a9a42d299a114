"""Quota of an endpoint and its access rules, shared by its clients."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from time import monotonic
from typing import Protocol

from rtkit.property.access import DEFAULT_LIMITS, AccessPolicy, AccessRule, EndpointLimits
from rtkit.property.codes import PropertyError
from rtkit.serving.rate_limit import RateLimit


class QuotaClient(Protocol):
    """Client that may listen."""

    @property
    def listening(self) -> int:
        """Return how many subscriptions it has."""
        ...


class EndpointQuota:
    """Rules and limits of one endpoint.

    Args:
        policy: Of all endpoints.
        endpoint: What it is called there.
        clients: Those there are now.
        last: Rules of the endpoint itself, behind those of the policy.
        limits: Where the policy says nothing else.

    Attributes:
        access: What may be done.
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
            raise PropertyError("denied", f"more than {limits.door_listeners} listeners at a door")
