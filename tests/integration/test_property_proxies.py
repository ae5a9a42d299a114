"""Behind proxies everything is as it is at the owner, whatever the wires; and what proxies add."""

from __future__ import annotations

import gc
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from queue import SimpleQueue

import pytest
from conformance import Door, check_answers, check_events, check_once, subject
from property_endpoints import BOUND_S, Lines, WirePlaces, Zenoh

from rtkit.errors import Refused, RtkitError
from rtkit.property.functional import FunctionalProperty
from rtkit.property.messages import Answer, PropertyEvent
from rtkit.property.property_spec import PropertySpec
from rtkit.property.service import Service
from rtkit.property.types import parse_type
from rtkit.proxy.bridge import bridge
from rtkit.proxy.relay import Relay
from rtkit.wires import provider_connection as keepalive
from rtkit.wires.line.client import connect_tcp, connect_unix
from rtkit.wires.line.server_connection import Connection
from rtkit.wires.serve import ServedObject, serve
from rtkit.wires.table import wire_of

CHAINS = (("unix", "zenoh", "tcp"), ("tcp", "unix", "zenoh"), ("zenoh", "zenoh", "zenoh"))
"""Wires from the owner to the client; between each two of them is a proxy."""


OPEN = {"port": 0, "http": 0, "is_on_zenoh": True}


def behind(served: ServedObject, place: str, wires: tuple[str, ...], ends: ExitStack) -> str:
    """Put proxies before the owner; return the address of the last."""
    places = WirePlaces(place, ends)
    of_owner = {"unix": f"unix:{served.socket}", "zenoh": "zenoh:robot", **served.addresses}
    address = of_owner[wires[0]]
    for wire in wires[1:]:
        address = places.opened(wire_of(wire), address)
    return address


def chain(served: ServedObject, place: str, wires: tuple[str, ...], ends: ExitStack) -> Door:
    """Put proxies between the owner and a client, which is returned."""
    endpoint = client(behind(served, place, wires, ends))
    ends.callback(endpoint.close)
    return endpoint


def client(address: str) -> Lines | Zenoh:
    scheme, _, rest = address.partition(":")
    if scheme == "zenoh":
        return Zenoh(rest)
    if scheme == "unix":
        return Lines(lambda: connect_unix(rest, BOUND_S))
    host, _, port = rest.partition(":")
    return Lines(lambda: connect_tcp(host, int(port), BOUND_S))


@pytest.fixture(params=CHAINS, ids="-".join)
def endpoint(
    request: pytest.FixtureRequest, served: ServedObject, place: str, ends: ExitStack
) -> Iterator[Door]:
    yield chain(served, place, request.param, ends)
    ends.close()


def test_requests(endpoint: Door) -> None:
    check_answers(endpoint)


def test_events(endpoint: Door, served: ServedObject, service: Service) -> None:
    check_events(endpoint, service, served.owned)


def test_a_slow_listener_sees_the_latest_value(endpoint: Door, served: ServedObject) -> None:
    with (
        endpoint.listen("count") as slow,
        endpoint.listen("count?queue=10000&initial=0") as all_of_them,
    ):
        assert next(slow).payload == "7"

        def change() -> None:
            for value in range(1000, 3000):
                served.service.update("count", value)
            served.service.update("count", -1)

        served.owned(change)
        heard = [next(all_of_them)]
        while heard[-1].payload != "-1":
            heard.append(next(all_of_them))
        assert len(heard) + sum(each.dropped for each in heard) == 2001
        taken = [next(slow).payload]
        while taken[-1] != "-1":
            taken.append(next(slow).payload)
        assert len(taken) < 100, "what is older than the latest was not kept for it"


class Proxied:
    """A proxy over unix sockets, clients of it, and what it says."""

    def __init__(self, served: ServedObject, place: str, ends: ExitStack) -> None:
        self.said: SimpleQueue[str] = SimpleQueue()
        self.refused: list[tuple[str, str, str]] = []
        self._served, self._place, self._ends = served, place, ends

    def open(self, *, prefix: str = "", allow_set: tuple[str, ...] = ("*",)) -> Lines:
        path = f"{self._place}/p.sock"
        self._ends.enter_context(
            bridge(
                f"unix:{self._served.socket}",
                f"unix:{path}",
                prefix=prefix,
                allow_set=allow_set,
                on_status=self.said.put,
                on_refusal=lambda *what: self.refused.append(what),
            )
        )
        return self.another()

    def another(self) -> Lines:
        made = Lines(lambda: connect_unix(f"{self._place}/p.sock", BOUND_S))
        self._ends.callback(made.close)
        return made


@pytest.fixture
def proxied(served: ServedObject, place: str, ends: ExitStack) -> Proxied:
    return Proxied(served, place, ends)


def test_listeners_that_wish_the_same_share_one_at_the_owner(
    proxied: Proxied, served: ServedObject, service: Service, ends: ExitStack
) -> None:
    endpoint = proxied.open()
    streams = [ends.enter_context(endpoint.listen("count")) for _ in range(5)]
    streams += [ends.enter_context(endpoint.listen("count?queue=9")) for _ in range(5)]
    assert [next(each).payload for each in streams] == ["7"] * 10
    assert len(service.listeners._all) == 2
    served.owned(lambda: service.update("count", 8))
    assert [next(each).payload for each in streams] == ["8"] * 10
    late = ends.enter_context(endpoint.listen("count"))
    assert next(late).payload == "8"
    assert len(service.listeners._all) == 2
    ends.close()
    with connect_unix(served.socket, BOUND_S) as direct:
        assert direct.ask("count.listen", "self").error == ""
        served.owned(lambda: None)
    await_that(served, lambda: not service.listeners._all)


def await_that(served: ServedObject, holds: Callable[[], bool]) -> None:
    """Wait, turn by turn of the owner's loop, until something holds."""
    for _ in range(100_000):
        if holds():
            return
        served.owned(lambda: None)
    raise AssertionError("it does not come to hold")


def test_nothing_is_set_unless_it_is_allowed(proxied: Proxied) -> None:
    endpoint = proxied.open(allow_set=("arm.*", "count", "p*"))
    allowed = [
        ("count", "8"),
        ("c%6funt", "9"),
        ("arm.angle", "4"),
        ("arm.properties", "((angle 5))"),
    ]
    for name, value in allowed:
        assert endpoint.ask(name, value).error == "", name
    denied = [
        ("speed", "0.5"),
        ("arm", "3"),
        ("properties", "((count 1))"),
        ("location.x", "1"),
        ("double", "2"),
        ("count.listen", "tcp://elsewhere/x"),
    ]
    for name, value in denied:
        assert endpoint.ask(name, value).error == "denied", name
    assert [each[2] for each in proxied.refused] == [each[0] for each in denied[:-1]]
    assert endpoint.ask("properties?names=(count%20arm.angle)&values").payload == (
        "((count 9) (arm.angle 5))")  # fmt: skip


def test_a_prefix_is_put_in_front_of_all_names(
    proxied: Proxied, served: ServedObject, service: Service
) -> None:
    endpoint = proxied.open(prefix="left.hand")
    below = {
        "left.hand.speed": "0.25",
        "left.hand.arm.properties": "(angle joint)",
        "properties": "(left)",
        "left": "(hand)",
        "left.properties": "(hand)",
        "properties?depth=2": "(left left.hand)",
        "left.properties?depth=2&match=*.a*": "(hand.any hand.arm hand.a%20b)",
        "properties?names=(left.hand.count)&values": "((left.hand.count 7))",
        "left.hand.properties?names=(count)&values": "((count 7))",
    }
    for name, value in below.items():
        assert endpoint.ask(name).payload == value, name
    assert endpoint.ask("left.hand").payload == endpoint.ask("left.hand.properties").payload
    told = str(endpoint.ask("properties?all&meta").payload)
    assert told.startswith("((left) (left.hand) (left.hand.speed <meta><type>number</type>")
    for name in ("speed", "left.speed", "left.handspeed", "right.hand.speed"):
        assert endpoint.ask(name).error == "unknown", name
    assert endpoint.ask("left.properties?nonsense").error == "bad-parameter"
    assert endpoint.ask("left", "1").error == "read-only"
    assert endpoint.ask("left.hand.count", "8").error == ""
    with (
        endpoint.listen("left.hand.count") as events,
        endpoint.listen("left.hand.properties") as names,
    ):
        assert next(events)[:2] == ("left.hand.count", "8")
        assert next(names).name == "left.hand.properties"
        served.owned(lambda: service.update("count", 9))
        assert next(events)[:2] == ("left.hand.count", "9")


def test_the_owner_goes_and_comes_back(place: str, ends: ExitStack) -> None:
    said: SimpleQueue[str] = SimpleQueue()
    first = subject()
    served = serve(first, "robot", is_on_zenoh=False)
    for source, target, hear in (("robot", "unix:p.sock", said.put), ("unix:p.sock", "p2", print)):
        ends.enter_context(
            bridge(
                source.replace("unix:", f"unix:{place}/"),
                target.replace("unix:", f"unix:{place}/"),
                allow_set=["*"],
                on_status=hear,
            )
        )
    endpoint = Lines(lambda: connect_unix(f"{place}/run/p2.ps", BOUND_S))
    ends.callback(endpoint.close)
    events = ends.enter_context(endpoint.listen("count?queue=100"))
    changes = ends.enter_context(endpoint.listen("mode?initial=0"))
    gripper = ends.enter_context(endpoint.listen("arm.angle"))
    assert (next(events).payload, next(gripper).payload) == ("7", "3")
    served.close()
    assert said.get(timeout=BOUND_S) == "the connection has ended"
    stale = next(events)
    assert (stale.payload, stale.quality) == ("7", "stale")
    assert next(gripper).quality == "stale"
    unknown = next(changes)
    assert (unknown.payload, unknown.quality, unknown.code) == ("", "stale", "")
    answer = endpoint.ask("count")
    assert answer.error == "no-service"
    assert answer.payload
    assert endpoint.ask("speed.listen", "self").error == "no-service"
    second = subject()
    second.update("count", 8)
    second.remove("arm.angle")
    with serve(second, "robot", is_on_zenoh=False) as again:
        assert said.get(timeout=BOUND_S) == ""
        back = next(events)
        assert (back.payload, back.quality) == ("8", "good")
        assert next(changes).payload == "idle"
        assert next(gripper).code == "unknown"
        again.owned(lambda: second.update("count", 9))
        assert next(events).payload == "9"
        assert endpoint.ask("count").payload == "9"
        ends.close()


def test_an_owner_that_does_not_answer_is_given_up(
    proxied: Proxied, served: ServedObject, service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keepalive, "ASKED_S", 0.3)
    monkeypatch.setattr(keepalive, "DEAD_S", 0.6)
    endpoint = proxied.open()
    with endpoint.listen("count") as events:
        assert next(events).payload == "7"
        is_held, go = threading.Event(), threading.Event()

        def hold() -> None:
            is_held.set()
            go.wait(BOUND_S)

        container = threading.Thread(target=served.owned, args=(hold,))
        container.start()
        assert is_held.wait(BOUND_S)
        assert endpoint.ask("count").error == "timeout"
        assert next(events).quality == "stale"
        assert "no answer" in proxied.said.get(timeout=BOUND_S)
        go.set()
        container.join()
        assert proxied.said.get(timeout=BOUND_S) == ""
        assert next(events).quality == "good"


def test_what_waits_at_the_owner_delays_nobody(
    proxied: Proxied, served: ServedObject, service: Service
) -> None:
    go = threading.Event()

    def wait() -> int:
        go.wait(BOUND_S)
        return 3

    kind = PropertySpec(parse_type("element"), is_functional=True)
    function = FunctionalProperty(wait)
    served.owned(lambda: service.add("slow", function=function, spec=kind))
    endpoint = proxied.open()
    with socket.socket(socket.AF_UNIX) as end:
        end.settimeout(BOUND_S)
        end.connect(endpoint._client._end.getpeername())
        end.sendall(b"#1 SET slow?echo \n#2 GET count\nSET count 8\nGET count\n#3 GET slow.state\n")
        replies = end.makefile()
        assert [replies.readline() for _ in range(4)] == [
            "#2 = 7\n", "=\n", "= 8\n", "#3 = running\n"]  # fmt: skip
        go.set()
        assert replies.readline() == '#1 = <call state="done"><result>3</result></call>\n'
        replies.close()


@pytest.mark.parametrize(
    "wires", [("unix", "tcp", "unix"), ("zenoh", "unix"), ("tcp", "zenoh", "unix")], ids="-".join
)
def test_a_request_that_is_repeated_with_its_id_acts_once(
    wires: tuple[str, ...], served: ServedObject, place: str, ends: ExitStack
) -> None:
    check_once(behind(served, place, wires, ends).removeprefix("unix:"))
    ends.close()


def test_what_is_repeated_after_the_connection_was_lost_acts_once(
    proxied: Proxied, served: ServedObject, service: Service
) -> None:
    """The owner acts, but its answer is lost with the connection."""
    acted: list[int] = []
    function = FunctionalProperty(
        lambda: acted.append(1) or lose(),  # type: ignore[func-returns-value]
        run=lambda work, finished: finished(work(), None),  # before the reply
    )
    kind = PropertySpec(parse_type("element"), is_functional=True)
    served.owned(lambda: service.add("act", function=function, spec=kind))
    endpoint = proxied.open()

    def lose() -> None:
        for handler in list(served._host._handlers.values()):
            if isinstance(handler, Connection):
                handler._end.shutdown(socket.SHUT_RDWR)

    with socket.socket(socket.AF_UNIX) as end:
        end.settimeout(BOUND_S)
        end.connect(endpoint._client._end.getpeername())
        with end.makefile() as replies:
            end.sendall(b"#a SET act \n")
            assert replies.readline().startswith("#a ! no-service ")
            while proxied.said.get(timeout=BOUND_S):
                pass
            end.sendall(b"#a SET act \n")
            assert replies.readline() == "#a =\n"
    assert len(acted) == 1


def test_a_proxy_of_itself_is_refused(served: ServedObject, place: str, ends: ExitStack) -> None:
    path = f"unix:{place}/"
    with pytest.raises(RtkitError, match="cannot reach"):
        bridge(f"{path}a.sock", f"{path}a.sock")
    said: SimpleQueue[str] = SimpleQueue()
    bystander = ends.enter_context(bridge("robot", f"{path}b.sock"))
    ends.enter_context(bridge(f"{path}b.sock", f"{path}a.sock", on_status=said.put))
    with pytest.raises(Refused, match="somebody listens there"):
        bridge("robot", f"{path}a.sock")
    bystander.close()
    assert "ended" in said.get(timeout=BOUND_S)
    ends.enter_context(bridge(f"{path}a.sock", f"{path}b.sock"))
    assert said.get(timeout=BOUND_S) == "that would be a proxy of itself"
    with connect_unix(f"{place}/b.sock", BOUND_S) as client:
        assert client.ask("count").error == "no-service"
    ends.close()


def test_very_long_chains_are_refused(served: ServedObject, place: str, ends: ExitStack) -> None:
    address = f"unix:{served.socket}"
    for number in range(8):
        target = f"unix:{place}/{number}.sock"
        address = ends.enter_context(bridge(address, target)).address
    with pytest.raises(RtkitError, match="more than 8 proxies"):
        bridge(address, f"unix:{place}/last.sock")
    with connect_unix(f"{place}/7.sock", BOUND_S) as client:
        assert client.ask("count").payload == "7"
    ends.close()


def test_clients_that_come_and_go_leave_nothing(proxied: Proxied, served: ServedObject) -> None:
    proxied.open()
    opened: list[PropertyEvent] = []
    for _ in range(50):
        endpoint = proxied.another()
        with (
            endpoint.listen("count?queue=3") as events,
            endpoint.listen("speed?every=0.01") as others,
        ):
            opened += [next(events), next(others)]
        endpoint.close()
    await_that(served, lambda: not served.service.listeners._all)
    assert len(opened) == 100
    (relay,) = [each for each in gc.get_objects() if isinstance(each, Relay) and each.uplink.is_up]
    assert (relay._listenings._all, relay._listenings._of, relay._numbers) == (set(), {}, {})


def test_what_is_slow_to_get_holds_nobody_up(place: str, served: ServedObject) -> None:
    """Over wires that answer one request at a time there are more of them."""
    go = threading.Event()

    def wait() -> int:
        go.wait(BOUND_S)
        return 3

    kind = PropertySpec(parse_type("element"), is_functional=True)
    function = FunctionalProperty(wait)
    served.owned(lambda: served.service.add("slow", function=function, spec=kind))
    path = f"{place}/slow.sock"
    source = f"http://localhost:{served.http}/ps/robot"
    with (
        bridge(source, f"unix:{path}", allow_set=["*"], timeout_s=BOUND_S),
        connect_unix(path, BOUND_S) as held,
        connect_unix(path, BOUND_S) as free,
    ):
        answers: SimpleQueue[Answer] = SimpleQueue()
        asking = threading.Thread(target=lambda: answers.put(held.ask("slow?echo", "")))
        asking.start()
        while free.ask("slow.state").payload != "running":
            pass
        assert free.ask("count", "8").error == ""
        assert free.ask("count").payload == "8"
        assert answers.empty()
        go.set()
        assert "done" in str(answers.get(timeout=BOUND_S).payload)
        asking.join()


def test_meta_data_tell_the_access_that_there_is_through_a_proxy(
    served: ServedObject, place: str
) -> None:
    path = f"{place}/near.sock"
    near = bridge("robot", f"unix:{path}", allow_set=["lab.mode"], prefix="lab")
    with near, connect_unix(path, BOUND_S) as client:
        assert client.ask("lab.speed.meta.access").value() == "r"
        assert client.ask("lab.mode.meta.access").value() == "rw"
        assert "<access>r</access>" in str(client.ask("lab.speed.meta").value())
        for listing in ("lab.properties?meta", "properties?meta&all"):
            told = str(client.ask(listing).value())
            assert told.count("<access>rw</access>") == 1
