"""Rounds of requests: made once for all who need them, and sent after all of them have come."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue

import pytest

from rtkit.api import asked
from rtkit.api.asked import Ask, Rounds, SharedRequests
from rtkit.property.messages import Answer

_BOUND_S = 20.0


def test_who_comes_while_a_round_is_sent_shares_the_next_one() -> None:
    begun: SimpleQueue[SharedRequests] = SimpleQueue()
    go = threading.Semaphore(0)

    def make(made: SharedRequests) -> None:
        begun.put(made)
        assert go.acquire(timeout=_BOUND_S)
        for place, ask in made.asks.items():
            made.take(place, Answer(ask.target))

    rounds = Rounds(make)
    with ThreadPoolExecutor(3) as pool:
        first = pool.submit(rounds.join, [Ask("a.x"), Ask("b.x")])
        under_way = begun.get(timeout=_BOUND_S)
        assert not under_way.is_sent.is_set()
        others = [pool.submit(rounds.join, [Ask("b.x"), Ask(f"{name}.x")]) for name in "cd"]
        while rounds._next is None or len(rounds._next.asks) < 3:
            assert len(under_way.asks) == 2, "none that has come later"
        go.release(2)
        assert first.result(_BOUND_S) == (under_way, [0, 1])
        shared = begun.get(timeout=_BOUND_S)
        assert sorted(each.target for each in shared.asks.values()) == ["b.x", "c.x", "d.x"]
        for other, name in zip(others, "cd", strict=True):
            its_round, places = other.result(_BOUND_S)
            assert its_round is shared
            got = [shared.answers[each].payload for each in places]
            assert got == ["b.x", f"{name}.x"]
    assert begun.empty()


def test_a_round_that_is_not_answered_holds_up_the_next_for_a_moment(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(asked, "_MOMENT_S", 0.01)
    rounds = Rounds(lambda _: None)
    assert [rounds.join([Ask("a.x")])[0].answers for _ in range(2)] == [{}, {}]


def test_a_round_that_cannot_be_made_keeps_nobody_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    def make(_: SharedRequests) -> None:
        raise OSError("no thread")

    rounds = Rounds(make)
    for _ in range(2):
        with pytest.raises(OSError, match="no thread"):
            rounds.join([Ask("a.x")])
