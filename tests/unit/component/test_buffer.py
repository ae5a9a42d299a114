"""Ring buffers that wait: woken by data, by room, by closing."""

from __future__ import annotations

from threading import Thread

import pytest

from rtkit.component.buffer import GuardedRing, Pulled, Ring, make_ring
from rtkit.component.options import BufferOptions, EmptyPolicy, FullPolicy, PortStatus

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
        (BufferOptions(empty_policy=EmptyPolicy.BLOCK), GuardedRing),
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


def test_a_reader_gives_up_after_its_time():
    ring = make_ring(BufferOptions(2, empty_policy=EmptyPolicy.BLOCK, read_timeout=0.0))
    assert ring.wait() is None


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
