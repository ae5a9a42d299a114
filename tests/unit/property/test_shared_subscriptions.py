"""Those who listen to the same in the same way share what is sent; each hears as if by itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import pytest
import zenoh_client as subscriptions

from rtkit.property.access import read_policy
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, PropertyEvent
from rtkit.property.requests import PropertyRequest
from rtkit.property.service import Service
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires import subscribers as of_service
from rtkit.wires.query_server import QueryServer
from rtkit.wires.zenoh.queries import EventPosition, Joined, Queried, group_of


class Sent(NamedTuple):
    key: str
    event: PropertyEvent
    at: EventPosition


class Network:
    """A service and those who listen to it, with nothing between; some of it may be lost."""

    def __init__(self, rules: str = "") -> None:
        self.now = 1000.0
        self.host = PropertyEventLoop(read_policy(rules))
        self.service = Service("s", clock=lambda: self.now)
        self.service.add("speed", 1.0, "number")
        self.service.add("mode", "idle", "word")
        self.query_server = QueryServer(self.host, self.service, "zenoh")
        self.query_server.send = self._send
        self.sent: list[Sent] = []
        self.subscriptions: list[subscriptions.ZenohSubscription] = []
        self.is_lost = False

    def _send(self, key: str, event: PropertyEvent, at: EventPosition) -> None:
        self.sent.append(Sent(key, event, at))
        for subscription in [] if self.is_lost else self.subscriptions:
            if key == subscription.group:
                subscription.follow(event, at)
            elif key == subscription.id:
                subscription.hear(event, at)

    def ask_to_listen(self, target: str, subscription: str, group: str) -> Joined | None:
        told: list[tuple[Answer, Joined | None]] = []

        def answer(reply: Answer, joined: Joined | None = None, /) -> None:
            told.append((reply, joined))

        self.query_server.work(Queried(target, "self", answer, subscription, group))
        self.flush()
        [(reply, joined)] = told
        reply.value()
        return joined

    def flush(self) -> None:
        self.host._flush(self.now)

    def listen(self, target: str) -> subscriptions.ZenohSubscription:
        name, mark, tail = target.partition("?")
        subscription = subscriptions.ZenohSubscription(self, f"{name}.listen{mark}{tail}", tail)
        self.subscriptions.append(subscription)
        subscription.renew()
        return subscription

    def update(self, name: str, *values: float | str) -> None:
        for value in values:
            self.service.update(name, value)
            self.flush()

    def pass_time(self, seconds: float) -> None:
        self.now += seconds
        self.service.tick()
        self.flush()


def _taken(subscription: subscriptions.ZenohSubscription) -> list[str]:
    told = []
    while (event := subscription.event(0.0)) is not None:
        told.append(str(event.payload))
    return told


@pytest.fixture
def network(monkeypatch: pytest.MonkeyPatch) -> Iterator[Network]:
    made = Network()
    monkeypatch.setattr(of_service, "monotonic", lambda: made.now)
    monkeypatch.setattr("rtkit.wires.query_server.monotonic", lambda: made.now)
    yield made
    made.host.close()


def test_one_event_is_sent_once_for_all_who_listen_alike(network: Network) -> None:
    members = [network.listen("speed?queue=9") for _ in range(5)]
    assert network.sent == [], "the first value is told in the reply"
    network.update("speed", 2.0, 3.0)
    assert [each.event.payload for each in network.sent] == ["2.0", "3.0"]
    assert [_taken(each) for each in members] == [["1.0", "2.0", "3.0"]] * 5


def test_who_comes_later_begins_with_the_present_value(network: Network) -> None:
    first = network.listen("speed?queue=9")
    network.update("speed", 2.0)
    later, without = network.listen("speed?queue=9"), network.listen("speed?queue=9&initial=0")
    network.update("speed", 3.0)
    assert len(network.sent) == 2
    assert _taken(first) == ["1.0", "2.0", "3.0"]
    assert _taken(later) == ["2.0", "3.0"]
    assert _taken(without) == ["3.0"]


def test_what_was_not_sent_when_one_came_is_not_heard_after_its_first_value(
    network: Network,
) -> None:
    first = network.listen("speed?queue=9")
    network.service.update("speed", 2.0)  # and waits to be sent
    later = network.listen("speed?queue=9")
    network.flush()
    network.update("speed", 3.0)
    assert _taken(first) == ["1.0", "2.0", "3.0"]
    assert _taken(later) == ["2.0", "3.0"]


@pytest.mark.parametrize(
    "wish", ["queue=8", "mode=all", "lease=5", "every=0", "deadband=0", "queue=9&every=1"]
)
def test_other_wishes_are_served_apart(network: Network, wish: str) -> None:
    one, other = network.listen("speed?queue=9"), network.listen(f"speed?{wish}")
    assert one.group != other.group
    network.update("speed", 2.0)
    assert len({each.key for each in network.sent}) == 2
    assert (_taken(one)[-1], _taken(other)[-1:]) in (("2.0", ["2.0"]), ("2.0", ["1.0"]))


def test_who_wants_to_be_spared_is_in_no_group() -> None:
    assert group_of("p.listen?every=1") == group_of("p.listen?queue=2&deadband=0.5") == ""
    assert group_of("p.listen?queue=2&initial=0&mode=all") == group_of("p.listen?mode=all&queue=2")
    assert group_of("p.listen") != group_of("q.listen")


def test_nobody_is_put_into_a_group_of_others(network: Network) -> None:
    network.listen("speed?queue=9")
    told: list[object] = []
    query = Queried(
        "mode.listen", "self", lambda reply, joined=None, /: told.append((reply.error, joined)),
        "somebody", group_of("speed.listen?queue=9"),
    )  # fmt: skip
    network.query_server.work(query)
    network.flush()
    assert told == [("", None)], "served, but by itself"
    network.update("speed", 2.0)
    assert [each.at.number for each in network.sent if each.key == "somebody"] == [1]


def test_who_is_answered_late_is_one_listener_all_the_same(
    network: Network, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    query = Queried(
        "speed.listen?queue=9&initial=0", "self",
        lambda reply, _joined=None, /: told.append(reply.error), "somebody",
    )  # fmt: skip
    held: list[PropertyRequest] = []
    with monkeypatch.context() as slow:
        slow.setattr(network.service, "handle", held.append)
        network.query_server.work(query)
    network.service.handle(held.pop())
    network.update("speed", 2.0)
    network.query_server.work(query)
    network.update("speed", 3.0)
    assert told == ["", ""]
    sent = [(each.event.payload, each.at.number) for each in network.sent]
    assert sent == [("2.0", 1), ("2.0", 1), ("3.0", 2)], (
        "the last one again, and each next one once"
    )
    assert len({each.at.run for each in network.sent}) == 1


def test_the_others_go_on_when_one_leaves(network: Network) -> None:
    one, other = network.listen("speed?queue=9"), network.listen("speed?queue=9")
    one.leave()
    network.update("speed", 2.0)
    assert _taken(other) == ["1.0", "2.0"]
    other.leave()
    count = len(network.sent)
    network.update("speed", 3.0)
    assert len(network.sent) == count
    assert not network.service.listeners.is_any


def test_a_group_lives_as_long_as_one_of_it(network: Network) -> None:
    network.listen("speed?queue=9&lease=10")
    network.pass_time(8)
    lasting = network.listen("speed?queue=9&lease=10")
    network.pass_time(8)
    network.update("speed", 2.0)
    assert _taken(lasting) == ["1.0", "2.0"]
    lasting.leave()  # the other one was not heard of for longer than its lease
    assert not network.service.listeners.is_any


def test_leases_end(network: Network) -> None:
    one = network.listen("speed?queue=9&lease=10")
    network.pass_time(11)
    network.update("speed", 2.0)
    assert network.sent == []
    one.renew()
    network.update("speed", 3.0)
    assert _taken(one) == ["1.0", "2.0", "3.0"], "it begins anew with the present value"


@pytest.mark.parametrize("more", ["", "&deadband=0.1"], ids=["group", "alone"])
def test_what_was_lost_is_counted_by_each(network: Network, more: str) -> None:
    one = network.listen(f"speed?queue=9&initial=0{more}")
    network.is_lost = True
    network.update("speed", 2.0, 3.0)
    later = network.listen(f"speed?queue=9&initial=0{more}")
    network.update("speed", 4.0)
    network.is_lost = False
    network.update("speed", 5.0)
    for subscription, lost in ((one, 3), (later, 1)):
        event = subscription.event(0.0)
        assert event is not None
        assert (event.payload, event.dropped) == ("5.0", lost)


@pytest.mark.parametrize("more", ["", "&deadband=0.1"], ids=["group", "alone"])
def test_the_last_value_comes_with_the_next_renewal(network: Network, more: str) -> None:
    one = network.listen(f"speed?queue=9&initial=0{more}")
    network.is_lost = True
    network.update("speed", 2.0, 3.0)
    network.is_lost = False
    for _ in range(2):
        one.renew()
    event = one.event(0.0)
    assert event is not None
    assert (event.payload, event.dropped) == ("3.0", 1)
    assert _taken(one) == [], "told once"


def test_a_member_that_sleeps_holds_up_nobody(network: Network) -> None:
    awake, asleep = network.listen("speed?queue=4"), network.listen("speed?queue=4")
    latest = [network.listen("speed"), network.listen("speed")]
    for value in range(2, 100):
        network.update("speed", float(value))
        assert _taken(awake)[-1] == f"{value}.0"
    event = asleep.event(0.0)
    assert event is not None
    assert (event.payload, event.dropped) == ("96.0", 95)
    assert _taken(asleep) == ["97.0", "98.0", "99.0"]
    assert [_taken(each) for each in latest] == [["99.0"], ["99.0"]]


def test_the_end_of_the_property_is_the_last_event(network: Network) -> None:
    members = [network.listen("mode?queue=9&initial=0") for _ in range(2)]
    network.service.remove("mode")
    network.flush()
    for subscription in members:
        event = subscription.event(0.0)
        assert event is not None
        assert (event.code, event.quality) == ("unknown", "bad")


def test_members_are_counted_where_listeners_are_bounded() -> None:
    network = Network("limit zenoh door_listeners 3\nlimit zenoh connections 5")
    for _ in range(3):
        network.listen("speed?queue=9")
    with pytest.raises(PropertyError) as refused:
        network.listen("speed?queue=9")
    assert refused.value.code == "denied"
    network.host.close()


def test_early_events_are_put_behind_the_first_value(network: Network) -> None:
    network.listen("speed?queue=9")
    network.update("speed", 2.0)
    late = subscriptions.ZenohSubscription(network, "speed.listen?queue=9", "queue=9")
    network.subscriptions.append(late)  # it hears the group before it has asked
    network.update("speed", 3.0)
    late.renew()
    network.update("speed", 4.0)
    assert _taken(late) == ["3.0", "4.0"]
