"""Waits of components for input, and how they end."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest

from rtkit.component.contexts import input_wait, waiting
from rtkit.component.contexts.callbacks import attempt
from rtkit.component.contexts.input_wait import (
    InputEnded,
    allow_input,
    begin_wait,
    check_input,
    end_wait,
    ended_by,
    leave_input,
    wait_of,
)
from rtkit.component.contexts.waiting import grant_by, waiting_for_people


class End:
    """Records what ends the waits of a component."""

    def __init__(self) -> None:
        self.calls: list[str] = []

    def ring(self) -> None:
        self.calls.append("ring")

    def hush(self) -> None:
        self.calls.append("hush")


@pytest.fixture
def end() -> Iterator[End]:
    made = End()
    ended_by("A", made)
    yield made
    ended_by("A", None)
    allow_input("A")


def test_a_wait_is_known_while_it_lasts() -> None:
    begin_wait("A")
    since = time.strftime("%H:%M", time.localtime())
    assert wait_of("A").startswith("waiting for input since ")
    assert since in wait_of("A") or time.strftime("%H:%M", time.localtime()) != since
    end_wait("A")
    assert wait_of("A") == ""


def test_who_is_to_leave_waits_no_more_until_allowed(end: End) -> None:
    check_input("A")
    leave_input("A")
    with pytest.raises(InputEnded):
        check_input("A")
    check_input("B")
    allow_input("A")
    check_input("A")
    assert end.calls == ["ring", "hush"]


def test_who_asks_again_though_it_is_to_leave_is_slowed_down(
    end: End, monkeypatch: pytest.MonkeyPatch
) -> None:
    slept: list[float] = []
    monkeypatch.setattr(input_wait.time, "sleep", slept.append)
    for expected in (0, 1, 2):
        leave_input("A")
        with pytest.raises(InputEnded):
            check_input("A")
        assert len(slept) == expected
    allow_input("A")
    leave_input("A")
    with pytest.raises(InputEnded):
        check_input("A")
    assert len(slept) == 2


def test_who_leaves_its_input_has_not_failed() -> None:
    def on_execute(context: str) -> None:
        try:
            raise InputEnded("A")
        except Exception:
            raise AssertionError("code that handles errors has to let it pass") from None

    failure = attempt(on_execute, "0")
    assert (failure, failure.error) == ("", None)


def test_people_are_waited_for_without_end_and_it_is_no_work(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    grants: list[int] = []
    now_ns = iter([1_000, 61_000_001_000])
    monkeypatch.setattr(waiting.time, "monotonic_ns", lambda: next(now_ns))
    driven = grant_by(grants.append)
    assert driven is not None
    try:
        with waiting_for_people():
            assert grants[0] > 365 * 86_400 * 10**9
    finally:
        grant_by(None)
    assert sum(grants) == 61_000_000_000
    assert driven.take_idle_ns() == 61_000_000_000
    assert driven.take_idle_ns() == 0


def test_who_is_driven_by_nobody_may_wait_for_people() -> None:
    with waiting_for_people():
        pass
