"""Messages over private sockets: framed, in pieces, held back, and what is none."""

from __future__ import annotations

import json
import socket
import struct
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rtkit.container.control_channel import MAX_MESSAGE, ControlChannel
from rtkit.errors import Malformed


class Pair:
    """Both ends of a socket, one of them a channel that does not block."""

    def __init__(self) -> None:
        ours, self.theirs = socket.socketpair()
        ours.setblocking(False)
        self.channel = ControlChannel(ours)

    def close(self) -> None:
        self.channel.close()
        self.theirs.close()


@pytest.fixture
def pair() -> Iterator[Pair]:
    pair = Pair()
    yield pair
    pair.close()


def framed(payload: bytes) -> bytes:
    return struct.pack("<I", len(payload)) + payload


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)


@given(
    messages=st.lists(st.dictionaries(st.text(), plain, max_size=3), max_size=5),
    cut=st.integers(1, 50),
)
@settings(suppress_health_check=[HealthCheck.too_slow], deadline=None)
def test_what_is_sent_comes_in_whatever_pieces(messages: list[dict[str, Any]], cut: int) -> None:
    pair = Pair()
    data = b"".join(framed(json.dumps(message).encode()) for message in messages)
    heard: list[Any] = []
    for start in range(0, len(data), cut):
        pair.theirs.sendall(data[start : start + cut])
        heard += pair.channel.receive() or []
    assert heard == messages
    assert pair.channel.receive() == []
    pair.close()


def test_what_does_not_fit_waits_and_keeps_its_order(pair: Pair) -> None:
    messages = [{"n": n, "text": "x" * 10_000} for n in range(200)]
    for message in messages:
        pair.channel.send(message)
    assert pair.channel.has_backlog
    other = ControlChannel(pair.theirs)
    heard: list[Any] = []
    while len(heard) < len(messages):
        heard += other.receive() or []
        pair.channel.flush()
    assert heard == messages
    assert not pair.channel.has_backlog


def test_the_end_of_the_other_is_told(pair: Pair) -> None:
    pair.theirs.sendall(framed(b"{}") + framed(b'{"cut')[:-2])
    pair.theirs.close()
    assert pair.channel.receive() == [{}]
    assert pair.channel.receive() is None
    with pytest.raises(OSError, match="Broken pipe"):
        pair.channel.send({})
    pair.channel.forget_backlog()
    assert not pair.channel.has_backlog


def test_an_end_with_unread_messages_is_an_end_too(pair: Pair) -> None:
    pair.channel.send({"never": "read"})
    pair.theirs.close()
    assert pair.channel.receive() is None


@pytest.mark.parametrize(
    "payload",
    [b"", b"{", b"[]", b"5", b"null", b'"x"', b"\xff", b"[" * 100_000, b"{}{}", b"9" * 5000],
)
def test_what_is_no_message(pair: Pair, payload: bytes) -> None:
    pair.theirs.sendall(framed(payload))
    with pytest.raises(Malformed):
        pair.channel.receive()


def test_a_length_that_nobody_means(pair: Pair) -> None:
    pair.theirs.sendall(struct.pack("<I", MAX_MESSAGE + 1))
    with pytest.raises(Malformed, match=f"message of {MAX_MESSAGE + 1} bytes"):
        pair.channel.receive()


def test_a_line_is_over_though_something_is_still_to_be_read() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        assert not ControlChannel(ours).is_over
        ControlChannel(theirs).send({"last": 1})
        assert not ControlChannel(ours).is_over
        theirs.close()
        assert ControlChannel(ours).is_over
