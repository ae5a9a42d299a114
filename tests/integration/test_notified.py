"""Events that are SET to properties of other services, where the owner allows it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest

import rtkit
from rtkit.property.service import Service
from rtkit.proxy.bridge import bridge
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serve import ServedObject, serve

BOUND_S = 30.0


def _until(holds: Callable[[], bool]) -> None:
    deadline = time.monotonic() + BOUND_S
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.005)


@pytest.fixture
def source(place: str) -> Iterator[ServedObject]:
    service = Service()
    service.add("angle", 1.0, "number")
    with serve(service, "source", notify=["sink/shown.*"], is_on_zenoh=False) as served:
        yield served


def _sink() -> Service:
    service = Service()
    service.add("shown.angle", 0.0, "number")
    service.add("hidden", 0.0, "number")
    return service


def test_what_changes_is_set_at_the_target(source: ServedObject) -> None:
    sink = _sink()
    with serve(sink, "sink", is_on_zenoh=False), connect_unix(source.socket, BOUND_S) as client:
        assert client.ask("angle.listen", "sink/shown.angle").error == ""
        _until(lambda: sink.get("shown.angle") == "1.0")
        for number in range(20):
            source.update("angle", float(number))
        _until(lambda: sink.get("shown.angle") == "19.0")
        assert client.ask("angle.listen?remove", "sink/shown.angle").error == ""
        assert client.ask("angle.listen?remove", "sink/shown.angle").error == "unknown"
        assert client.ask("angle.listen").payload == "()"
        assert client.ask("angle.listen", "sink.shown.angle").error == ""
        source.update("angle", 3.0)
        _until(lambda: sink.get("shown.angle") == "3.0")
        assert client.ask("angle.listen?remove", "sink/shown.angle").error == ""
        assert client.ask("angle.listen", "sink.hidden").error == "denied"


@pytest.mark.parametrize(
    "target",
    ["sink/hidden", "other/shown.angle", "source/angle", "shown.angle", "tcp://there/x", "("],
)
def test_only_what_is_allowed_is_told(source: ServedObject, target: str) -> None:
    with connect_unix(source.socket, BOUND_S) as client:
        assert client.ask("angle.listen", target).error in ("denied", "syntax")
        assert client.ask("angle.listen").payload == "()"


def test_a_target_that_is_not_there_is_given_up(source: ServedObject) -> None:
    with connect_unix(source.socket, BOUND_S) as client:
        assert client.ask("angle.listen", "sink/shown.angle").error == ""
        numbers = iter(range(10_000))

        def is_given_up() -> bool:
            source.update("angle", float(next(numbers)))
            return client.ask("angle.listen").payload == "()"

        _until(is_given_up)
        # It is told again when somebody asks for that.
        sink = _sink()
        with serve(sink, "sink", is_on_zenoh=False):
            assert client.ask("angle.listen", "sink/shown.angle").error == ""
            last = client.ask("angle").payload
            _until(lambda: sink.get("shown.angle") == last)


DOORS = ("unix", "zenoh", "tcp", "http", "chain")


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("way", ["name", "tcp", "http"])
def test_a_target_is_told_whoever_asks_for_that_and_wherever_it_is(
    door: str, way: str, place: str, ends: ExitStack
) -> None:
    sink, source = _sink(), Service()
    source.add("angle", 1.0, "number")
    there = ends.enter_context(serve(sink, "sink", is_on_zenoh=False, port=0, http=0))
    target = {
        "name": "sink/shown.angle",
        "tcp": f"tcp:localhost:{there.port}/sink/shown.angle",
        "http": f"http://localhost:{there.http}/ps/sink/shown.angle",
    }[way]
    allowed = ["sink/*", "tcp:localhost:*/sink/shown.*", "http://localhost:*/ps/sink/shown.*"]
    here = ends.enter_context(serve(source, "source", notify=allowed, port=0, http=0))
    first = ends.enter_context(bridge("/localhost/source", "tcp:0", allow_set=["angle"]))
    ends.enter_context(bridge(f"{first.address}/source", "zenoh:far", allow_set=["angle"]))
    at = {
        "unix": "source.",
        "zenoh": "zenoh:source.",
        "tcp": f"tcp:localhost:{here.port}/source/",
        "http": f"http://localhost:{here.http}/ps/source/",
        "chain": "zenoh:far.",
    }[door]
    with rtkit.Client(timeout_s=BOUND_S) as client:
        client.set(f"{at}angle.listen", target)
        _until(lambda: sink.get("shown.angle") == "1.0")
        here.update("angle", 5.0)
        _until(lambda: sink.get("shown.angle") == "5.0")
        client.set(f"{at}angle.listen", target, remove=1)
        assert client.get("source.angle.listen") == ()
        for other in ("sink2/shown.angle", f"tcp:localhost:{there.port}/sink/hidden"):
            with pytest.raises(rtkit.PropertyError) as refused:
                client.set(f"{at}angle.listen", other)
            assert refused.value.code == "denied"


def test_a_pattern_of_names_allows_no_address(place: str, ends: ExitStack) -> None:
    source = Service()
    source.add("angle", 1.0, "number")
    here = ends.enter_context(serve(source, "source", notify=["*"], is_on_zenoh=False))
    with connect_unix(here.socket, BOUND_S) as client:
        for far in (
            "tcp:localhost:1/x/y",
            "http://localhost:1/ps/x/y",
            "unix:x/y",
            "tcp:",
            "mqtt:",
        ):
            assert client.ask("angle.listen", far).error in ("denied", "syntax")


def test_a_proxy_that_lets_nothing_be_set_has_nobody_notified(place: str, ends: ExitStack) -> None:
    source, sink = Service(), _sink()
    source.add("angle", 1.0, "number")
    ends.enter_context(serve(sink, "sink", is_on_zenoh=False))
    ends.enter_context(serve(source, "source", notify=["sink/*"], is_on_zenoh=False))
    door = ends.enter_context(bridge("/localhost/source", "tcp:0"))
    with rtkit.Client(timeout_s=BOUND_S) as client:
        with pytest.raises(rtkit.PropertyError) as refused:
            client.set(f"{door.address}/source/angle.listen", "sink/shown.angle")
        assert refused.value.code == "denied"
