"""The queue between a property and who listens: bounded, latest first, told what it left out."""

from __future__ import annotations

import pytest

from rtkit.property.codes import PropertyError
from rtkit.property.messages import PropertyEvent
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.service import Service
from rtkit.property.subscription import Listener, SubscriptionOptions


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


class Ear(Requester):
    """Somebody who can hear."""

    def __init__(self, name: str = "ear") -> None:
        super().__init__(name)
        self.listeners: list[Listener] = []
        self.wakes = 0

    def listen(self, listener: Listener) -> None:
        self.listeners.append(listener)

    def unlisten(self, listener: Listener) -> None:
        self.listeners.remove(listener)

    def wake(self) -> None:
        self.wakes += 1


def make(target: str, clock: Clock) -> tuple[Service, Ear, Listener]:
    service = Service("s", clock=clock, wall=lambda: 5.0)
    service.add("x", 0, "number")
    subscription = Ear()
    answers = []
    service.handle(PropertyRequest(target, "self", answers.append, subscription))
    assert not answers[0].error, answers
    return service, subscription, subscription.listeners[0]


def drain(listener: Listener, now: float) -> list[PropertyEvent]:
    events = []
    while (event := listener.take(now)) is not None:
        events.append(event)
    return events


def test_a_slow_listener_sees_the_last_value_and_costs_one() -> None:
    clock = Clock()
    service, _, listener = make("x.listen", clock)
    for value in range(1000):
        service.update("x", value)
        assert listener.pending == 1
    (event,) = drain(listener, clock.now)
    assert (event.payload, event.dropped, event.time) == ("999", 0, 5.0)


def test_a_queue_drops_the_oldest_and_tells_how_many() -> None:
    clock = Clock()
    service, _, listener = make("x.listen?queue=3&initial=0", clock)
    for value in range(1, 11):
        service.update("x", value)
    events = drain(listener, clock.now)
    assert [(event.payload, event.dropped) for event in events] == [("8", 7), ("9", 0), ("10", 0)]


def test_at_most_so_often_but_the_last_one_always() -> None:
    clock = Clock()
    service, _, listener = make("x.listen?every=1", clock)
    assert [event.payload for event in drain(listener, clock.now)] == ["0"]
    service.update("x", 1)
    service.update("x", 2)
    assert drain(listener, clock.now + 0.5) == []
    assert listener.due() == clock.now + 1
    assert [event.payload for event in drain(listener, clock.now + 1)] == ["2"]
    assert listener.due() is None


def test_a_lease_ends_and_can_be_renewed() -> None:
    clock = Clock()
    service, subscription, listener = make("x.listen?lease=10", clock)
    assert service.listeners.tick() == 110.0
    clock.now = 109.0
    service.handle(PropertyRequest("x.listen?lease=10", "self", lambda _: None, subscription))
    assert subscription.listeners == [listener]
    assert service.listeners.tick() == 119.0
    clock.now = 119.0
    assert service.listeners.tick() is None
    assert subscription.listeners == []
    assert service.registry.nodes["x"].listeners is None


def test_another_wish_takes_the_place_of_the_first() -> None:
    clock = Clock()
    service, subscription, _ = make("x.listen?queue=5", clock)
    service.handle(PropertyRequest("x.listen?queue=7", "self", lambda _: None, subscription))
    assert [each.options.queue for each in subscription.listeners] == [7]


def test_who_is_gone_is_forgotten() -> None:
    clock = Clock()
    service, subscription, _ = make("x.listen", clock)
    service.handle(PropertyRequest("properties.listen", "self", lambda _: None, subscription))
    service.listeners.end_caller(subscription)
    assert subscription.listeners == []
    assert service.listeners.of_names == {}
    service.update("x", 3)
    service.add("y", 1)


def test_removing_twice_is_told() -> None:
    clock = Clock()
    service, subscription, _ = make("x.listen", clock)
    answers = []
    for _ in range(2):
        service.handle(PropertyRequest("x.listen?remove", "self", answers.append, subscription))
    assert [answer.error for answer in answers] == ["", "unknown"]


def test_a_caller_s_listeners_are_bounded() -> None:
    clock = Clock()
    service, subscription, _ = make("x.listen", clock)
    answers = []
    for index in range(1100):
        service.add(f"p{index}", 1)
        service.handle(PropertyRequest(f"p{index}.listen", "self", answers.append, subscription))
    assert {answer.error for answer in answers} == {"", "denied"}
    assert len(subscription.listeners) == 1024


def test_what_is_computed_is_read_while_somebody_listens() -> None:
    clock = Clock()
    service = Service("s", clock=clock)
    values = iter(range(100))
    service.add("n", spec="number", read=lambda given: next(values))
    subscription = Ear()
    assert service.listeners.computed() == []
    service.handle(PropertyRequest("n.listen", "self", lambda _: None, subscription))
    service.poll()
    (event,) = drain(subscription.listeners[0], clock.now)
    assert event.payload == "1"


def test_numbers_that_are_none_always_pass_a_deadband() -> None:
    listener = Listener("x", (), SubscriptionOptions(queue=9, deadband=1.0), Ear())
    for text, value in (("0", 0), ("nan", float("nan")), ("0", 0)):
        listener.offer(PropertyEvent("x", text, 0.0, 1), value)
    assert [event.payload for event in drain(listener, 0.0)] == ["0", "nan", "0"]


def test_a_lease_cannot_be_endless() -> None:
    with pytest.raises(PropertyError, match="at most"):
        Service("s").set("properties.listen?lease=1e9", "self")
