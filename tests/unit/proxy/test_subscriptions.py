"""Queues of those who listen through a proxy, and what it understands of their wishes."""

from __future__ import annotations

import pytest

from rtkit.property.messages import PropertyEvent
from rtkit.property.naming import parse_parameters
from rtkit.property.requests import Requester
from rtkit.proxy.subscriptions import RelayedListener, relayed_options


@pytest.mark.parametrize(
    ("text", "passed_on", "queue", "lease_s", "is_alike"),
    [
        ("queue=1", "queue=1", 1, 0.0, True),
        ("queue=20&initial=0", "queue=20&initial=0", 20, 0.0, True),
        ("lease=5", "", 1, 5.0, True),
        ("lease=5&deadband=0.1", "deadband=0.1", 1, 5.0, False),
        ("mode=all", "mode=all", 1, 0.0, False),
        # What is wrong is left to the owner.
        ("lease=-1", "lease=-1", 1, 0.0, False),
        ("lease=red", "lease=red", 1, 0.0, False),
        ("lease=nan", "lease=nan", 1, 0.0, False),
        ("lease=1e9", "lease=1e9", 1, 0.0, False),
        ("queue=(", "queue=(", 1, 0.0, True),
        ("queue=99999999999", "queue=99999999999", 10_000, 0.0, True),
        ("nonsense", "nonsense", 1, 0.0, False),
    ],
)
def test_wishes(text: str, passed_on: str, queue: int, lease_s: float, is_alike: bool) -> None:
    options = relayed_options(parse_parameters(text))
    assert (options.text, options.queue, options.lease_s, options.is_alike) == (
        passed_on, queue, lease_s, is_alike)  # fmt: skip


def event(number: int, dropped: int = 0) -> PropertyEvent:
    return PropertyEvent("count", str(number), float(number), number, dropped=dropped)


def test_a_queue_holds_what_it_may_and_counts_what_it_lost() -> None:
    relayed = RelayedListener(
        "count", relayed_options(parse_parameters("queue=3&lease=2")), Requester(), now=10.0
    )
    assert (relayed.ends_at, relayed.due()) == (12.0, 12.0)
    relayed.push(event(0, dropped=5))
    for number in range(1, 10):
        relayed.push(event(number))
    assert relayed.pending == 3
    first = relayed.take(10.0)
    assert first is not None
    # Seven of ours, and those that had been lost before the first of them.
    assert (first.payload, first.dropped) == ("7", 12)
    assert [relayed.take(10.0), relayed.take(10.0), relayed.take(10.0)] == [
        event(8), event(9), None]  # fmt: skip


def test_of_the_latest_nothing_is_counted() -> None:
    relayed = RelayedListener("count", relayed_options({}), Requester(), now=0.0)
    relayed.push(event(1))
    relayed.push(event(2))
    assert (relayed.take(0.0), relayed.pending, relayed.due()) == (event(2), 0, None)
