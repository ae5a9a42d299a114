"""A SET over a transport without connections is done in the time of its client, or never."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from time import monotonic

import pytest

from rtkit.link.deadline import (
    boot_id,
    deadline_from_bytes,
    deadline_from_text,
    deadline_to_bytes,
    deadline_to_text,
    split_deadline,
    with_deadline,
)
from rtkit.property.access import read_policy
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.messages import Answer
from rtkit.property.service import Service
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.query_server import QueryServer
from rtkit.wires.zenoh.queries import Joined, Queried


@pytest.fixture
def host() -> Iterator[PropertyEventLoop]:
    host = PropertyEventLoop(read_policy(""))
    yield host
    host.close()


@pytest.mark.parametrize("takes", [QueryServer.take, QueryServer.work])
def test_a_set_whose_client_has_given_up_is_not_done(
    host: PropertyEventLoop, takes: Callable[[QueryServer, Queried], None]
) -> None:
    service = Service("s")
    service.add("speed", 1.0, "number")
    query_server = QueryServer(host, service, "zenoh")
    told: list[Answer] = []

    def answer(reply: Answer, joined: Joined | None = None, /) -> None:
        told.append(reply)

    now = monotonic()
    for until, payload in ((now + 60, "2"), (now - 0.1, "3")):
        takes(query_server, Queried("speed", payload, answer, "", until=until))
    assert told == [Answer(""), Answer(NOT_BEGUN, "timeout")]
    assert service.get("speed") == "2"


def test_a_deadline_is_read_as_it_was_written_on_this_host() -> None:
    before = monotonic()
    assert before + 1.5 <= deadline_from_text(deadline_to_text(1.5)) + 1e-6 <= monotonic() + 1.6


def test_a_deadline_of_another_host_counts_from_when_it_came() -> None:
    assert boot_id() not in (text := "another-boot 12.5 3")
    before = monotonic()
    assert before + 3 <= deadline_from_text(text) <= monotonic() + 3


@pytest.mark.parametrize("text", ["", "rubbish", "a b", "a b c", "a 1 2 3"])
def test_what_is_no_deadline_bounds_nothing(text: str) -> None:
    assert deadline_from_text(text) == math.inf


def test_a_deadline_goes_as_bytes_too() -> None:
    before, own = monotonic(), deadline_to_bytes(3.0)
    assert before + 3 <= deadline_from_bytes(own) <= monotonic() + 3
    came = monotonic()
    assert came + 3 <= deadline_from_bytes(bytes(16) + own[16:]) <= monotonic() + 3


@pytest.mark.parametrize("data", [b"", b"rubbish", bytes(31), bytes(33)])
def test_bytes_that_are_no_deadline_bound_nothing(data: bytes) -> None:
    assert deadline_from_bytes(data) == math.inf


@pytest.mark.parametrize("target", ["speed", "speed?echo", "speed?if=3&id=x"])
def test_a_deadline_travels_as_a_parameter_that_leaves_the_others_alone(target: str) -> None:
    until = monotonic() + 7
    carried = with_deadline(target, until)
    told, found = split_deadline(carried)
    assert (told, abs(found - until) < 1e-5) == (target, True)
    assert split_deadline(f"{carried}&lease=3")[0] in (f"{target}&lease=3", f"{target}?lease=3")
    assert with_deadline(target, math.inf) == target


@pytest.mark.parametrize("target", ["speed", "speed?xdeadline=1", "deadline=3", "a?deadline"])
def test_a_target_without_a_deadline_stays_as_it_is(target: str) -> None:
    assert split_deadline(target) == (target, math.inf)
