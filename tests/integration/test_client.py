"""Clients of services: one connection for each owner, whatever the wire; many asked at once."""

from __future__ import annotations

import asyncio
import math
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from time import monotonic

import pytest

import rtkit
from rtkit.api.properties import PropertyChange
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer
from rtkit.property.requests import UNDER_WAY, UnderWay
from rtkit.wires.line.provider_connection import LineConnection
from rtkit.wires.serve import ServedObject, serve

_BOUND_S = 20.0
_OWNER = """
import rtkit, sys
class Light:
    level = 1
with rtkit.serve(Light(), 'l'):
    print('up', flush=True)
    sys.stdin.read()
"""


class Beginning:
    """Begins tasks of asyncio, which inherit the context of the request."""

    async def get_until(self) -> float:
        async def of_task() -> float:
            return UNDER_WAY.get().until

        return await asyncio.create_task(of_task())


class Light:
    """Light that can be dimmed."""

    def __init__(self) -> None:
        self.level = 0.5
        self.name = "lamp"
        self.pose = (1.0, 2.0, 3.0)
        self._go = threading.Event()

    def get_slow(self) -> int:
        assert self._go.wait(_BOUND_S)
        return 1

    def add(self, a: float, b: float = 1.0) -> float:
        return a + b

    def wait(self) -> str:
        assert self._go.wait(_BOUND_S)
        return "ready"

    def go(self) -> None:
        self._go.set()

    def fail(self) -> None:
        raise ValueError("no such thing")

    def get_scaled(self, by: float = 1.0) -> float:
        return self.level * by


@pytest.fixture
def light(place: str) -> Iterator[ServedObject]:
    with serve(Light(), "house/light", port=0, http=0) as served:
        yield served


@pytest.fixture
def client(light: ServedObject) -> Iterator[rtkit.Client]:
    with rtkit.Client(timeout_s=_BOUND_S) as client:
        yield client


def _error(work: object) -> str:
    with pytest.raises(PropertyError) as caught:
        work()  # type: ignore[operator]
    return caught.value.code


@pytest.mark.parametrize("wire", ["unix", "tcp", "http", "zenoh"])
def test_gets_sets_and_calls_over_each_wire(
    wire: str, light: ServedObject, client: rtkit.Client
) -> None:
    at = {
        "unix": "house/light.",
        "tcp": f"tcp:localhost:{light.port}/house/light/",
        "http": f"http://localhost:{light.http}/ps/house/light/",
        "zenoh": "zenoh:house/light.",
    }[wire]
    assert (client.get(f"{at}level"), client.get(f"{at}name")) == (0.5, "lamp")
    client.set(f"{at}level", 0.25)
    assert client.get(f"{at}level") == 0.25
    client.set(f"{at}level", "0.75")
    assert client.get(f"{at}scaled", by=2) == client.get(f"{at}scaled?by=2") == 1.5
    assert client.get(f"{at}pose") == (1.0, 2.0, 3.0)
    assert client.call(f"{at}add", 1) == 2
    assert client.call(f"{at}add", 1, b=2.5) == 3.5
    assert _error(lambda: client.call(f"{at}fail")) == "bad-value"
    assert _error(lambda: client.call(f"{at}add")) == "bad-value"
    assert _error(lambda: client.get(f"{at}none")) == "unknown"
    assert _error(lambda: client.set(f"{at}level", "red")) == "bad-value"
    assert _error(lambda: client.get(f"{at}level", of=1)) == "bad-parameter"


def test_what_takes_long_delays_no_other_request_of_the_same_client(client: rtkit.Client) -> None:
    results: list[object] = []
    work = [
        threading.Thread(target=lambda: results.append(client.call("house/light.wait"))),
        threading.Thread(target=lambda: results.append(client.get("house/light.slow"))),
    ]
    for each in work:
        each.start()
    while client.get("house/light.wait.state") != "running":
        pass
    assert client.get("house/light.level") == 0.5
    assert _error(lambda: client.call("house/light.wait", timeout_s=_BOUND_S)) == "busy"
    client.call("house/light.go")
    for each in work:
        each.join(_BOUND_S)
    assert sorted(map(str, results)) == ["1", "ready"]


def test_a_call_that_outlasts_its_bound_goes_on(client: rtkit.Client) -> None:
    began = monotonic()
    assert _error(lambda: client.call("house/light.wait", timeout_s=0.05)) == "timeout"
    assert monotonic() - began < _BOUND_S / 2
    assert client.get("house/light.wait.state") == "running"
    client.call("house/light.go")


def test_an_owner_that_has_returned_is_asked_anew(place: str) -> None:
    with rtkit.Client(timeout_s=_BOUND_S) as client:
        for level in (1, 2):
            light = Light()
            light.level = level
            with serve(light, "light"):
                assert client.get("light.level") == level
            assert _error(lambda: client.get("light.level")) == "no-service"
    assert _error(lambda: client.get("light.level")) == "no-service"


def test_all_are_asked_at_once_and_the_dead_and_the_slow_are_named(place: str) -> None:
    lights = [serve(Light(), f"l{index}", is_on_zenoh=False) for index in range(10)]
    with rtkit.Client() as client:
        asks = [rtkit.Ask(f"l{index}.level") for index in range(10)]
        assert client.ask_all(asks, _BOUND_S) == [0.5] * 10
        lights[3].close()
        asks[4] = rtkit.Ask("l4.slow")
        asks[5] = rtkit.Ask("l5.level", 0.125)
        asks[6] = rtkit.Ask("l6.scaled", parameters={"by": 4})
        asks[7] = rtkit.Ask("tcp:localhost:1/none/x")
        began = monotonic()
        got = client.ask_all(asks, 0.5)
        took = monotonic() - began
        codes = [each.code if isinstance(each, PropertyError) else each for each in got]
        assert codes[:3] == [0.5] * 3
        assert codes[3:8] == ["no-service", "timeout", "", 2.0, "no-service"]
        assert took < 5.0
        assert client.get("l5.level") == 0.125
        client.call("l4.go")
        assert client.ask_all([], 1.0) == []
    for each in lights:
        each.close()


def test_an_answer_that_has_come_counts_however_late_the_client_itself_is(place: str) -> None:
    """Its loop is held up as the answer comes, until the answer would be late.

    On a busy machine the request itself may be late: then it is tried with more time.
    """
    with rtkit.Client() as client:
        is_held, release = threading.Event(), threading.Event()

        class Holding:
            def get_level(self) -> float:
                client._host.post(lambda: is_held.set() or release.wait(_BOUND_S))
                assert is_held.wait(_BOUND_S)
                threading.Timer(deadline_s + 0.2, release.set).start()
                return 0.5

        for is_shared in (False, True):
            found: list[object] = []
            for deadline_s in (0.1, 1.0, 5.0):
                is_held.clear(), release.clear()
                with serve(Holding(), "l", is_on_zenoh=False):
                    found = client.ask_all([rtkit.Ask("l.level")], deadline_s, is_shared=is_shared)
                if found == [0.5]:
                    break
            assert found == [0.5]


def test_a_shared_request_ends_in_time_for_the_request_that_makes_it(place: str) -> None:
    found: list[object] = []
    with serve(Light(), "l"), rtkit.Client() as client:
        ask = lambda: client.ask_all([rtkit.Ask("l.slow")], _BOUND_S, is_shared=True)  # noqa: E731
        began = monotonic()
        UnderWay(until=began + 0.5).call(lambda: found.extend(ask()))
        assert monotonic() - began < _BOUND_S / 2
        client.call("l.go")
    assert [each.code for each in found if isinstance(each, PropertyError)] == ["timeout"]


def test_what_a_request_began_may_ask_after_its_time(place: str) -> None:
    found: list[object] = []
    long_over = UnderWay(until=monotonic() - 1.0)
    with serve(Light(), "l"), rtkit.Client() as client:
        long_over.call(lambda: found.extend(client.ask_all([rtkit.Ask("l.level")], _BOUND_S)))
    assert found == [0.5]


def test_a_task_that_a_request_began_has_its_time(place: str) -> None:
    with serve(Beginning(), "b"), rtkit.Client() as client:
        (until,) = client.ask_all([rtkit.Ask("b.until", parameters={"timeout": 9})], 9.0)
        assert until <= monotonic() + 9.0


def test_a_set_that_is_given_up_is_never_done(place: str) -> None:
    """Its owner is stopped, and continues once the client has given up."""
    owner = subprocess.Popen(
        [sys.executable, "-c", _OWNER], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert owner.stdout is not None
    assert owner.stdout.readline() == b"up\n"
    try:
        with rtkit.Client(timeout_s=_BOUND_S) as client:
            assert client.get("l.level") == 1
            owner.send_signal(signal.SIGSTOP)
            os.waitpid(owner.pid, os.WUNTRACED)
            answers = client.ask_all([rtkit.Ask("l.level", 2)], 0.1)
            assert answers[0].code == "timeout"
            owner.send_signal(signal.SIGCONT)
            assert client.get("l.level") == 1
    finally:
        owner.send_signal(signal.SIGCONT)
        owner.communicate(b"")


def test_a_client_that_was_closed_says_so(client: rtkit.Client) -> None:
    assert client.get("house/light.level") == 0.5
    client.close()
    client.close()
    assert _error(lambda: client.get("house/light.level")) == "no-service"


def test_markers_come_as_markers(place: str) -> None:
    ball = rtkit.Marker((1.0, 2.0, 0.0), type="ball")

    class Eye:
        markers: list[rtkit.Marker] = [ball]  # noqa: RUF012  as a newcomer writes it

        def nearest(self, to: rtkit.Marker) -> rtkit.Marker:
            return to.with_(name="near")

    with serve(Eye(), "eye", is_on_zenoh=False), rtkit.Client() as client:
        assert client.get("eye.markers") == (ball,)
        client.set("eye.markers", [ball, ball])
        assert client.get("eye.markers.1") == ball
        assert client.call("eye.nearest", ball) == ball.with_(name="near")


def _next(changes: SimpleQueue[PropertyChange]) -> PropertyChange:
    return changes.get(timeout=_BOUND_S)


@pytest.mark.parametrize("wire", ["unix", "zenoh"])
def test_listening_survives_its_owner_and_names_when_it_is_away(wire: str, place: str) -> None:
    target = {"unix": "light.level", "zenoh": "zenoh:light.level"}[wire]
    changes: SimpleQueue[PropertyChange] = SimpleQueue()
    with rtkit.Client(timeout_s=_BOUND_S) as client:
        assert _error(lambda: client.listen(target, changes.put)) == "no-service"
        served = serve(Light(), "light")
        listening = client.listen(target, changes.put)
        assert _next(changes)[:2] == (target, 0.5)
        client.set(target, 0.25)
        assert _next(changes)[1:5:3] == (0.25, "")
        served.close()
        away = _next(changes)
        assert (away.quality, away.code) == ("stale", "no-service")
        with serve(Light(), "light"):
            back = _next(changes)
            assert (back.value, back.quality, back.code) == (0.5, "good", "")
            listening.close()
            assert client.get(target) == 0.5
            client.set(target, 1.0)
            assert changes.empty()


def test_listening_ends_with_its_property_and_what_a_callback_raises_is_reported(
    place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    changes: SimpleQueue[PropertyChange] = SimpleQueue()
    raised: SimpleQueue[object] = SimpleQueue()
    monkeypatch.setattr(threading, "excepthook", raised.put)
    things: dict[str, object] = {"a": 1, "b": 2}

    def hear(change: PropertyChange) -> None:
        changes.put(change)
        raise LookupError

    with serve(things, "things", is_on_zenoh=False), rtkit.Client(timeout_s=_BOUND_S) as client:
        assert _error(lambda: client.listen("things.c", hear)) == "unknown"
        client.listen("things.a", hear)
        assert _next(changes).value == 1
        raised.get(timeout=_BOUND_S)
        del things["a"]
        assert client.get("things.properties") == ("b",)
        assert _next(changes).code == "unknown"


def test_a_callback_may_ask_and_only_the_latest_value_waits_for_it(client: rtkit.Client) -> None:
    seen: list[object] = []
    is_over, go = threading.Event(), threading.Event()

    def hear(change: PropertyChange) -> None:
        assert go.wait(_BOUND_S)
        seen.append(client.get(change.target))
        if change.value == 99:
            is_over.set()

    with client.listen("house/light.level", hear):
        for level in range(100):
            client.set("house/light.level", level)
        go.set()
        assert is_over.wait(_BOUND_S)
    assert len(seen) < 10


class Archive:
    """Archive that has more to tell than one value may be long where it is set."""

    def get_items(self) -> list[str]:
        return [f"item number {count}" for count in range(60_000)]

    def get_numbers(self) -> list[float]:
        return [float(count) for count in range(150_000)]

    def get_markers(self) -> list[rtkit.Marker]:
        return [rtkit.Marker(location=(float(count), 0.0, 0.0)) for count in range(20_000)]

    def get_note(self) -> rtkit.Text:
        return rtkit.Text("(no value " * 150_000)


@pytest.mark.parametrize("wire", ["", "tcp"])
def test_values_above_a_mebibyte_come_as_what_they_are(wire: str, place: str) -> None:
    with serve(Archive(), "archive", port=0) as served, rtkit.Client(timeout_s=_BOUND_S) as client:
        at = f"tcp:127.0.0.1:{served.port}/archive" if wire else "archive"
        items, numbers = client.get(f"{at}.items"), client.get(f"{at}.numbers")
        assert (len(items), items[-1]) == (60_000, "item number 59999")
        assert (len(numbers), numbers[-1]) == (150_000, 149_999.0)
        markers = client.get(f"{at}.markers")
        assert (len(markers), markers[-1].location) == (20_000, (19_999.0, 0.0, 0.0))
        assert client.get(f"{at}.note") == "(no value " * 150_000
        with pytest.raises(PropertyError) as refused:
            client.set(f"{at}.items", items)
        assert refused.value.code == "too-large"


def test_an_owner_that_is_asked_after_its_end_begins_no_thread(place: str) -> None:
    """As by a thread that had found it before the client was closed."""
    client = rtkit.Client()
    _, owner = client._owners.find("localhost.services")
    client.close()
    before, answers = threading.enumerate(), list[Answer]()
    with client._host.lock:
        owner.ask("services", None, answers.append, math.inf)
    assert set(threading.enumerate()) <= set(before)
    assert [each.error for each in answers] == ["no-service"]
    assert _error(lambda: client._owners.find("localhost.services")) == "no-service"


def test_who_asks_receives_the_answer_itself(
    light: ServedObject, monkeypatch: pytest.MonkeyPatch
) -> None:
    receivers: list[int] = []
    receive = LineConnection._receive

    def noted(connection: LineConnection) -> None:
        receivers.append(threading.get_ident())
        receive(connection)

    monkeypatch.setattr(LineConnection, "_receive", noted)
    with rtkit.Client(_BOUND_S) as client:
        until = monotonic() + _BOUND_S
        while threading.get_ident() not in receivers:  # unless the answer was here by then
            assert client.get("house/light.level") == 0.5
            assert monotonic() < until


def test_two_threads_that_wait_each_get_their_own_answer(light: ServedObject) -> None:
    with rtkit.Client(_BOUND_S) as client, ThreadPoolExecutor(4) as pool:
        slow = pool.submit(client.get, "house/light.slow")
        others = [pool.submit(client.get, f"house/light.{name}") for name in ("level", "name")]
        assert [each.result(_BOUND_S) for each in others] == [0.5, "lamp"]
        assert not slow.done()
        client.call("house/light.go")
        assert slow.result(_BOUND_S) == 1
        assert client.get("house/light.level") == 0.5


@pytest.mark.parametrize("ends", ["client", "owner"])
def test_who_waits_hears_of_the_end(light: ServedObject, ends: str) -> None:
    client = rtkit.Client(3600.0)
    with client, ThreadPoolExecutor(1) as pool:
        client.get("house/light.level")
        waiting = pool.submit(client.get, "house/light.slow")
        connection = next(iter(client._owners._owners.values()))._connection
        assert isinstance(connection, LineConnection)
        until = monotonic() + _BOUND_S
        while not connection._is_lent:
            assert monotonic() < until
        (client if ends == "client" else light).close()
        with pytest.raises(PropertyError) as caught:
            waiting.result(_BOUND_S)
        assert caught.value.code == "no-service"
