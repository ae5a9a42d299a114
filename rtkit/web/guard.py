"""Decides whether a request is one of our own page: plain rules over method, path and headers.

The accidents of local web servers of this kind are known: DNS rebinding, requests that pages of
other sites send, and secrets that a browser adds by itself. So the host must be ours, the origin
too where one is sent, and the token is in a header that only our page sets.
"""

from __future__ import annotations

import hmac
from collections.abc import Callable, Mapping
from time import monotonic
from typing import NamedTuple

from rtkit.wires.http.guard import stranger

JSON = "application/json"
DENIED = "denied"
"""The kind of error of what is not allowed."""
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; worker-src 'self'; font-src 'self'; frame-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}
"""Headers of every response."""


class Refusal(NamedTuple):
    """A request that is not answered: HTTP status, kind of error and reason."""

    status: int
    kind: str
    text: str


MOST_A_SECOND = 200
"""So many requests a second are answered in the long run; bursts may have twice as many."""


class Pace:
    """Bounds the rate of requests."""

    def __init__(self, clock: Callable[[], float] = monotonic) -> None:
        """Have had no request; `clock` tells the time [s]."""
        self._clock = clock
        self._left = 2.0 * MOST_A_SECOND
        self._since = clock()

    def admits(self) -> bool:
        """Count a request; return whether it is within the rate."""
        now = self._clock()
        earned = (now - self._since) * MOST_A_SECOND
        self._left = min(2.0 * MOST_A_SECOND, self._left + earned)
        self._since = now
        if self._left < 1:
            return False
        self._left -= 1
        return True


class WebGuard(NamedTuple):
    """Rules of one server.

    Attributes:
        token: The secret in the address that the user opens.
        names: Names of this host that a browser may ask for, in lower case.
        scheme: ``http`` or ``https``.
        is_public: Other hosts reach it, so requests may name the address they came to.
    """

    token: str
    names: frozenset[str]
    scheme: str = "http"
    is_public: bool = False

    def refusal(self, method: str, path: str, headers: Mapping[str, str]) -> Refusal | None:
        """Return why a request is refused, None if it is not; names of headers in lower case."""
        if path == "/" and headers.get("sec-fetch-mode") == "navigate":
            # A link, or a file of the user, leads to the page, which holds nothing without a token.
            headers = {**headers, "sec-fetch-site": "none"}
        why = stranger(headers, self.names, self.scheme)
        if why:
            return Refusal(403, DENIED, why)
        if not path.startswith("/api/"):
            if method in ("GET", "HEAD"):
                return None
            return Refusal(405, "malformed", f"{path[:80]} takes no {method[:20]}")
        given = headers.get("authorization", "")
        if not hmac.compare_digest(given.encode(), f"Bearer {self.token}".encode()):
            return Refusal(401, DENIED, "the token is missing, or is of another run")
        if method == "GET":
            return None
        if method != "POST":
            return Refusal(405, "malformed", f"{path[:80]} takes no {method[:20]}")
        kind = headers.get("content-type", "").partition(";")[0].strip().lower()
        if kind != JSON:
            return Refusal(415, "malformed", f"the content is to be {JSON}")
        return None
