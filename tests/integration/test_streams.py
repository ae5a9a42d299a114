"""Streams of port data between two processes' worth of sockets."""

from __future__ import annotations

import os
import queue
import socket
import threading

import pytest

from rtkit.errors import Unreachable
from rtkit.link.ends import Octets
from rtkit.link.local.channel import FORGET, MARK, PASS, SLOT, USES
from rtkit.link.local.streams import LocalStreams

KEY = "rtd/test/host/wire"
SIZE = 1 << 20


def test_every_value_arrives_in_order(streams: tuple[LocalStreams, LocalStreams]) -> None:
    receiver, sender = streams
    heard: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    endpoint, _ = receiver.receive(KEY, heard.put)
    outlet = sender.send(endpoint, KEY, 5.0, is_blocking=True)
    values = [b"%d" % n for n in range(1000)]
    assert all(outlet.put(value) for value in values)
    assert [heard.get(timeout=5.0) for _ in values] == values


def test_a_sender_without_receiver_is_told(streams: tuple[LocalStreams, LocalStreams]) -> None:
    receiver, sender = streams
    endpoint, _ = receiver.receive(KEY, lambda _: None)
    with pytest.raises(Unreachable, match="nobody takes data"):
        sender.send(endpoint, KEY + "/other", 0.2)


def test_a_view_of_a_large_value_stays_as_it_was(
    streams: tuple[LocalStreams, LocalStreams],
) -> None:
    """Whatever is sent after it, and whether the sender is still there."""
    receiver, sender = streams
    heard: queue.SimpleQueue[Octets] = queue.SimpleQueue()
    endpoint, _ = receiver.receive(KEY, heard.put)
    outlet = sender.send(endpoint, KEY, 5.0, is_blocking=True)
    kept = []
    before = len(os.listdir("/proc/self/fd"))
    for number in range(300):
        assert outlet.put(bytes([number % 256]) * SIZE)
        value = heard.get(timeout=5.0)
        assert value[0] == value[-1] == number % 256
        if number < 40:
            kept.append(value)
    assert len(os.listdir("/proc/self/fd")) < before + 70  # three for each of those on their way
    outlet.close()
    sender.close()
    assert [bytes(value) for value in kept] == [bytes([n]) * SIZE for n in range(40)]


def test_large_values_wait_for_a_receiver_that_is_slow(
    streams: tuple[LocalStreams, LocalStreams],
) -> None:
    receiver, sender = streams
    heard: list[int] = []
    may_go_on = threading.Event()

    def hear(value: Octets) -> None:
        may_go_on.wait(5.0)
        heard.append(value[0])

    endpoint, _ = receiver.receive(KEY, hear)
    outlet = sender.send(endpoint, KEY, 5.0, is_blocking=True)
    threading.Timer(0.1, may_go_on.set).start()
    for number in range(200):
        assert outlet.put(bytes([number]) * SIZE)
    assert outlet.flush(5.0)
    assert heard == [*range(200)]


def test_what_does_not_fit_is_sent_later_in_order(
    streams: tuple[LocalStreams, LocalStreams],
) -> None:
    """A sender that does not wait keeps small values for a receiver that takes none."""
    receiver, sender = streams
    heard: list[Octets] = []
    may_go_on = threading.Event()

    def hear(value: Octets) -> None:
        may_go_on.wait(5.0)
        heard.append(value)

    endpoint, _ = receiver.receive(KEY, hear)
    outlet = sender.send(endpoint, KEY, 5.0)
    values = [b"%d" % n for n in range(20_000)]
    assert all(outlet.put(value) for value in values)
    may_go_on.set()
    assert outlet.flush(10.0)
    assert heard == values


def test_a_reader_receives_by_itself(streams: tuple[LocalStreams, LocalStreams]) -> None:
    receiver, sender = streams
    threads: list[str] = []
    came = threading.Event()

    def hear(value: Octets) -> None:
        threads.append(threading.current_thread().name)
        came.set()

    endpoint, inlet = receiver.receive(KEY, hear)
    outlet = sender.send(endpoint, KEY, 5.0)
    receiving = inlet.borrow()
    assert receiving is not None
    assert inlet.borrow() is None
    assert not receiving.receive(0.01)
    outlet.put(b"1")
    assert receiving.receive(5.0)
    receiving.leave()
    assert threads == [threading.current_thread().name]
    came.clear()
    outlet.put(b"2")  # nobody reads any more: the loop does, in a moment
    assert came.wait(5.0)
    assert threads[1:] == ["data"]


def test_what_has_come_to_a_reader_that_has_gone_is_there_at_once(
    streams: tuple[LocalStreams, LocalStreams],
) -> None:
    receiver, sender = streams
    heard: list[Octets] = []
    endpoint, inlet = receiver.receive(KEY, heard.append)
    outlet = sender.send(endpoint, KEY, 5.0)
    for number in range(100):
        receiving = inlet.borrow()
        assert receiving is not None
        receiving.leave()
        outlet.put(b"%d" % number)
        inlet.sip()
        assert len(heard) == number + 1


def test_a_waiting_reader_is_told_of_the_end(streams: tuple[LocalStreams, LocalStreams]) -> None:
    receiver, sender = streams
    endpoint, inlet = receiver.receive(KEY, lambda _: None)
    outlet = sender.send(endpoint, KEY, 5.0)
    receiving = inlet.borrow()
    assert receiving is not None
    threading.Timer(0.05, outlet.close).start()
    assert not receiving.receive(30.0)
    receiving.leave()
    assert inlet.borrow() is None


def test_descriptors_that_nobody_asked_for_are_closed(
    streams: tuple[LocalStreams, LocalStreams],
) -> None:
    receiver, _ = streams
    heard: queue.SimpleQueue[Octets] = queue.SimpleQueue()
    endpoint, _ = receiver.receive(KEY, heard.put)
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as other, open(os.devnull) as file:
        other.settimeout(5.0)
        other.connect(endpoint)
        other.send(b"rtkit data 2\n" + KEY.encode())
        assert other.recv(1) == b"\1"
        before = len(os.listdir("/proc/self/fd"))
        for step in range(20):
            if step == 10:
                other.send(PASS)  # from now on descriptors are looked for
            socket.send_fds(other, [b"\0value"], [file.fileno(), file.fileno()])
            assert heard.get(timeout=5.0) == b"value"
        assert len(os.listdir("/proc/self/fd")) <= before
        socket.send_fds(other, [USES], [file.fileno()])  # it is no memory
        assert other.recv(1) == b""
        assert len(os.listdir("/proc/self/fd")) <= before


@pytest.mark.parametrize(
    "rubbish", [b"", b"?", USES, SLOT, SLOT + bytes(40), MARK + bytes(4), FORGET, b"\x09"]
)
def test_rubbish_ends_its_connection_only(
    streams: tuple[LocalStreams, LocalStreams], rubbish: bytes
) -> None:
    receiver, sender = streams
    heard: queue.SimpleQueue[Octets] = queue.SimpleQueue()
    endpoint, _ = receiver.receive(KEY, heard.put)
    outlet = sender.send(endpoint, KEY, 5.0)
    for hello in (b"rtkit data 2\n" + KEY.encode(), b"GET / HTTP/1.1"):
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as other:
            other.settimeout(5.0)
            other.connect(endpoint)
            other.send(hello)
            if other.recv(1) == b"\1":
                other.send(rubbish)
                assert other.recv(1) == b""
    outlet.put(b"well")
    assert heard.get(timeout=5.0) == b"well"


def test_a_flush_returns_when_everything_has_arrived(
    streams: tuple[LocalStreams, LocalStreams],
) -> None:
    receiver, sender = streams
    heard: list[bytes] = []
    endpoint, _ = receiver.receive(KEY, heard.append)
    outlet = sender.send(endpoint, KEY, 5.0, is_blocking=True)
    values = [b"%d" % n for n in range(1000)]
    assert all(outlet.put(value) for value in values)
    assert outlet.flush(5.0)
    assert heard == values


def test_a_flush_to_nobody_says_so(streams: tuple[LocalStreams, LocalStreams]) -> None:
    receiver, sender = streams
    endpoint, inlet = receiver.receive(KEY, lambda _: None)
    outlet = sender.send(endpoint, KEY, 5.0)
    inlet.close()
    assert not outlet.flush(0.1)


def test_values_that_get_lost_are_counted(streams: tuple[LocalStreams, LocalStreams]) -> None:
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
    outlet.put(bytes(10))
    outlet.close()
    assert inlet.settle(5.0)  # what was sent is known when the sender has gone, too
    assert inlet.lost + len(heard) == 2001


def test_an_end_closes_while_another_thread_writes(
    streams: tuple[LocalStreams, LocalStreams],
) -> None:
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


def test_values_are_asked_for(streams: tuple[LocalStreams, LocalStreams]) -> None:
    owner, asker = streams
    values = iter([b"first", None, b"third"])
    endpoint, _ = owner.answer(KEY, lambda: next(values))
    fetcher = asker.ask(endpoint, KEY, 5.0)
    assert [fetcher.fetch(5.0) for _ in range(3)] == [b"first", None, b"third"]


@pytest.mark.parametrize("late", [b"late", None])
def test_a_value_that_comes_late_is_not_lost(
    streams: tuple[LocalStreams, LocalStreams], late: bytes | None
) -> None:
    owner, asker = streams
    may_answer = threading.Event()
    values = iter([late, b"next", b"last"])

    def answer() -> bytes | None:
        assert may_answer.wait(30.0)
        return next(values)

    endpoint, _ = owner.answer(KEY, answer)
    fetcher = asker.ask(endpoint, KEY, 5.0)
    assert fetcher.fetch(0.01) is None  # given up
    may_answer.set()
    found = [fetcher.fetch(30.0) for _ in range(3 if late else 2)]
    assert found == [each for each in (late, b"next", b"last") if each]
