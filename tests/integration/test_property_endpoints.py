"""Every endpoint of a real service answers alike, and none is brought down by who abuses it."""

from __future__ import annotations

import contextlib
import re
import select
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial

import icekit
import pytest
from conformance import Door, check_answers, check_events, subject
from oneline import OneLine
from property_endpoints import (
    BOUND_S,
    KNOWING,
    Lines,
    WirePlaces,
    Zenoh,
    client_of,
    listening,
    opening,
    params,
)
from unruly import Unruly, check_only_its_own_request_suffers

from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.keys.reach import BEHIND_TLS
from rtkit.link import places, secret
from rtkit.property.codes import PropertyError
from rtkit.property.service import Service
from rtkit.proxy.bridge import bridge
from rtkit.serving import refusals
from rtkit.tree.property_connections import PropertyConnections
from rtkit.tree.property_subscription import PropertySubscription
from rtkit.wires.line import login, server_connection
from rtkit.wires.line.client import LineClient, connect_unix
from rtkit.wires.serve import ServedObject, serve
from rtkit.wires.table import WIRES, wire_of


@pytest.fixture
def served(place: str, service: Service) -> Iterator[ServedObject]:
    with serve(service, "robot", **opening(place)) as served:
        yield served


def _speed(served: ServedObject) -> object:
    with connect_unix(served.socket, BOUND_S) as client:
        return client.ask("speed").payload


ENDPOINTS: dict[str, Callable[[ServedObject], Lines | Zenoh | OneLine]] = {
    "unix": lambda served: Lines(lambda: connect_unix(served.socket, BOUND_S)),
    "zenoh": lambda served: Zenoh(),
} | {each: partial(client_of, scheme=each) for each in KNOWING}
"""Each is a row: what is asked of one is asked of all."""
THERE = [each for each in ENDPOINTS if icekit.IS_THERE or each != "ice"]


@pytest.fixture(params=params(*ENDPOINTS))
def endpoint(request: pytest.FixtureRequest, served: ServedObject) -> Iterator[Door]:
    made = ENDPOINTS[request.param](served)
    yield made
    made.close()


def test_requests(endpoint: Door) -> None:
    check_answers(endpoint)


@pytest.mark.parametrize("wire", params(*ENDPOINTS))
def test_of_code_that_does_anything_only_its_own_request_suffers(place: str, wire: str) -> None:
    thing = Unruly()
    with serve(thing, "robot", **opening(place)) as served:
        endpoint = ENDPOINTS[wire](served)
        check_only_its_own_request_suffers(endpoint, thing)
        endpoint.close()


def test_events(endpoint: Door, served: ServedObject, service: Service) -> None:
    check_events(endpoint, service, served.owned)


def test_ends_of_lines_are_as_they_like(served: ServedObject) -> None:
    with socket.socket(socket.AF_UNIX) as end:
        end.settimeout(BOUND_S)
        end.connect(served.socket)
        replies = end.makefile()
        for line in (b"SET notes x\r\n", b"GET notes\r\n", b"SET notes y\n", b"GET notes\n"):
            end.sendall(line)
        assert [replies.readline() for _ in range(4)] == ["=\n", "= x\n", "=\n", "= y\n"]
        replies.close()


def test_changes_through_one_door_are_heard_at_the_others(served: ServedObject) -> None:
    endpoints = {name: ENDPOINTS[name](served) for name in THERE}
    try:
        for name, endpoint in endpoints.items():
            with (
                endpoints["unix"].listen("any?initial=0") as here,
                endpoints["zenoh"].listen("any?initial=0") as there,
            ):
                assert endpoint.ask("any", name).error == ""
                assert (next(here).payload, next(there).payload) == (name, name)
                assert {each.ask("any").payload for each in endpoints.values()} == {name}
    finally:
        for endpoint in endpoints.values():
            endpoint.close()


def test_a_slow_listener_sees_the_latest_value(endpoint: Door, served: ServedObject) -> None:
    with (
        endpoint.listen("count") as slow,
        endpoint.listen("count?queue=10000&initial=0") as all_of_them,
    ):
        assert next(slow).payload == "7"

        def change() -> None:
            for value in range(1000, 3000):
                served.service.update("count", value)

        served.owned(change)
        served.owned(lambda: served.service.update("count", -1))
        heard = [next(all_of_them).payload]
        while heard[-1] != "-1":
            heard.append(next(all_of_them).payload)
        taken = [next(slow).payload]
        while taken[-1] != "-1":
            taken.append(next(slow).payload)
        assert len(taken) <= 3, "what is older than the latest was not kept for it"


def test_a_listener_that_takes_nothing_keeps_the_latest_value(
    endpoint: Door, served: ServedObject
) -> None:
    with (
        endpoint.listen("count") as slow,
        endpoint.listen("count?queue=100&initial=0") as all_of_them,
    ):
        assert next(slow).payload == "7"
        for value in range(1000, 1050):  # each is sent to both, before there is another
            served.owned(lambda value=value: served.service.update("count", value))  # type: ignore[misc]
            assert next(all_of_them).payload == str(value)
        taken = [next(slow).payload]
        while taken[-1] != "1049":
            taken.append(next(slow).payload)
        assert len(taken) <= 3, "what is older than the latest was not kept for it"


def test_who_does_not_know_the_secret_learns_nothing(served: ServedObject) -> None:
    with socket.create_connection(("127.0.0.1", served.port or 0), BOUND_S) as end:
        end.sendall(b"GET speed\nSET speed 1\n")
        assert end.makefile().readline().startswith("! denied ")
        assert end.recv(100) == b""
    with socket.create_connection(("127.0.0.1", served.port or 0), BOUND_S) as end:
        end.sendall(b"GET door/nonce\nGET door/services\n")
        assert re.fullmatch("= n[0-9a-f]{32}\n! denied .*\n", end.makefile().read())
    wrong = secret.read()._replace(password="guess").proof("n")
    user = secret.read().user
    with socket.create_connection(("127.0.0.1", served.port or 0), BOUND_S) as end:
        end.sendall(f"SET door/identity {user} {wrong}\nGET speed\n".encode())
        assert end.makefile().read().startswith("! denied ")
    assert _speed(served) == "0.25"


def test_the_name_is_taken_while_it_runs_and_free_when_it_was_killed(served: ServedObject) -> None:
    with pytest.raises(Refused, match="running already"):
        serve(Service(), "robot")
    left = places.service_socket("gone")
    with socket.socket(socket.AF_UNIX) as end:
        end.bind(left)
    with serve(Service(), "gone"), connect_unix(left, BOUND_S) as client:
        assert client.ask("properties").payload == "()"


@pytest.mark.parametrize("wire", params("unix", *KNOWING))
@pytest.mark.parametrize(
    "rubbish",
    [
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(range(256)) * 8,
        b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"x" * (3 << 20),
        b"SET any " + b"(" * 1_000_000 + b"\n",
        b"SET any {999999999999}\n",
        b"GET " + b"\xff" * 1000 + b"\n",
        b"#" * 100_000 + b"\n",
        b"\n" * 10_000,
        b"SET any {5}\n12",
    ],
)
def test_rubbish_harms_nobody_else(served: ServedObject, rubbish: bytes, wire: str) -> None:
    with _connected(served, wire) as end:
        # It may hang up on rubbish that is not taken to its end.
        sender = threading.Thread(target=_send, args=(end, rubbish))
        sender.start()
        assert _speed(served) == "0.25"
        with contextlib.suppress(OSError):  # it has hung up
            end.shutdown(socket.SHUT_RDWR)
        sender.join(BOUND_S)
        assert not sender.is_alive()
    assert _asked_anew(served, wire) == "0.25"


def _asked_anew(served: ServedObject, wire: str) -> object:
    with contextlib.closing(ENDPOINTS[wire](served)) as endpoint:
        return endpoint.ask("speed").value()


def _connected(served: ServedObject, wire: str) -> socket.socket:
    """Connect to the socket of an endpoint without a word."""
    address = served.socket if wire == "unix" else served.addresses[wire]
    path = re.search(r"/.*\.(?:sock|ps)\b", address)
    if path is None:
        port = re.search(r":(\d+)", address)
        assert port is not None, f"neither a port nor a path of opening(): {address}"
        return socket.create_connection(("127.0.0.1", int(port[1])), BOUND_S)
    end = socket.socket(socket.AF_UNIX)
    try:
        end.settimeout(BOUND_S)
        end.connect(path[0])
    except OSError:
        end.close()
        raise
    return end


def _send(end: socket.socket, data: bytes) -> None:
    try:
        end.sendall(data)
    except OSError:
        return


def test_who_never_reads_delays_nobody_and_costs_little(
    served: ServedObject, service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server_connection, "HALF_S", 0.5)
    served.owned(lambda: service.update("notes", "x" * 500_000))
    with socket.socket(socket.AF_UNIX) as deaf:
        deaf.settimeout(BOUND_S)
        deaf.connect(served.socket)
        deaf.sendall(b"SET count.listen self\n" + b"GET notes\n" * 200)
        with listening(connect_unix(served.socket, BOUND_S), "count?queue=1000") as events:
            assert next(events).payload == "7"
            for value in range(100, 200):
                served.owned(lambda value=value: service.update("count", value))  # type: ignore[misc]
            assert [next(events).payload for _ in range(100)][-1] == "199"
        # It is given up without anything of it being read.
        end = time.monotonic() + BOUND_S
        while left := _connections(served):
            assert all(len(each._out) < 3_000_000 for each in left)
            assert time.monotonic() < end
            served.owned(lambda: None)


def _connections(served: ServedObject) -> list[server_connection.Connection]:
    handlers = list(served._host._handlers.values())
    return [each for each in handlers if isinstance(each, server_connection.Connection)]


def test_who_says_nothing_is_not_waited_for(
    served: ServedObject, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(login, "PATIENCE_S", 0.3)
    monkeypatch.setattr(server_connection, "HALF_S", 0.3)
    with socket.create_connection(("127.0.0.1", served.port or 0), BOUND_S) as silent:
        assert silent.recv(10) == b""
    with socket.socket(socket.AF_UNIX) as half:
        half.settimeout(BOUND_S)
        half.connect(served.socket)
        half.sendall(b"GET sp")
        assert half.recv(10) == b""


def test_a_service_that_ends_is_told_to_who_listens(place: str) -> None:
    service = subject()
    served = serve(service, "robot", is_on_zenoh=False)
    client = connect_unix(served.socket, BOUND_S)
    client.listen("count")
    assert client.event(BOUND_S) is not None
    served.close()
    with client, pytest.raises(Unreachable, match="ended"):
        client.event(BOUND_S)
    with pytest.raises(RtkitError):
        connect_unix(served.socket, BOUND_S)


@pytest.mark.parametrize("scheme", ["tcp", "http"])
def test_events_behind_one_endpoint_are_told_as_they_were_typed(
    served: ServedObject, scheme: str
) -> None:
    place = served.addresses[scheme]
    begin = f"{place}/robot" if scheme == "tcp" else place
    typed = [f"{begin}/speed", f"{begin}/count"]
    with (
        contextlib.closing(PropertyConnections("/", "", BOUND_S)) as connections,
        PropertySubscription(connections, typed, "") as subscription,
    ):
        heard = set()
        while heard != set(typed):
            assert select.select([subscription], [], [], BOUND_S)[0]
            while (event := subscription.take()) is not None:
                heard.add(event[0])
        assert heard == set(typed)
        readers = [each for each in threading.enumerate() if "_receive" in each.name]
        assert len(readers) == 1


def test_actions_run_beside_everything_else(place: str) -> None:
    go = threading.Event()

    class Slow:
        speed = 1.0

        def work(self, seconds: float) -> float:
            go.wait(BOUND_S)
            return seconds

    with (
        serve(Slow(), "slow", is_on_zenoh=False) as served,
        connect_unix(served.socket, BOUND_S) as first,
        connect_unix(served.socket, BOUND_S) as second,
    ):
        _check_slow(first, second, go)


def _check_slow(first: LineClient, second: LineClient, go: threading.Event) -> None:
    assert first.ask("work", "3").error == ""
    assert second.ask("work", "3").error == "busy"
    assert second.ask("speed").payload == "1.0"
    assert second.ask("work.state").payload == "running"
    second.listen("work")
    go.set()
    states = []
    while not states or "done" not in states[-1]:
        event = second.event(BOUND_S)
        assert event is not None
        states.append(str(event.payload))
    assert states[-1] == '<call state="done"><result>3.0</result></call>'
    assert first.ask("work?echo", "4").payload == (
        '<call state="done"><result>4.0</result></call>')  # fmt: skip


# Rules and limits


RULES = """
deny  * *  GET arm.joint
deny  * *  SET mode
allow * *  SET arm.*
allow * *  SET count
allow * *  SET any
deny  * *  SET *
limit * size 5000
limit * listeners 2
limit zenoh connections 2
"""

ROWS = [
    ("speed", None, ""), ("speed", "0", "denied"), ("count", "1", ""), ("mode", "idle", "denied"),
    ("arm.angle", "2", ""), ("arm.joint.1", "2", ""),
    ("arm.joint.1", None, "denied"), ("%61rm.joint.1", None, "denied"),
    ("arm.joint.1.meta", None, "denied"), ("arm.joint.1.history", None, "denied"),
    ("arm.joint.1.listen", "self", "denied"), ("arm.joint.1.gui", None, "denied"),
    ("speed.listen", None, "denied"),
    ("count.listen", None, ""),
    ("location.x", "2", "denied"), ("double", "1", "denied"), ("double.stop", "true", "denied"),
    ("properties", "((count 2) (arm.angle 3))", ""),
    ("properties", "((count 3) (speed 0.5))", "denied"),
    ("properties?names=(speed%20arm.joint.1)&values", None, "denied"),
    ("arm.properties?names=(joint.1)&values", None, "denied"),
    ("arm.properties", "((joint.1 3))", ""),
    ("any", '"' + "x" * 6000 + '"', "too-large"), ("any", '"' + "x" * 4000 + '"', ""),
]  # fmt: skip
"""Target, payload, and the code that answers it."""


def test_rules_hold_at_every_door(
    place: str, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(refusals, "MOST", 1000)
    with _ruled(place) as served:
        for name in THERE:
            endpoint = ENDPOINTS[name](served)
            caplog.clear()
            wrong = [
                (name, target, answer) for target, payload, code in ROWS
                if (answer := endpoint.ask(target, payload)).error != code
            ]  # fmt: skip
            assert wrong == []
            assert endpoint.ask("count").payload == "2", "nothing of a bulk SET that was denied"
            told = str(endpoint.ask("properties?all&values").payload)
            assert "(speed 0.25)" in told
            assert "joint.1" not in told, "what may not be got is in no list of values"
            assert "(joint.1)" in str(endpoint.ask("arm.properties?all&meta").payload)
            denied = [each.getMessage() for each in caplog.records if "denied: SET" in each.message]
            assert len(denied) == 7, "every SET that was denied is in the log"
            endpoint.close()


@pytest.mark.parametrize("scheme", params(*WIRES))
def test_a_rule_for_one_wire_holds_there_and_nowhere_else(
    place: str, ends: ExitStack, scheme: str
) -> None:
    """Endpoints say themselves what they are called in rules: each must take the scheme."""
    others = "\n".join(f"deny {each} * SET *" for each in WIRES if each != scheme)
    endpoints = {}
    for name, rules in (("here", f"deny {scheme} * SET *"), ("elsewhere", others)):
        address = WirePlaces(f"{place}/{name}", ends).ruled(wire_of(scheme), subject(), rules)
        far = f"unix:{place}/{name}/far.sock"
        ends.enter_context(bridge(address, far, allow_set=["*"], timeout_s=BOUND_S))
        endpoints[name] = ends.enter_context(connect_unix(far.removeprefix("unix:"), BOUND_S))
    assert endpoints["here"].ask("count").payload == "7"
    assert endpoints["here"].ask("count", "8").error == "denied"
    assert endpoints["here"].ask("count").payload == "7"
    assert endpoints["elsewhere"].ask("count", "8").error == ""
    assert endpoints["elsewhere"].ask("count").payload == "8"
    ends.close()


def test_listeners_are_bounded_at_every_door(place: str) -> None:
    with _ruled(place, "limit * door_listeners 2") as served:
        for name in THERE:
            endpoint = ENDPOINTS[name](served)
            with endpoint.listen("count") as first, endpoint.listen("speed") as second:
                next(first)
                next(second)
                with pytest.raises(PropertyError) as refused, endpoint.listen("mode"):
                    pass
                assert refused.value.code == "denied"
            endpoint.close()


@pytest.mark.parametrize("name", params("unix", *KNOWING))
def test_who_asks_too_often_is_told(place: str, name: str) -> None:
    with _ruled(place, "limit * rate 20") as served:
        endpoint = ENDPOINTS[name](served)
        answers = [endpoint.ask("speed") for _ in range(200)]
        assert {each.error for each in answers} == {"", "busy"}
        assert "more than 20 requests a second" in {each.payload for each in answers}
        endpoint.close()


# Before TLS there are no words: there a connection too many is hung up on.
@pytest.mark.parametrize(
    "wire", params("unix", *(each for each in KNOWING if each not in BEHIND_TLS))
)
def test_one_connection_too_many_is_told(place: str, wire: str) -> None:
    with _ruled(place, "limit * connections 1") as served:
        first = ENDPOINTS[wire](served)
        assert first.ask("speed").error == ""
        with pytest.raises(PropertyError) as refused:
            _asked_anew(served, wire)
        assert refused.value.code == "busy"
        assert first.ask("speed").error == ""
        first.close()


def _ruled(place: str, rules: str = RULES) -> ServedObject:
    return serve(subject(), "robot", **opening(place), rules=rules)
