"""Proxies on wires that have clients of their own: serial lines, HTTP and Ice."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from queue import SimpleQueue

import icekit
import pytest
from conformance import ROWS, Door, check_answers, check_events, check_once, subject
from property_endpoints import BOUND_S, Lines
from serialkit import Cable

from rtkit.property.functional import FunctionalProperty
from rtkit.property.messages import Answer
from rtkit.property.service import Service
from rtkit.property.spec import PropertySpec
from rtkit.property.types import parse_type
from rtkit.proxy.bridge import bridge
from rtkit.wires.ice.client import IceClient, connect_ice
from rtkit.wires.line.client import LineClient, connect_unix
from rtkit.wires.serve import ServedObject, serve


@pytest.fixture
def service() -> Service:
    return subject()


@pytest.fixture
def served(cable: Cable, service: Service) -> Iterator[ServedObject]:
    with serve(service, "robot", http=0, ice=icekit.PORT, is_on_zenoh=False) as served:
        yield served


_IF_ICE = pytest.mark.skipif(not icekit.IS_THERE, reason=icekit.MISSING)


@pytest.fixture(
    params=[
        "serial",
        "http",
        pytest.param("ice", marks=_IF_ICE),
        pytest.param("to ice", marks=_IF_ICE),
    ]
)
def endpoint(request: pytest.FixtureRequest, served: ServedObject, cable: Cable) -> Iterator[Door]:
    """A way to the service through two proxies."""
    path = f"{os.path.dirname(cable.near)}/far.sock"
    with ExitStack() as ends:
        source, target = f"http://localhost:{served.http}/ps/robot", f"unix:{path}"
        connect: Callable[[], LineClient | IceClient] = lambda: connect_unix(path, BOUND_S)  # noqa: E731
        if request.param == "http":
            source = ends.enter_context(bridge(source, "http:0", allow_set=["*"])).address
        elif request.param == "serial":
            ends.enter_context(bridge("robot", f"serial:{cable.far}", allow_set=["*"]))
            source = f"serial:{cable.near}"
        elif request.param == "ice":
            source = f"ice://localhost:{served.ice}/robot"
            source = ends.enter_context(bridge(source, "ice:0", allow_set=["*"])).address
        else:
            source = ends.enter_context(bridge(source, "tcp:0", allow_set=["*"])).address
            target = "ice:0"
        far = bridge(source, target, allow_set=["*"], timeout_s=BOUND_S)
        ends.enter_context(far)
        if target == "ice:0":
            connect = lambda: connect_ice(far.address, BOUND_S)  # noqa: E731
        endpoint = Lines(connect)
        yield endpoint
        endpoint.close()


def test_requests(endpoint: Door) -> None:
    rows = tuple(row for row in ROWS if len(str(row[1])) < 100_000)  # they take minutes on a line
    check_answers(endpoint, rows)


def test_events(endpoint: Door, served: ServedObject, service: Service) -> None:
    check_events(endpoint, service, served.owned)


@pytest.mark.parametrize("endpoint", ["serial", "http", pytest.param("ice", marks=_IF_ICE)],
                         indirect=True)  # fmt: skip
def test_a_request_that_is_repeated_with_its_id_acts_once(endpoint: Door, cable: Cable) -> None:
    check_once(f"{os.path.dirname(cable.near)}/far.sock")


def test_what_is_slow_to_get_holds_nobody_up(cable: Cable, served: ServedObject) -> None:
    """Over wires that answer one request at a time there are more of them."""
    go = threading.Event()

    def wait() -> int:
        go.wait(BOUND_S)
        return 3

    kind = PropertySpec(parse_type("element"), is_functional=True)
    function = FunctionalProperty(wait)
    served.owned(lambda: served.service.add("slow", function=function, spec=kind))
    path = f"{os.path.dirname(cable.near)}/slow.sock"
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
    served: ServedObject, cable: Cable
) -> None:
    path = f"{os.path.dirname(cable.near)}/near.sock"
    near = bridge("robot", f"unix:{path}", allow_set=["lab.mode"], prefix="lab")
    with near, connect_unix(path, BOUND_S) as client:
        assert client.ask("lab.speed.meta.access").value() == "r"
        assert client.ask("lab.mode.meta.access").value() == "rw"
        assert "<access>r</access>" in str(client.ask("lab.speed.meta").value())
        for listing in ("lab.properties?meta", "properties?meta&all"):
            told = str(client.ask(listing).value())
            assert told.count("<access>rw</access>") == 1
