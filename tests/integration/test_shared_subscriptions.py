"""Over real zenoh an event is sent once to all who listen alike, and all of them hear it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack
from queue import SimpleQueue

import pytest
import zenoh
from property_endpoints import BOUND_S, Zenoh
from zenoh_client import ZenohClient, ZenohSubscription

from rtkit.errors import Unreachable
from rtkit.link import zenoh_keys
from rtkit.link.zenoh import open_to_service
from rtkit.property.service import Service
from rtkit.wires.serve import ServedObject, serve

_MANY = 200


@pytest.fixture
def served(place: str) -> Iterator[ServedObject]:
    service = Service()
    service.add("tick", 0, "integer")
    with serve(service, "robot") as served:
        yield served


def _session(stack: ExitStack) -> zenoh.Session:
    session = open_to_service("robot", BOUND_S)
    stack.callback(session.close)
    return session


def _key() -> str:
    return zenoh_keys.property_service(os.uname().nodename, "robot")


def _heard(subscription: ZenohSubscription, last: str) -> list[str]:
    told: list[str] = []
    while not told or told[-1] != last:
        event = subscription.event(BOUND_S)
        assert event is not None
        assert event.dropped == 0
        told.append(str(event.payload))
    return told


def test_all_hear_all_and_each_event_is_sent_once(served: ServedObject) -> None:
    with ExitStack() as stack:
        sent: SimpleQueue[str] = SimpleQueue()
        handler: zenoh.handlers.Callback[zenoh.Sample] = zenoh.handlers.Callback(
            lambda sample: sent.put(sample.payload.to_string()), indirect=False
        )
        _session(stack).declare_subscriber(f"{_key()}/@e/*", handler)
        clients = [ZenohClient(_session(stack), _key(), BOUND_S) for _ in range(2)]
        subscriptions = [
            stack.enter_context(client.listen("tick?queue=1000"))
            for client in clients * 3
        ]  # fmt: skip
        for value in range(1, _MANY + 1):
            served.update("tick", value)
        expected = [str(value) for value in range(_MANY + 1)]
        assert [_heard(subscription, str(_MANY)) for subscription in subscriptions] == [
            expected
        ] * len(subscriptions)
        # The first value comes to each in the reply.
        assert [sent.get(timeout=BOUND_S) for _ in expected[1:]] == expected[1:]


def test_who_has_closed_its_session_is_told_so(served: ServedObject) -> None:
    with ExitStack() as stack:
        session = _session(stack)
        client = ZenohClient(session, _key(), BOUND_S)
        assert client.ask("tick").payload == "0"
        session.close()
        with pytest.raises(Unreachable, match="has ended"):
            client.ask("tick")


def test_those_that_are_left_hear_on(served: ServedObject) -> None:
    endpoint = Zenoh()
    with ExitStack() as stack:
        gone = ZenohClient(_session(stack), _key(), BOUND_S)
        ZenohSubscription(gone, "tick.listen?queue=9&initial=0", "queue=9").renew()
        with endpoint.listen("tick?queue=9&initial=0") as events:
            stack.close()  # without a word: its session is gone, its lease is not over
            served.update("tick", 5)
            assert next(events).payload == "5"
            with endpoint.listen("tick?queue=9") as later:
                served.update("tick", 6)
                assert [next(later).payload, next(later).payload] == ["5", "6"]
            served.update("tick", 7)
            assert [next(events).payload, next(events).payload] == ["6", "7"]
    endpoint.close()
