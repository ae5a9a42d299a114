"""Silence of another host: what counts as a word of it, and for how long."""

from __future__ import annotations

import math
import socket
import threading

import pytest

from rtkit.hosts import silence
from rtkit.hosts.silence import await_silence, packet_silence

_MOST_S = 0.01


def never() -> None:
    threading.Event().wait()


def test_a_host_that_says_nothing_is_given_up() -> None:
    assert await_silence(never, _MOST_S, lambda: math.inf).startswith("no answer in ")


def test_one_whose_packets_come_is_waited_for_until_they_no_longer_do() -> None:
    packets = [math.inf, 0.0, 0.0, 0.0]
    told = await_silence(never, _MOST_S, lambda: math.inf, packets.pop)
    assert told.startswith("no answer in ")
    assert packets == []


def test_one_whose_packets_come_but_no_answer_is_given_up_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(silence, "_STALLED_S", 3 * _MOST_S)
    told = await_silence(never, _MOST_S, lambda: math.inf, lambda: 0.0)
    assert told.startswith("no answer in ")


def test_one_that_is_heard_otherwise_is_waited_for() -> None:
    heard = [math.inf, 0.0, 0.0, 0.0]
    assert await_silence(never, _MOST_S, heard.pop).startswith("no answer in ")
    assert heard == []


def test_packets_are_told_of_sockets_of_tcp_only() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        with socket.create_connection(listener.getsockname()) as end:
            assert packet_silence(end) < math.inf
        assert packet_silence(end) == math.inf, "it is closed"
    near, far = socket.socketpair()
    with near, far:
        assert packet_silence(near) == math.inf
    assert packet_silence(object()) == math.inf
