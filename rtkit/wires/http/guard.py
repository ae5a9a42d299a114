"""Guard of the HTTP endpoint: admits clients that know the secret, and no page of another site.

A page that somebody visits can have a browser send requests to this host. So the requested host
name must be one of this host's own (this stops DNS rebinding), and the origin that
a browser reports must be the endpoint itself.
"""

from __future__ import annotations

import hmac
import os
import re
from collections.abc import Container, Mapping
from typing import NamedTuple

from rtkit.link.secret import Secret
from rtkit.wires.http import digest

_NONCE_S = 300.0
"""How long a nonce is good for [s]; who knows the secret gets the next one unasked."""
_MOST_USES = 1 << 16
_MOST_NONCES = 1 << 16
_COUNT = re.compile(r"[0-9a-f]{8}")
_HOST = re.compile(r"(\[[0-9a-f:.]+\]|[a-z0-9.-]+)(:\d{1,5})?", re.IGNORECASE)
HERE = frozenset({"localhost", "127.0.0.1"})
"""Names of this host."""
_OWN_SITES = frozenset({"same-origin", "none"})


class Verdict(NamedTuple):
    """Identity of a client, or the refusal to send it.

    Attributes:
        identity: Empty for who has not shown it.
        challenge: Then, what asks for it.
    """

    identity: str
    challenge: str = ""


def stranger(headers: Mapping[str, str], names: Container[str], scheme: str = "http") -> str:
    """Return why a request is one of another site's page, empty if it is none.

    Args:
        headers: Of the request.
        scheme: Of the endpoint.
        names: Of this host, in lower case; of the scheme ``https``, whose browsers compare what
            they asked with a certificate, any name does.
    """
    host = headers.get("host", "")
    named = _HOST.fullmatch(host)
    if named is None or (scheme == "http" and named[1].strip("[]").lower() not in names):
        return f"this is not the host {host[:80]!r}"
    origin = headers.get("origin")
    if origin is not None and origin.lower() != f"{scheme}://{host}".lower():
        return f"from another site: {origin[:80]!r}"
    if headers.get("sec-fetch-site", "none") not in _OWN_SITES:
        return "from a page of another site"
    return ""


class Guard:
    """Asks for proofs and checks them; each proof is good for one request."""

    def __init__(self, secret: Secret) -> None:
        self._secret = secret
        self._key = os.urandom(32)
        self._used: dict[str, set[int]] = {}
        self._issued_us = 0

    def check(self, method: str, uri: str, header: str | None, now: float) -> Verdict:
        """Return who sends a request, from what it carries to show it."""
        given = digest.fields(header) if header else {}
        nonce, count = given.get("nonce", ""), given.get("nc", "")
        if not self._is_proof(given, method, uri, nonce, count):
            return Verdict("", digest.challenge(self._nonce(now)))
        if not self._is_fresh(nonce, int(count, 16), now):
            return Verdict("", digest.challenge(self._nonce(now), is_stale=True))
        return Verdict(self._secret.user)

    def _is_proof(
        self, given: dict[str, str], method: str, uri: str, nonce: str, count: str
    ) -> bool:
        is_whole = (
            given.get("username") == self._secret.user
            and given.get("realm") == digest.REALM
            and given.get("algorithm", "").upper() == "SHA-256"
            and given.get("qop") == "auth"
            and given.get("uri") == uri
            and _COUNT.fullmatch(count) is not None
        )
        own = given.get("cnonce", "")
        right = digest.response(self._secret, method, uri, nonce, count, own)
        received = given.get("response", "").encode("utf-8", "replace")
        return hmac.compare_digest(received, right.encode()) and is_whole

    def _nonce(self, now: float) -> str:
        # Two clients with one nonce would use the same counts, and one of them be told it is old.
        self._issued_us = max(int(now * 1e6), self._issued_us + 1)
        stamp = f"{self._issued_us:x}"
        return f"{stamp}.{self._seal(stamp)}"

    def _seal(self, stamp: str) -> str:
        return hmac.new(self._key, stamp.encode("utf-8", "replace"), "sha256").hexdigest()

    def _is_fresh(self, nonce: str, count: int, now: float) -> bool:
        """Return whether a nonce is ours, not old, and was not used with this count before."""
        stamp, _, seal = nonce.partition(".")
        if not hmac.compare_digest(seal.encode("utf-8", "replace"), self._seal(stamp).encode()):
            return False
        if now - _issued(nonce) > _NONCE_S:
            self._used.pop(nonce, None)
            return False
        used = self._used.setdefault(nonce, set())
        if count in used or len(used) >= _MOST_USES:
            return False
        used.add(count)
        if len(self._used) > _MOST_NONCES:
            self._forget(now)
        return True

    def _forget(self, now: float) -> None:
        """Forget nonces that are old; if none is, no nonce that was given out is good any more."""
        old = [each for each in self._used if now - _issued(each) > _NONCE_S]
        for each in old:
            del self._used[each]
        if not old:
            self._key = os.urandom(32)
            self._used.clear()


def _issued(nonce: str) -> float:
    """Return when a nonce was issued [s]."""
    return int(nonce.partition(".")[0], 16) / 1e6
