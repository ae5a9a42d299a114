"""Push policies."""

from __future__ import annotations

import pytest

from rtkit.component.ports.buffer import Ring, select
from rtkit.component.ports.options import PushPolicy


def ring(count):
    made = Ring(100)
    for number in range(count):
        made.write(number)
    return made


@pytest.mark.parametrize(
    ("policy", "queued", "skip", "sent", "left"),
    [
        ("new", 5, 0, [4], 0),
        ("new", 0, 0, [], 0),
        ("all", 5, 0, [0, 1, 2, 3, 4], 0),
        ("fifo", 5, 0, [0], 4),
        ("fifo", 0, 0, [], 0),
        ("skip", 5, 0, [0, 1, 2, 3, 4], 0),
        ("skip", 5, 1, [1, 3], 1),
        ("skip", 7, 2, [2, 5], 1),
        ("skip", 2, 2, [], 2),
    ],
)
def test_what_is_sent_and_what_stays(policy, queued, skip, sent, left):
    buffer = ring(queued)
    assert select(PushPolicy(policy), buffer, skip) == sent
    assert len(buffer) == left


def test_skip_sends_every_third_however_values_come():
    buffer, sent = Ring(100), []
    for number in range(1, 31):
        buffer.write(number)
        if number % 4 == 0 or number % 7 == 0:
            sent += select(PushPolicy.SKIP, buffer, 2)
    sent += select(PushPolicy.SKIP, buffer, 2)
    assert sent == list(range(3, 31, 3))
