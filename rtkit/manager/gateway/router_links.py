"""Links to the router of a manager, by ids: one that is made again ends its former one first.

Where a network was away for seconds, the router may take the former one for alive while the next
one joins; once it noticed, it has forgotten for good who answers at the other end (decision 98).
"""

from __future__ import annotations

import os

from rtkit.manager.gateway.connection import GatewayConnection
from rtkit.property.requests import Requester


class RouterLinks:
    """The clients of a gateway that are links."""

    def __init__(self) -> None:
        self._links: dict[str, GatewayConnection] = {}

    def add(self, client: GatewayConnection) -> str:
        """Note a link; return its id."""
        id = os.urandom(8).hex()
        self._links[id] = client
        return id

    def end(self, id: str, client: GatewayConnection) -> bool:
        """End the link of an id, if it is of the same certificate; return whether there was one."""
        former = self._links.get(id)
        if former is None or former.identity != client.identity:
            return False
        former.close()
        return True

    def forget(self, client: Requester) -> None:
        """Forget a client that has gone."""
        self._links = {id: each for id, each in self._links.items() if each is not client}
