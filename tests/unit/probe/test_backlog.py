"""What a writer waits for: values that a tool has not dealt with."""

from __future__ import annotations

import threading

import pytest

from rtkit.probe.backlog import Backlog
from rtkit.probe.tap import Tap
from rtkit.rtc.profiles import ConnectorProfile, PortRef

SMALL, LARGE = bytes(1000), bytes(100_000)
WIRE = ConnectorProfile("w", "w", (PortRef("A", "out"), PortRef("t", "s")), {})


def held_up(backlog: Backlog, payload: bytes) -> tuple[threading.Thread, threading.Event]:
    """Return a thread that brings a value, and what tells that it has been let in."""
    is_in = threading.Event()

    def bring() -> None:
        backlog.enter(payload)
        is_in.set()

    thread = threading.Thread(target=bring)
    thread.start()
    return thread, is_in


def test_few_large_values_wait_and_many_small_ones() -> None:
    backlog = Backlog(is_lossless=True)
    for _ in range(8000):
        backlog.enter(SMALL)
    thread, is_in = held_up(backlog, LARGE)
    assert not is_in.wait(0.05)
    backlog.leave([SMALL] * 8000)
    thread.join()
    for _ in range(5):
        backlog.enter(LARGE)
    thread, is_in = held_up(backlog, LARGE)
    assert not is_in.wait(0.05)
    backlog.leave([LARGE])
    thread.join()


def test_a_value_that_is_larger_than_all_room_is_let_in_alone() -> None:
    backlog = Backlog(is_lossless=True)
    huge = bytes(20 << 20)
    backlog.enter(huge)
    thread, is_in = held_up(backlog, SMALL)
    assert not is_in.wait(0.05)
    backlog.leave([huge])
    thread.join()


def test_at_the_end_all_are_let_in() -> None:
    backlog = Backlog(is_lossless=True)
    backlog.enter(bytes(9 << 20))
    thread, is_in = held_up(backlog, SMALL)
    assert not is_in.wait(0.05)
    backlog.open()
    thread.join()
    backlog.enter(LARGE)


def test_a_value_that_its_port_refuses_does_not_wait() -> None:
    tap = Tap("s", {"dataport.inport.buffer.length": "4",
                    "dataport.inport.buffer.write.full_policy": "do_nothing"})  # fmt: skip
    tap.backlog = Backlog(is_lossless=True)
    sink = tap.open(WIRE)
    for _ in range(1000):  # they would be ten times what may wait
        sink(LARGE)
    assert [len(each.payload) for each in tap.take()] == [len(LARGE)] * 4


def test_where_values_may_be_lost_what_finds_no_room_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rtkit.probe.backlog._MOST_KEPT_BYTES", 10 * len(LARGE))
    tap = Tap("s", {"dataport.inport.buffer.length": "100"})
    tap.backlog = Backlog(is_lossless=False)
    sink = tap.open(WIRE)
    for _ in range(15):
        sink(LARGE)
    taken = tap.take()
    assert (len(taken), tap.lost) == (10, 5)
    tap.backlog.leave(arrival.payload for arrival in taken)
    sink(LARGE)
    assert (len(tap.take()), tap.lost) == (1, 5)
