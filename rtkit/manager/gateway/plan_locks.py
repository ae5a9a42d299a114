"""Locks of plans for clients of a gateway: each ends with the connection of whoever took it.

The manager watches the process of a lock's holder, which it sees of its own host only: so the
gateway holds the lock for its client, under the client's name.
"""

from __future__ import annotations

import json
import os
from typing import Any

from rtkit.deployment.plan_lock import LockHolder
from rtkit.errors import Malformed, Refused
from rtkit.property.requests import Requester
from rtkit.rtc.serde import decode, encode

_LONGEST = 200
_MOST = 8
"""How many locks one connection may ask for: it needs one."""


class PlanLocksOfClients:
    """The locks that clients have, or have asked for.

    Args:
        host: On which the manager runs, and this process.
    """

    def __init__(self, host: str) -> None:
        self._host = host
        self._held: dict[Requester, set[str]] = {}

    def stated(self, text: str, caller: Requester, who: str) -> str:
        """Return a request of a client as this process sends it to the manager.

        Raises:
            Malformed: It is none.
            Refused: The client gives back what it does not have, or has enough.
        """
        try:
            asked: dict[str, Any] = json.loads(text)
            wanted = decode(LockHolder, asked["take"]) if "take" in asked else None
            given = str(asked["give"]) if wanted is None else wanted.id
        except (KeyError, TypeError, ValueError, RecursionError, AttributeError) as error:
            raise Malformed(f"neither the wish for a lock nor its end: {error}") from error
        held = self._held.setdefault(caller, set())
        if wanted is None:
            if given not in held:
                raise Refused("no such lock of this client")
            held.discard(given)
            return text
        if len(held) >= _MOST or len(given) > _LONGEST:
            raise Refused("a client has one lock at a time")
        held.add(given)
        command = "".join(c if c.isprintable() else "?" for c in wanted.command)[:_LONGEST]
        holder = LockHolder(given, command, who, self._host, os.getpid(), wanted.since)
        return json.dumps({"take": encode(holder)})

    def refused(self, caller: Requester, stated: str) -> None:
        """Forget a lock that the manager did not give."""
        taken = json.loads(stated).get("take")
        if taken and caller in self._held:
            self._held[caller].discard(taken["id"])

    def left_by(self, caller: Requester) -> list[str]:
        """Return the requests that give back whatever a client still has, which has gone."""
        return [json.dumps({"give": each}) for each in sorted(self._held.pop(caller, ()))]
