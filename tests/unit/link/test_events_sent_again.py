"""Clients that hear an event twice tell it once, and tell every event that differs in anything."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count

import pytest
from zenoh_client import ZenohSubscription

from rtkit.property.messages import PropertyEvent
from rtkit.wires.mqtt.provider_connection import MqttConnection
from rtkit.wires.provider_connection import LeasedSubscription
from rtkit.wires.serial.address import SerialAddress
from rtkit.wires.serial.client import SerialClient
from rtkit.wires.zenoh.queries import EventPosition, Joined

FIRST = PropertyEvent("speed", "1.5", 12.0, 3)
OTHERS = (
    FIRST._replace(quality="stale"),
    FIRST._replace(payload="2.5", time=13.0, revision=4),
    FIRST._replace(quality="bad", code="unknown", payload=""),
)


class Serial:
    """A line on which nothing is ever sent."""

    def fileno(self) -> int:
        return self.end

    def __init__(self) -> None:
        self.end, self.other = os.pipe()

    def close(self) -> None:
        os.close(self.end)
        os.close(self.other)


@contextmanager
def _serial() -> Iterator[
    tuple[Callable[[PropertyEvent], object], Callable[[], PropertyEvent | None]]
]:
    address = SerialAddress("/dev/null")
    with SerialClient(Serial(), address, 1.0) as client:  # type: ignore[arg-type]
        yield client._keep, client._inbox.take


@contextmanager
def _zenoh() -> Iterator[
    tuple[Callable[[PropertyEvent], object], Callable[[], PropertyEvent | None]]
]:
    class Asking:
        def ask_to_listen(self, target: str, subscription: str, group: str) -> Joined | None:
            return Joined(None, EventPosition("first", 0))

    subscription = ZenohSubscription(Asking(), "speed.listen?queue=9", "queue=9")
    subscription.renew()
    # A group that begins anew, as it does after each loss, tells its last event again.
    runs = count()
    yield (
        lambda event: subscription.follow(event, EventPosition(str(next(runs)), 1)),
        lambda: subscription.event(0.0),
    )


@contextmanager
def _mqtt() -> Iterator[
    tuple[Callable[[PropertyEvent], object], Callable[[], PropertyEvent | None]]
]:
    heard: deque[PropertyEvent] = deque()

    connection = MqttConnection.__new__(MqttConnection)  # without a broker
    connection._subscriptions = {"speed": LeasedSubscription("", "to", heard.append)}
    yield lambda event: connection._take("to", event), lambda: heard.popleft() if heard else None


@pytest.mark.parametrize("client", [_serial, _zenoh, _mqtt])
@pytest.mark.parametrize("other", OTHERS)
def test_what_differs_in_anything_is_told_and_what_is_the_same_once(
    client: Callable[..., object], other: PropertyEvent
) -> None:
    with client() as (hear, told):
        for event in (FIRST, FIRST, other, other, FIRST):
            hear(event)
        heard = []
        while (event := told()) is not None:
            heard.append(event)
    assert heard == [FIRST, other, FIRST]
