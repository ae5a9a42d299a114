"""The Ice door as strangers meet it, and who means no good; and what is heard when an end goes."""

from __future__ import annotations

import contextlib
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

import icekit
import pytest
from conformance import subject
from icestranger import Stranger
from icestranger import string as _string

from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.link import secret
from rtkit.link.secret import Secret
from rtkit.property.codes import PropertyError
from rtkit.property.functional import FunctionalProperty
from rtkit.property.messages import PropertyEvent
from rtkit.property.property_spec import PropertySpec
from rtkit.property.service import Service
from rtkit.property.types import parse_type
from rtkit.proxy.bridge import bridge
from rtkit.wires import provider_connection as keepalive
from rtkit.wires.ice import endpoint, protocol, served_client, subscriber
from rtkit.wires.ice import session as ice_session
from rtkit.wires.ice.address import read_address
from rtkit.wires.ice.client import IceClient, connect_ice
from rtkit.wires.ice.endpoint import IceEndpoint
from rtkit.wires.ice.served_client import ServedIceClient
from rtkit.wires.ice.session import IceSession, Outcome
from rtkit.wires.line import login
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serve import ServedObject, serve

pytestmark = pytest.mark.skipif(not icekit.IS_THERE, reason=icekit.MISSING)

BOUND_S = 30.0
OPEN = {"ice": 0}


def client(served: ServedObject) -> IceClient:
    return connect_ice(f"ice://localhost:{served.ice}/robot", BOUND_S)


def session(served: ServedObject, **more: Any) -> IceSession:
    address = read_address(f"ice://localhost:{served.ice}/robot")
    return IceSession(address, secret.read(), BOUND_S, **more)


def door_of(served: ServedObject) -> IceEndpoint:
    (closer,) = [each for each in served._host._closers if "IceEndpoint" in each.__qualname__]
    endpoint = closer.__self__  # type: ignore[attr-defined]
    assert isinstance(endpoint, IceEndpoint)
    return endpoint


def guests(served: ServedObject) -> list[ServedIceClient]:
    return list(door_of(served)._clients.values())


def await_that(served: ServedObject, is_so: Callable[[], object]) -> None:
    end = time.monotonic() + BOUND_S
    while not is_so():
        assert time.monotonic() < end
        served.owned(lambda: None)
        time.sleep(0.01)


# Who means no good


@pytest.mark.parametrize(
    "rubbish",
    [
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(range(256)) * 8,
        b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"x" * (3 << 20),
        b"IceP\1\0\1\0\0\0" + struct.pack("<i", 1 << 30),
        b"IceP\1\0\1\0\0\0" + struct.pack("<i", -1),
        b"IceP\1\0\1\0\0\2" + struct.pack("<i", 30) + b"\xff" * 16,
        b"IceP\1\0\1\0\1\0" + struct.pack("<ii", 18, 1 << 30),
        b"IceP\1\0\1\0\4\0" + struct.pack("<i", 14),
        b"IceP\2\7\1\0\0\0" + struct.pack("<i", 14),
    ],
    ids=["TLS", "HTTP", "x", "1 GiB", "less than none", "packed", "batch", "bye", "Ice 2"],
)  # fmt: skip
def test_rubbish_ends_only_its_own_connection(served: ServedObject, rubbish: bytes) -> None:
    with client(served) as other, Stranger(served.ice) as stranger:
        sender = threading.Thread(target=_send, args=(stranger.end, rubbish))
        sender.start()
        assert stranger.is_hung_up_on()
        sender.join(BOUND_S)
        assert other.ask("speed").payload == "0.25"


def _send(end: socket.socket, data: bytes) -> None:
    try:
        end.sendall(data)
    except OSError:
        return


def test_requests_that_cannot_be_read_are_answered(served: ServedObject) -> None:
    with Stranger(served.ice) as stranger:
        stranger.log_in()
        for body in (
            _string(b"\xff\xfe"),
            b"",
            b"\xff\xff\xff\xff\x7f",
            b"\xff" + struct.pack("<i", -1),
        ):
            stranger.ask("get", body)
            assert stranger.reply()[4] != 0
        for operation in ("shutdown", "get" * 50_000, ""):
            stranger.ask(operation, _string("speed"))
            assert stranger.reply()[4] != 0
        stranger.ask("listen", _string("count") + _string("") + _string(""))
        assert b"nobody to call" in stranger.reply()
        who = _string("x" * 300) + _string("") + b"\0\0\0" + b"\1\0\1\1" + b"\0" + b"\0"
        stranger.ask("listen", _string("count") + who)
        assert b"too-large" in stranger.reply()
        stranger.ask("get", _string("speed"))
        assert b"0.25" in stranger.reply()


def test_who_does_not_know_the_secret_learns_nothing(served: ServedObject) -> None:
    for operation, body in (
        ("get", _string("speed")),
        ("set", _string("speed") + _string("1") + b"\0\0"),
        ("listen", _string("speed") + _string("ear") + _string("") + b"\0\0\0\1\0\1\1\0\0"),
    ):
        with Stranger(served.ice) as stranger:
            stranger.ask(operation, body)
            told = stranger.reply()
            assert b"denied" in told
            assert b"0.25" not in told
            assert stranger.is_hung_up_on()
    address, guess = (
        read_address(f"ice://localhost:{served.ice}"),
        Secret("rtkit-0", "guess"),
    )
    with pytest.raises(PropertyError) as refused:
        IceSession(address, guess, BOUND_S)
    assert refused.value.code == "denied"
    with client(served) as other:
        assert other.ask("speed").payload == "0.25"
        assert other.ask("door/services").payload == "(robot)"


def test_who_says_nothing_is_not_waited_for(place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(endpoint._SETTINGS, "Ice.ACM.Server.Timeout", 2)
    monkeypatch.setattr(endpoint, "STUCK_S", 1.0)
    monkeypatch.setattr(login, "PATIENCE_S", 0.3)
    with serve(subject(), "robot", ice=0, is_on_zenoh=False) as served:
        with (
            Stranger(served.ice) as silent,
            Stranger(served.ice) as half,
            Stranger(served.ice) as unknown,
        ):
            half.message(0, b"half of it", 1000)
            unknown.ask("get", _string("nonce"), "door")
            assert unknown.reply()[4] == 0
            assert silent.is_hung_up_on()
            assert half.is_hung_up_on()
            assert unknown.is_hung_up_on()
        await_that(served, lambda: not guests(served))


def test_giant_values_are_refused_and_harm_nobody_else(served: ServedObject) -> None:
    with client(served) as other, client(served) as giant:
        for size in ((1 << 20) + 2000, 3 << 20):
            assert giant.ask("any", "x" * size).error == "too-large"
            assert giant.ask("x" * size).error == "too-large"
            assert giant.ask("notes", b"x" * size).error == "too-large"
        assert giant.ask("any", "\udc80").error == "syntax"
        assert giant.ask("\udc80").error == "syntax"
        assert giant.ask("any", "()").error == ""
        with Stranger(served.ice) as stranger:
            sender = threading.Thread(
                target=_send, args=(stranger.end, b"IceP\1\0\1\0\0\0" + struct.pack("<i", 3 << 20))
            )
            sender.start()
            assert stranger.is_hung_up_on()
            sender.join(BOUND_S)
        assert other.ask("any").payload == "()"


def test_who_never_reads_answers_costs_little_and_is_given_up(
    place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(endpoint, "STUCK_S", 2.0)
    service = subject()
    service.update("notes", "x" * 500_000)
    with (
        serve(service, "robot", ice=0, is_on_zenoh=False) as served,
        client(served) as other,
        Stranger(served.ice) as deaf,
    ):
        deaf.log_in()
        (guest,) = [each for each in guests(served) if each is not guests(served)[0]]
        for number in range(200):
            deaf.ask("get", _string("notes"), number=number + 2)
        await_that(served, lambda: guest._held)
        assert guest._unread < 3_000_000
        assert other.ask("speed").payload == "0.25"
        await_that(served, lambda: len(guests(served)) == 1)
        assert not guest._held


def test_who_asks_without_end_is_cut_off(
    served: ServedObject, service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(served_client, "_MOST_WAITING", 20)
    go = threading.Event()

    def wait() -> None:
        go.wait(BOUND_S)

    kind = PropertySpec(parse_type("element"), is_functional=True)
    function = FunctionalProperty(wait)
    served.owned(lambda: service.add("slow", function=function, spec=kind))
    went: SimpleQueue[str] = SimpleQueue()
    told: SimpleQueue[Outcome] = SimpleQueue()
    with session(served, went=went.put) as many:
        many.ask("slow?echo", "", told.put)
        for _ in range(30):
            many.ask("slow?echo", "", told.put)
            many.ask("speed?id=1", None, told.put)
        go.set()
        for _ in range(61):
            told.get(timeout=BOUND_S)
        with client(served) as other:
            assert other.ask("speed").payload == "0.25"


# Listeners


def _subscription(
    one: IceSession, target: str, take: Callable[[list[PropertyEvent]], object]
) -> tuple[str, Outcome]:
    told: SimpleQueue[Outcome] = SimpleQueue()
    key = one.listen(target, take, told.put)
    return key, told.get(timeout=BOUND_S)


def _listeners(service: Service) -> int:
    return len(service.listeners._all)


def test_who_never_answers_delays_nobody_and_is_dropped(
    served: ServedObject, service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(subscriber, "STUCK_S", 1.0)
    went: SimpleQueue[str] = SimpleQueue()
    calls: list[int] = []
    never = protocol.runtime().ice.Future()

    def take(events: list[PropertyEvent]) -> object:
        calls.append(len(events))
        return never

    with session(served, went=went.put) as deaf, connect_unix(served.socket, BOUND_S) as other:
        _subscription(deaf, "count?queue=10", take)
        other.listen("count?queue=1000")
        for value in range(100, 200):
            served.owned(lambda value=value: service.update("count", value))  # type: ignore[misc]
        heard = [other.event(BOUND_S) for _ in range(101)]
        assert heard[-1] is not None
        assert heard[-1].payload == "199"
        assert went.get(timeout=BOUND_S) == "the connection has ended"
        assert calls == [1], "what it does not answer is not followed by more"
        await_that(served, lambda: _listeners(service) == 1)
        never.set_result(None)


def test_who_goes_leaves_nothing(served: ServedObject, service: Service) -> None:
    with client(served) as other:
        for _ in range(20):
            gone = session(served)
            _subscription(gone, "count", lambda events: None)
            _subscription(gone, "count?queue=5", lambda events: None)
            key, _ = _subscription(gone, "speed", lambda events: None)
            gone.leave(key)
            gone.close()
        await_that(served, lambda: _listeners(service) == 0 and len(guests(served)) == 1)
        assert other.ask("speed").payload == "0.25"
    await_that(served, lambda: not guests(served))
    assert not door_of(served)._pending


def test_listeners_that_fail_are_dropped(served: ServedObject, service: Service) -> None:
    calls: list[int] = []

    def fail(events: list[PropertyEvent]) -> None:
        calls.append(len(events))
        raise ValueError("not to my taste")

    with session(served) as one:
        _subscription(one, "count", fail)
        for value in range(100):
            served.owned(lambda value=value: service.update("count", 100 + value))  # type: ignore[misc]
            await_that(served, lambda value=value: len(calls) >= min(3, value + 1))  # type: ignore[misc]
            if not _listeners(service):
                break
        assert len(calls) == 3
        key, _ = _subscription(one, "count", lambda events: None)
        one._adapter.remove(protocol.runtime().ice.Identity(key, ""))
        served.owned(lambda: service.update("count", -1))
        await_that(served, lambda: not _listeners(service))


def test_leases_are_kept_and_end(
    served: ServedObject, service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(served_client, "LEASE_S", 3.0)
    monkeypatch.setattr(ice_session, "LEASE_S", 3.0)
    with client(served) as keeps:
        keeps.listen("count")
        assert keeps.event(BOUND_S) is not None
        (listener,) = service.listeners._all.values()
        ends = {listener.ends_at}
        await_that(served, lambda: ends.add(listener.ends_at) or len(ends) > 3)
        with session(served) as lets:
            _, told = _subscription(lets, "speed?lease=0.5", lambda events: None)
            assert told == ice_session.DONE
            await_that(served, lambda: _listeners(service) == 1)
        assert listener in service.listeners._all.values()
        served.owned(lambda: service.update("count", 8))
        event = keeps.event(BOUND_S)
        assert event is not None
        assert event.payload == "8"


def test_who_takes_events_slowly_has_the_door_wait(
    served: ServedObject, service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rtkit.wires.ice.client._MOST_EVENTS", 5)
    with client(served) as slow:
        slow.listen("count?queue=100")
        for value in range(100, 300):
            served.owned(lambda value=value: service.update("count", value))  # type: ignore[misc]
        heard: list[PropertyEvent] = []
        while not heard or heard[-1].payload != "299":
            event = slow.event(BOUND_S)
            assert event is not None
            heard.append(event)
        assert len(heard) + sum(each.dropped for each in heard) == 201
        assert sum(each.dropped for each in heard) > 0


# Ends that go


def test_a_service_that_ends_answers_and_tells(place: str) -> None:
    class Slow:
        def work(self) -> None:
            go.wait(BOUND_S)

    go = threading.Event()
    served = serve(Slow(), "robot", ice=0, is_on_zenoh=False)
    told: SimpleQueue[Outcome] = SimpleQueue()
    with client(served) as waits, session(served) as asks, Stranger(served.ice) as stranger:
        waits.listen("work")
        assert waits.event(BOUND_S) is not None
        asks.ask("work?echo", "", told.put)
        await_that(served, lambda: door_of(served)._pending)
        served.close()
        outcome = told.get(timeout=BOUND_S)
        assert isinstance(outcome, Unreachable) or outcome.error == "no-service"
        with pytest.raises(Unreachable, match="ended"):
            list(iter(waits.event, None))
        with pytest.raises(Unreachable, match="ended"):
            waits.ask("work")
        assert stranger.is_hung_up_on()
        with pytest.raises(Unreachable, match=r"cannot reach ice://localhost:\d+/robot: Conn"):
            client(served)
    go.set()


def test_a_proxy_finds_its_owner_again(place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    said: SimpleQueue[str] = SimpleQueue()
    first, second = subject(), subject()
    second.update("count", 8)
    served = serve(first, "robot", ice=0, is_on_zenoh=False)
    source = f"ice://localhost:{served.ice}/robot"
    path = f"{place}/p.sock"
    with (
        bridge(source, f"unix:{path}", on_status=said.put),
        connect_unix(path, BOUND_S) as endpoint,
    ):
        endpoint.listen("count?queue=9")
        assert _next(endpoint) == ("7", "good")
        served.close()
        assert "ended" in said.get(timeout=BOUND_S)
        assert _next(endpoint) == ("7", "stale")
        assert endpoint.ask("count").error == "no-service"
        with serve(second, "robot", ice=served.ice, is_on_zenoh=False) as again:
            assert said.get(timeout=BOUND_S) == ""
            assert _next(endpoint) == ("8", "good")
            is_held, go = threading.Event(), threading.Event()

            def hold() -> None:
                is_held.set()
                go.wait(BOUND_S)

            monkeypatch.setattr(keepalive, "ASKED_S", 0.5)
            monkeypatch.setattr(keepalive, "DEAD_S", 1.5)
            container = threading.Thread(target=again.owned, args=(hold,))
            container.start()
            assert is_held.wait(BOUND_S)
            assert endpoint.ask("broken").error == "timeout"
            assert _next(endpoint) == ("8", "stale")
            assert "no answer" in said.get(timeout=BOUND_S)
            go.set()
            container.join()
            assert said.get(timeout=BOUND_S) == ""
            assert _next(endpoint) == ("8", "good")


def _next(endpoint: Any) -> tuple[object, str]:
    event = endpoint.event(BOUND_S)
    assert event is not None
    return event.payload, event.quality


def test_a_proxy_has_its_own_rights(place: str, served: ServedObject) -> None:
    source = f"unix:{served.socket}"
    with bridge(source, "ice:0", allow_set=["count"]) as proxy, connect_ice(
        proxy.address, BOUND_S
    ) as endpoint:  # fmt: skip
        assert endpoint.ask("count", "3").error == ""
        assert endpoint.ask("speed", "0").error == "denied"
    with pytest.raises(Refused, match="on this host only, not"):
        bridge(source, "ice:0.0.0.0:0")
    with pytest.raises(Unreachable, match=f"listen on port {served.ice}: Address already in use"):
        bridge(source, f"ice:{served.ice}")


# What is there


def test_several_services_have_names_with_slashes(served: ServedObject) -> None:
    with serve(subject(), "robots/left/arm", ice=0, is_on_zenoh=False) as arm:
        address = f"ice://127.0.0.1:{arm.ice}"
        with connect_ice(f"{address}/robots/left/arm", BOUND_S) as one:
            assert one.ask("speed").payload == "0.25"
            one.listen("count")
        with connect_ice(address, BOUND_S) as endpoint:
            assert endpoint.ask("robots/left/arm/speed").payload == "0.25"
            assert endpoint.ask("elsewhere/speed").error == "no-service"
            assert endpoint.ask("speed").error == "unknown"


def test_without_ice_one_line_tells_the_cure(
    place: str, served: ServedObject, monkeypatch: pytest.MonkeyPatch
) -> None:
    protocol.runtime.cache_clear()
    monkeypatch.setitem(sys.modules, "Ice", None)
    with pytest.raises(Refused, match=r"^Ice needs the package zeroc-ice: pip install 'rtkit\[ice"):
        serve(Service(), "other", ice=0, is_on_zenoh=False)
    with pytest.raises(Refused, match="zeroc-ice"):
        client(served)
    monkeypatch.undo()
    protocol.runtime.cache_clear()


def test_who_listens_there_may_be_somebody_else(served: ServedObject) -> None:
    with socket.create_server(("127.0.0.1", 0)) as squatter:
        port = squatter.getsockname()[1]
        talker = threading.Thread(target=_talk, args=(squatter,))
        talker.start()
        with pytest.raises(RtkitError, match="it speaks no Ice"):
            connect_ice(f"ice://127.0.0.1:{port}", BOUND_S)
        talker.join(BOUND_S)
        with pytest.raises(Unreachable, match="no answer within"):
            connect_ice(f"ice://127.0.0.1:{port}", 0.2)


def _talk(squatter: socket.socket) -> None:
    with squatter.accept()[0] as end:
        _send(end, b"SSH-2.0-OpenSSH_9.2 and more of it\r\n")
        with contextlib.suppress(ConnectionError):
            end.recv(1)
