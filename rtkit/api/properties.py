"""Live properties of scripts: of components, managers, this host, served objects."""

from __future__ import annotations

import time
from collections.abc import Generator, Sequence
from contextlib import closing
from typing import TYPE_CHECKING, Any

from rtkit.api.property_change import PropertyChange as PropertyChange
from rtkit.api.session import ScriptSession, Stream, begun

if TYPE_CHECKING:
    from rtkit.api.client import Client
    from rtkit.property.messages import Payload
    from rtkit.tree.client import Tree
    from rtkit.tree.property_connections import PropertyConnections


class Properties:
    """Live properties: ``tree.properties.get("/localhost/Motor0.rtc.state")``.

    A target is ``SERVICE.NAME``, or the path of a component, manager or host with the name behind a
    dot, or an address (``rtkit help wires``), as ``rtget`` takes them.
    """

    def __init__(self, tree: Tree, client: Client) -> None:
        """Ask as long as calls of a tree may take."""
        self._tree = tree
        self._client = client

    def get(self, target: str) -> Any:
        """Return the value of a property.

        Raises:
            PropertyError: It cannot be got; its code tells how.
        """
        from rtkit.api.asked import Ask

        return _plain(self._client.payload(Ask(target), self._tree.timeout_s))

    def set(self, target: str, value: Any) -> None:
        """Set a property; a text is read as ``rtset`` does. It is in force when this returns.

        Raises:
            PropertyError: It cannot be set; its code tells how.
        """
        from rtkit.api.asked import Ask
        from rtkit.property.plain import from_plain

        content = value if isinstance(value, str | bytes) else from_plain(value)
        self._client.payload(Ask(target, content), self._tree.timeout_s)

    def listen(
        self, *targets: str, timeout_s: float | None = None, every_s: float = 0.0
    ) -> Stream[PropertyChange]:
        """Yield the present values of properties, then each change.

        Args:
            targets: Properties.
            timeout_s: For how long [s]; None for no bound.
            every_s: At most one change in this time [s]; the last one always comes.

        Raises:
            PropertyError: One cannot be listened to, or has been removed.
        """
        return begun(self._changes(targets, timeout_s, every_s))

    def _changes(
        self, targets: Sequence[str], timeout_s: float | None, every_s: float
    ) -> Generator[PropertyChange | None, None, None]:
        from rtkit.property.codes import PropertyError
        from rtkit.tree.property_connections import printed_error
        from rtkit.tree.property_subscription import PropertySubscription

        until = None if timeout_s is None else time.monotonic() + timeout_s
        given = f"every={every_s!r}" if every_s else ""
        with (
            ScriptSession(self._tree, lambda _: None) as session,
            self._places() as places,
            PropertySubscription(places, targets, given) as subscription,
        ):
            yield None
            while True:
                while (taken := subscription.take()) is not None:
                    typed, event = taken
                    if event.code:
                        gone = PropertyError(event.code, "it has been removed")
                        raise printed_error(typed, gone)
                    yield PropertyChange(typed, _plain(event.payload), event.time)
                if until is not None and time.monotonic() >= until:
                    return
                session.wait_for([subscription.fileno()], until)

    def _places(self) -> closing[PropertyConnections]:
        from rtkit.tree.property_connections import PropertyConnections

        return closing(PropertyConnections("/", "", self._tree.timeout_s))


def _plain(payload: Payload) -> Any:
    from rtkit.property.plain import payload_to_plain

    return payload if isinstance(payload, bytes) else payload_to_plain(payload)
