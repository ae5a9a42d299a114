"""Events that are SET to properties of other services, where the owner allows it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import pytest

from rtkit.property.service import Service
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
