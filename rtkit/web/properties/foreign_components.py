"""Serves the HTML that services bring along: each at an address that is good once, for a frame.

Its policy takes its origin and the network from it, and it holds no secret, so it may be asked for
without the token: a frame cannot send that.
"""

from __future__ import annotations

from secrets import token_urlsafe
from time import monotonic

from rtkit.errors import NotFound

_GOOD_S = 30.0
_MOST = 64


class ForeignComponents:
    """Components that wait for the frame that shows them."""

    def __init__(self) -> None:
        self._waiting: dict[str, tuple[float, str]] = {}

    def address_for(self, code: str) -> str:
        """Return where a component is to be had, once and soon."""
        now = monotonic()
        for id, (until, _) in tuple(self._waiting.items()):
            if until < now or len(self._waiting) >= _MOST:
                del self._waiting[id]
        id = token_urlsafe(16)
        self._waiting[id] = now + _GOOD_S, code
        return f"/component/{id}"

    def take(self, id: str) -> str:
        """Return a component; afterwards it is to be had no more.

        Raises:
            NotFound: It was taken, or waited for too long.
        """
        until, code = self._waiting.pop(id, (0.0, ""))
        if until < monotonic():
            raise NotFound("this address was good once")
        return code
