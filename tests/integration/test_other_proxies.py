"""Proxies on wires that have clients of their own: serial lines, HTTP and Ice."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import icekit
import pytest
from conformance import ROWS, Door, check_answers, check_events, subject
from propertydoors import BOUND_S, Lines
from serialkit import Cable

from rtkit.link.ice_client import IceClient, connect_ice
from rtkit.link.line_client import LineClient, connect_unix
from rtkit.property.service import Service
from rtkit.proxy.bridge import bridge
from rtkit.serving.serve import Served, serve


@pytest.fixture
def service() -> Service:
    return subject()


@pytest.fixture
def served(cable: Cable, service: Service) -> Iterator[Served]:
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
def door(request: pytest.FixtureRequest, served: Served, cable: Cable) -> Iterator[Door]:
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
        door = Lines(connect)
        yield door
        door.close()


def test_requests(door: Door) -> None:
    rows = tuple(row for row in ROWS if len(str(row[1])) < 100_000)  # they take minutes on a line
    check_answers(door, rows)


def test_events(door: Door, served: Served, service: Service) -> None:
    check_events(door, service, served.owned)
