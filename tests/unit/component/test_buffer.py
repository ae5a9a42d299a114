"""Ring buffers that wait: woken by data, by room, by closing."""

from __future__ import annotations

from threading import Thread
from time import monotonic

import pytest

from rtkit.component.ports.buffer import AwaitedRing, GuardedRing, Pulled, Ring, make_ring
from rtkit.component.ports.options import BufferOptions, EmptyPolicy, FullPolicy, PortStatus

LONG_S = 30.0


def in_thread(action):
    results = []
    thread = Thread(target=lambda: results.append(action()))
    thread.start()
    return thread, results


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        (BufferOptions(), Ring),
        (BufferOptions(empty_policy=EmptyPolicy.DO_NOTHING), Ring),
        (BufferOptions(empty_policy=EmptyPolicy.BLOCK), AwaitedRing),
        (BufferOptions(full_policy=FullPolicy.DO_NOTHING), GuardedRing),
        (BufferOptions(full_policy=FullPolicy.BLOCK), GuardedRing),
    ],
)
def test_the_cheapest_kind_is_made(options, kind):
    assert type(make_ring(options)) is kind


def test_overwrite_drops_the_oldest():
    for options in (BufferOptions(2), BufferOptions(2, empty_policy=EmptyPolicy.BLOCK)):
        ring = make_ring(options)
        assert [ring.write(value) for value in (1, 2, 3)] == [None] * 3
        assert [ring.take(), ring.take(), ring.take()] == [2, 3, None]


def test_do_nothing_refuses_the_new():
    ring = make_ring(BufferOptions(2, FullPolicy.DO_NOTHING))
    assert [ring.write(value) for value in (1, 2, 3)] == [None, None, PortStatus.FULL]
    assert ring.lost == 1
    assert [ring.take(), ring.take(), ring.wait()] == [1, 2, None]


def test_block_gives_up_after_its_time():
    ring = make_ring(BufferOptions(2, FullPolicy.BLOCK, write_timeout=0.0))
    assert [ring.write(value) for value in (1, 2, 3)] == [None, None, PortStatus.TIMEOUT]
    assert ring.lost == 1


def test_a_writer_that_waits_goes_on_when_there_is_room():
    ring = make_ring(BufferOptions(2, FullPolicy.BLOCK, write_timeout=LONG_S))
    ring.write(1)
    ring.write(2)
    thread, results = in_thread(lambda: ring.write(3))
    assert ring.take() == 1
    thread.join(LONG_S)
    assert results == [None]
    assert [ring.take(), ring.take()] == [2, 3]


def test_a_reader_that_waits_goes_on_when_there_is_a_value():
    ring = make_ring(BufferOptions(2, empty_policy=EmptyPolicy.BLOCK, read_timeout=LONG_S))
    thread, results = in_thread(ring.wait)
    ring.write(7)
    thread.join(LONG_S)
    assert results == [7]


@pytest.mark.parametrize("timeout_s", [0.0, 0.001, 0.02])
def test_a_reader_gives_up_after_its_time(timeout_s):
    ring = make_ring(BufferOptions(2, empty_policy=EmptyPolicy.BLOCK, read_timeout=timeout_s))
    began_s = monotonic()
    assert ring.wait() is None
    assert monotonic() - began_s >= timeout_s


def test_readers_that_wait_together_get_a_value_each():
    ring = make_ring(BufferOptions(8, empty_policy=EmptyPolicy.BLOCK, read_timeout=LONG_S))
    readers = [in_thread(ring.wait) for _ in range(4)]
    for value in range(4):
        ring.write(value)
    for thread, _ in readers:
        thread.join(LONG_S)
    assert sorted(read for _, results in readers for read in results) == [0, 1, 2, 3]


def test_a_reader_that_waits_hears_every_value():
    count = 20_000
    ring = make_ring(BufferOptions(count, empty_policy=EmptyPolicy.BLOCK, read_timeout=LONG_S))
    thread, results = in_thread(lambda: [ring.wait() for _ in range(count)])
    for value in range(count):
        ring.write(value)
    thread.join(LONG_S)
    assert results == [list(range(count))]


def test_values_that_were_dropped_are_counted():
    ring = make_ring(BufferOptions(2, empty_policy=EmptyPolicy.BLOCK))
    for value in range(5):
        ring.write(value)
    assert (ring.lost, len(ring)) == (3, 2)


def test_what_came_before_closing_can_still_be_waited_for():
    ring = make_ring(BufferOptions(2, empty_policy=EmptyPolicy.BLOCK, read_timeout=LONG_S))
    ring.write(1)
    ring.close()
    assert [ring.wait(), ring.wait()] == [1, None]


def test_closing_wakes_both():
    reading = make_ring(BufferOptions(2, empty_policy=EmptyPolicy.BLOCK, read_timeout=LONG_S))
    writing = make_ring(BufferOptions(2, FullPolicy.BLOCK, write_timeout=LONG_S))
    writing.write(1)
    writing.write(2)
    reader, read = in_thread(reading.wait)
    writer, written = in_thread(lambda: writing.write(3))
    reading.close()
    writing.close()
    reader.join(LONG_S)
    writer.join(LONG_S)
    assert read == [None]
    assert written == [PortStatus.CONNECTION_LOST]
    assert reading.write(1) is PortStatus.CONNECTION_LOST


def test_pulled_asks_when_it_is_read():
    asked = iter([1, None, 2])
    pulled = Pulled(lambda: next(asked))
    assert len(pulled) == 1
    assert len(pulled) == 1
    assert pulled.take() == 1
    assert len(pulled) == 0
    assert pulled.take() == 2
