"""Tests of one connection between two processes of a host."""

import socket
from collections.abc import Iterator

import pytest

from rtkit.link.local.channel import MARK, MOST_INLINE, NONE, VALUE, Channel
from rtkit.link.local.slots import SlotPool

LARGE = bytes(range(256)) * (MOST_INLINE // 128)


@pytest.fixture
def ends() -> Iterator[tuple[Channel, Channel]]:
    made = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    one, other = (Channel(each, SlotPool()) for each in made)
    yield one, other
    one.close()
    other.close()


@pytest.mark.parametrize("count", [1, 3])
def test_large_values_go_both_ways(ends: tuple[Channel, Channel], count: int) -> None:
    for sender, receiver in (ends, ends[::-1]):
        for _ in range(count):
            sender.send(LARGE)
            assert receiver.receive() == (VALUE, NONE, LARGE)


def test_a_large_answer_that_comes_too_late_ends_nothing(ends: tuple[Channel, Channel]) -> None:
    asking, answering = ends
    answering.send(LARGE, 1)
    answering.send_notice(MARK, 7)
    asking.take_back()
    assert asking.returned == 7
    asking.send(b"next")
    assert answering.receive() == (VALUE, NONE, b"next")
    answering.send(LARGE, 2)
    assert asking.receive() == (VALUE, 2, LARGE)


def test_the_end_of_the_other_is_told(ends: tuple[Channel, Channel]) -> None:
    one, other = ends
    other.close()
    one.take_back()
    with pytest.raises(BrokenPipeError):
        one.send(b"value")
