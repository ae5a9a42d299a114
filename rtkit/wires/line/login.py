"""Login of a client of a TCP endpoint: proves that it knows the secret, and does not send it.

It asks for a nonce (``GET door/nonce``), then sets ``door/identity`` to ``USER PROOF``, the proof
being the HMAC-SHA256 of the nonce under the secret. Whoever else listens on the port learns nothing
that could be used again.
"""

from __future__ import annotations

import hmac
import os
from collections.abc import Iterable

from rtkit.link.secret import Secret
from rtkit.property.messages import DONE, Answer, Payload
from rtkit.property.requests import Requester

PATIENCE_S = 10.0
"""How long a client may be connected without a login [s]."""


class Login:
    """State of one client before it is known; a wrong proof ends the connection."""

    def __init__(self, secret: Secret, now: float, services: Iterable[str]) -> None:
        self.ends_at = now + PATIENCE_S
        self.is_refused = False
        self._secret = secret
        self._services = services
        self._nonce = os.urandom(16).hex()

    def take(self, caller: Requester, service: str, name: str, payload: Payload | None) -> Answer:
        """Answer a request to the endpoint itself."""
        if service == "door" and name == "nonce" and payload is None:
            return Answer(f"n{self._nonce}")
        if service == "door" and name == "identity" and payload is None:
            return Answer(caller.identity or "nobody")
        if service == "door" and name == "identity" and isinstance(payload, str):
            user, _, given = payload.partition(" ")
            right = self._secret.proof(f"n{self._nonce}")
            if user == self._secret.user and hmac.compare_digest(given.encode(), right.encode()):
                caller.identity = user
                return DONE
        if service == "door" and name == "services" and payload is None and caller.identity:
            return Answer(f"({' '.join(self._services)})")
        self.is_refused = not caller.identity
        if caller.identity:
            return Answer(f"no such property: door/{name}", "unknown")
        return Answer("who you are is to be shown first: door/nonce, door/identity", "denied")
