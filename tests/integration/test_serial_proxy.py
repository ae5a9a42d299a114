"""A proxy to an owner at the far end of a serial line: as a direct call, and there again."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from queue import SimpleQueue

import pytest
from conformance import check_answers, check_events, subject
from property_endpoints import BOUND_S, Lines
from serialkit import Cable

from rtkit.proxy.bridge import bridge
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serve import ServedObject, serve


@pytest.fixture
def served(cable: Cable) -> Iterator[ServedObject]:
    service = subject()
    with serve(service, "robot", serial=cable.far, settable=["*"], is_on_zenoh=False) as served:
        yield served


def at_proxy(cable: Cable) -> str:
    return os.path.join(os.path.dirname(cable.near), "p.sock")


@contextmanager
def proxied(cable: Cable, said: SimpleQueue[str] | None = None) -> Iterator[Lines]:
    path = at_proxy(cable)
    word = said.put if said is not None else lambda why: None
    address = f"serial:{cable.near}?check=1"
    with bridge(address, f"unix:{path}", allow_set=["*"], said=word):
        endpoint = Lines(lambda: connect_unix(path, BOUND_S))
        yield endpoint
        endpoint.close()


def test_requests(cable: Cable, served: ServedObject) -> None:
    with proxied(cable) as endpoint:
        check_answers(endpoint)


def test_events(cable: Cable, served: ServedObject) -> None:
    with proxied(cable) as endpoint:
        check_events(endpoint, served.service, served.owned)


def test_while_the_device_is_gone_that_is_said(cable: Cable, served: ServedObject) -> None:
    said: SimpleQueue[str] = SimpleQueue()
    with proxied(cable, said) as endpoint, endpoint.listen("count") as events:
        assert next(events).payload == "7"
        cable.unplug(cable.near)
        assert "unplugged" in said.get(timeout=BOUND_S)
        assert endpoint.ask("count").error == "no-service"
        assert next(events).quality == "stale"
        served.owned(lambda: served.service.update("count", 8))
        cable.plug(cable.near)
        while said.get(timeout=BOUND_S):
            pass
        while (event := next(events)).payload != "8":
            pass
        assert event.quality == "good"
        assert endpoint.ask("count").payload == "8"
