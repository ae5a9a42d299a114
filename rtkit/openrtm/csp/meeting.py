"""The place where threads meet that exchange values over channels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from threading import TIMEOUT_MAX, Condition
from typing import TypeVar

from rtkit.component.contexts.input_wait import check_input, ended_with_input, is_leaving
from rtkit.component.contexts.waiting import waiting
from rtkit.errors import Malformed
from rtkit.rtc.connector_properties import finite

CHANNELS = {
    "dataport.interface_type": "csp_channel,zenoh,direct,corba_cdr,data_service",
    "dataport.dataflow_type": "duplex,push,pull",
}
"""Properties of a port whose connectors may be channels."""
T = TypeVar("T")


def number_in(properties: Mapping[str, str], key: str, usual: float) -> float:
    """Return a number of 0 or more that a property states, else the usual one.

    Raises:
        Malformed: It is none; names the key.
    """
    text = properties.get(key, "").strip()
    number = finite(text) if text else usual
    if number is None or number < 0:
        raise Malformed(f"{key}={text}: not a number of 0 or more")
    return number


class Meeting:
    """A condition that all threads wait at that use a port, or those of one manager.

    Attributes:
        changed: Notified whenever another one may go on; its lock guards what they share.
    """

    def __init__(self) -> None:
        self.changed = Condition()

    def ring(self) -> None:
        """Have everybody look again."""
        with self.changed:
            self.changed.notify_all()

    def hush(self) -> None:
        """Do nothing: nobody is kept from waiting here."""

    def wait(self, find: Callable[[], T], timeout_s: float, instance: str) -> T:
        """Return what is found as soon as it is true, else what is found in the end.

        Args:
            find: Called with the lock held.
            timeout_s: Longest wait [s].
            instance: The component whose callback waits.

        Raises:
            InputEnded: The component is to be deactivated or ended, and nothing was found.
        """
        bound_s = min(max(timeout_s, 0.0), TIMEOUT_MAX)
        with ended_with_input(instance, self), waiting(bound_s, is_idle=True), self.changed:
            self.changed.wait_for(lambda: find() or is_leaving(instance), bound_s)
            found = find()
        if not found:
            check_input(instance)
        return found
