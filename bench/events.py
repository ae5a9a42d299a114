"""Measures changes of a property on their way to many listeners, beside a bare fan-out."""

from __future__ import annotations

import select
import socket
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from queue import Empty, SimpleQueue

import zenoh

from bench.harness import Lines, Row
from bench.pairs import Measured, alone, paired
from bench.placement import Placed, kept_on, placements
from bench.properties import key, query, server, session, to_service
from bench.property_ends import FAN
from rtkit.link import places
from rtkit.wires.line.client import connect_unix
from tests.support.zenoh_client import ZenohClient, ZenohSubscription

_TICKS = 500
_LISTENERS = FAN
_SILENCE_S = 2.0
_PIECE = 1 << 16
_BARE_LINES_IS = "a loop that sends the time to each of as many sockets, read by the same loop"
_BARE_ZENOH_IS = "bare zenoh, one put for as many subscribers"


def _over_lines() -> Lines:
    for place in placements():
        yield from _lines_at(place)


def _lines_at(place: Placed) -> Lines:
    lost: list[int] = []
    with kept_on(place.client), server(place.server), ExitStack() as stack:
        client = stack.enter_context(connect_unix(places.service_socket("bench"), 10.0))
        ours = [stack.enter_context(_listening()) for _ in range(_LISTENERS)]
        bare = [stack.enter_context(_connected("bare.fan")) for _ in range(_LISTENERS)]
        measured = paired(
            lambda: _p99_us(ours, lambda: client.ask("run", str(_TICKS)).value(), lost),
            lambda: _p99_us(bare, lambda: bare[0].sendall(b"%d\n" % _TICKS), []),
        )
    yield from _rows(f"as lines, {place.words}", measured, lost, _BARE_LINES_IS)


def _over_zenoh() -> Lines:
    lost: list[int] = []
    with server(), ExitStack() as stack:
        ours = stack.enter_context(to_service())
        bare = stack.enter_context(session(f"{places.runtime_dir()}/bare.zps"))
        client = ZenohClient(ours, key(), 10.0)
        ages: SimpleQueue[int] = SimpleQueue()
        subscriptions: list[ZenohSubscription] = []

        def run() -> None:
            for each in subscriptions:
                each.renew_in_time()
            client.ask("run", str(_TICKS)).value()

        for _ in range(_LISTENERS):
            hear = lambda event: ages.put(_age_ns(str(event.payload)))  # noqa: E731
            listening = client.listen("tick?queue=10000&initial=0", hear)
            subscriptions.append(stack.enter_context(listening))
            handler: zenoh.handlers.Callback[zenoh.Sample] = zenoh.handlers.Callback(
                lambda sample: ages.put(_age_ns(sample.payload.to_string())), indirect=False
            )
            bare.declare_subscriber("bare/tick", handler)
        measured = paired(
            lambda: _heard_us(ages, run, lost),
            lambda: _heard_us(ages, lambda: query(bare, f"bare/get?run={_TICKS}", None), []),
        )
    yield from _rows("over zenoh", measured, lost, _BARE_ZENOH_IS)


PARTS: dict[str, Callable[[], Lines]] = {"line": _over_lines, "zenoh": _over_zenoh}


def _rows(how: str, measured: Measured, lost: Sequence[int], floor_is: str) -> Lines:
    what = f"property: 1000 events/s to {_LISTENERS} listeners {how}"
    yield Row(f"{what}, 99 % within", "us", measured, 2.0, True, floor_is)
    yield Row(f"{what}, lost", "", alone(sum(lost), 0.0), 0.0, False, "all are to come")


def _age_ns(text: str | bytes) -> int:
    return time.perf_counter_ns() - int(text)


def _percentile_us(ages: list[int]) -> float:
    return sorted(ages)[len(ages) * 99 // 100] / 1e3


def _heard_us(ages: SimpleQueue[int], start: Callable[[], object], lost: list[int]) -> float:
    """Return within which time 99 of 100 events were heard that are told to a queue [us]."""
    start()
    heard: list[int] = []
    try:
        while len(heard) < _TICKS * _LISTENERS:
            heard.append(ages.get(timeout=_SILENCE_S))
    except Empty:
        lost.append(_TICKS * _LISTENERS - len(heard))
    return _percentile_us(heard)


def _p99_us(ends: list[socket.socket], start: Callable[[], object], lost: list[int]) -> float:
    """Return within which time 99 of 100 events came that end lines on sockets [us]."""
    with select.epoll() as poll:
        by_number = {end.fileno(): end for end in ends}
        for number in by_number:
            poll.register(number, select.EPOLLIN)
        start()
        ages: list[int] = []
        while len(ages) < _TICKS * _LISTENERS and (ready := poll.poll(_SILENCE_S)):
            for number, _ in ready:
                for line in _whole_lines(by_number[number]):
                    ages.append(_age_ns(line.rpartition(b" ")[2]))
    lost.append(_TICKS * _LISTENERS - len(ages))
    return _percentile_us(ages)


def _whole_lines(end: socket.socket) -> list[bytes]:
    data = end.recv(_PIECE)
    while not data.endswith(b"\n"):
        data += end.recv(_PIECE)
    return data.splitlines()


@contextmanager
def _connected(name: str) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX) as end:
        end.connect(f"{places.runtime_dir()}/{name}")
        yield end


@contextmanager
def _listening() -> Iterator[socket.socket]:
    with _connected("bench.ps") as end:
        end.sendall(b"SET tick.listen?queue=10000&initial=0 self\n")
        if end.recv(_PIECE) != b"=\n":
            raise RuntimeError("the service lets nobody listen")
        yield end
