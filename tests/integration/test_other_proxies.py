"""Proxies on wires that have clients of their own: serial lines and HTTP."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from conformance import ROWS, Door, check_answers, check_events, subject
from propertydoors import BOUND_S, Lines
from serialkit import Cable

from rtkit.link.line_client import connect_unix
from rtkit.property.service import Service
from rtkit.proxy.bridge import bridge
from rtkit.serving.serve import Served, serve


@pytest.fixture
def service() -> Service:
    return subject()


@pytest.fixture
def served(cable: Cable, service: Service) -> Iterator[Served]:
    with serve(service, "robot", http=0, is_on_zenoh=False) as served:
        yield served


@pytest.fixture(params=["serial", "http"])
def door(request: pytest.FixtureRequest, served: Served, cable: Cable) -> Iterator[Door]:
    """A way to the service through two proxies."""
    path = f"{os.path.dirname(cable.near)}/far.sock"
    with ExitStack() as ends:
        source = f"http://localhost:{served.http}/ps/robot"
        if request.param == "http":
            source = ends.enter_context(bridge(source, "http:0", allow_set=["*"])).address
        if request.param == "serial":
            ends.enter_context(bridge("robot", f"serial:{cable.far}", allow_set=["*"]))
            source = f"serial:{cable.near}"
        far = bridge(source, f"unix:{path}", allow_set=["*"], timeout_s=BOUND_S)
        ends.enter_context(far)
        door = Lines(lambda: connect_unix(path, BOUND_S))
        yield door
        door.close()


def test_requests(door: Door) -> None:
    rows = tuple(row for row in ROWS if len(str(row[1])) < 100_000)  # they take minutes on a line
    check_answers(door, rows)


def test_events(door: Door, served: Served, service: Service) -> None:
    check_events(door, service, served.owned)
