"""Streams of port data between two real zenoh sessions."""

from __future__ import annotations

import queue
import threading
from typing import Any

import pytest

from rtkit.errors import Unreachable
from rtkit.link import zenoh
from rtkit.link.streams import Streams

KEY = "rtd/test/host/wire"


def test_every_value_arrives_in_order(streams: tuple[Streams, Streams]) -> None:
    receiver, sender = streams
    heard: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    endpoint, _ = receiver.receive(KEY, heard.put)
    outlet = sender.send(endpoint, KEY, 5.0, is_blocking=True)
    values = [b"%d" % n for n in range(1000)]
    assert all(outlet.put(value) for value in values)
    assert [heard.get(timeout=5.0) for _ in values] == values


def test_a_sender_without_receiver_is_told(streams: tuple[Streams, Streams]) -> None:
    receiver, sender = streams
    endpoint, _ = receiver.receive(KEY, lambda _: None)
    with pytest.raises(Unreachable, match="nobody takes data"):
        sender.send(endpoint, KEY + "/other", 0.2)


def test_a_link_is_made_where_no_shared_memory_can_be_had(
    streams: tuple[Streams, Streams], monkeypatch: pytest.MonkeyPatch
) -> None:
    def without(name: str) -> None:
        real = getattr(zenoh, name)

        def opened(*arguments: Any, has_shared_memory: bool, **named: Any) -> Any:
            if has_shared_memory:
                raise Unreachable("no shm segment")
            return real(*arguments, has_shared_memory=False, **named)

        monkeypatch.setattr(zenoh, name, opened)

    without("open_listener")
    without("open_client")
    receiver, sender = streams
    told: list[str] = []
    got: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    receiver.report = sender.report = told.append
    for key in ("one", "two"):
        endpoint, _ = receiver.receive(key, got.put)
        sender.send(endpoint, key, 5.0, is_blocking=True).put(bytes(1 << 20))
        assert len(got.get(timeout=5.0)) == 1 << 20
    assert receiver.slow == sender.slow == "no shm segment"
    assert len(told) == 2, told


def test_a_flush_returns_when_everything_has_arrived(streams: tuple[Streams, Streams]) -> None:
    receiver, sender = streams
    heard: list[bytes] = []
    endpoint, _ = receiver.receive(KEY, heard.append)
    outlet = sender.send(endpoint, KEY, 5.0, is_blocking=True)
    values = [b"%d" % n for n in range(1000)]
    assert all(outlet.put(value) for value in values)
    assert outlet.flush(5.0)
    assert heard == values


def test_a_flush_to_nobody_says_so(streams: tuple[Streams, Streams]) -> None:
    receiver, sender = streams
    endpoint, inlet = receiver.receive(KEY, lambda _: None)
    outlet = sender.send(endpoint, KEY, 5.0)
    inlet.close()
    assert not outlet.flush(0.1)


def test_values_that_get_lost_are_counted(streams: tuple[Streams, Streams]) -> None:
    receiver, sender = streams
    is_slow = threading.Event()
    heard: list[bytes] = []

    def hear(payload: bytes) -> None:
        is_slow.wait(5.0)
        heard.append(payload)

    endpoint, inlet = receiver.receive(KEY, hear)
    outlet = sender.send(endpoint, KEY, 5.0, is_numbered=True)
    for _ in range(2000):
        outlet.put(bytes(100_000))
    is_slow.set()
    assert inlet.settle(10.0)  # counts also what was lost behind the last value that came
    assert inlet.lost > 0
    assert inlet.lost + len(heard) == 2000
    outlet.close()
    assert not inlet.settle(0.1)


def test_an_end_closes_while_another_thread_writes(streams: tuple[Streams, Streams]) -> None:
    receiver, sender = streams
    endpoint, _ = receiver.receive(KEY, lambda _: None)
    for _ in range(50):
        outlet = sender.send(endpoint, KEY, 5.0)
        is_writing = threading.Event()
        failures: list[BaseException] = []

        def write(outlet=outlet, is_writing=is_writing, failures=failures) -> None:
            try:
                while outlet.put(bytes(100_000)):
                    is_writing.set()
            except BaseException as error:
                failures.append(error)

        writer = threading.Thread(target=write)
        writer.start()
        assert is_writing.wait(5.0)
        outlet.close()
        writer.join(5.0)
        assert not writer.is_alive()
        assert failures == []


def test_values_are_asked_for(streams: tuple[Streams, Streams]) -> None:
    owner, asker = streams
    values = iter([b"first", None, b"third"])
    endpoint, _ = owner.answer(KEY, lambda: next(values))
    fetcher = asker.ask(endpoint, KEY, 5.0)
    assert [fetcher.fetch(5.0) for _ in range(3)] == [b"first", None, b"third"]
