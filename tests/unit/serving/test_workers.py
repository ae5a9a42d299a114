"""Workers run user code in its turn, go on beside what is slow, and give up what takes too long."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from functools import partial
from time import monotonic

import pytest

from rtkit.property.codes import PropertyError
from rtkit.property.lanes import ALONE
from rtkit.property.messages import Answer
from rtkit.serving import workers as module
from rtkit.serving.workers import Workers

BOUND_S = 30.0


class Owner:
    """A loop without one: it is asked to look when a test says so."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.workers = Workers(self.lock, lambda work: work())
        self.done: list[str] = []
        self.refused: list[Answer] = []
        self.has_more = threading.Condition(self.lock)

    def later(self, lane: str, what: str, code: Callable[[], object], wait: float = 0.0) -> None:
        def work() -> None:
            outcome = self.workers.call(code)
            self.done.append(f"{what}: {outcome.result or type(outcome.error).__name__}")
            self.has_more.notify_all()

        with self.lock:
            self.workers.later(lane, work, self.refused.append, wait)

    def await_done(self, count: int) -> list[str]:
        with self.lock:
            assert self.has_more.wait_for(lambda: len(self.done) >= count, BOUND_S)
            return self.done

    def look(self, after_s: float) -> None:
        with self.lock:
            self.workers.check(monotonic() + after_s)


@pytest.fixture
def owner() -> Iterator[Owner]:
    owner = Owner()
    yield owner
    owner.workers.close()


def _raise(error: BaseException) -> object:
    raise error


def test_all_goes_on_one_thread_in_order_whatever_is_raised(owner: Owner) -> None:
    threads = set()
    for index, error in enumerate((SystemExit(), KeyboardInterrupt(), GeneratorExit())):
        owner.later("a", f"{index}", partial(_raise, error))
        owner.later(f"lane {index}", "thread", lambda: threads.add(threading.get_ident()) or "was")
    owner.await_done(6)
    assert [each for each in owner.done if each != "thread: was"] == [
        "0: SystemExit", "1: KeyboardInterrupt", "2: GeneratorExit"]  # fmt: skip
    assert len(threads) == 1


def test_what_is_slow_holds_up_its_own_lane_only(owner: Owner) -> None:
    is_free, has_begun = threading.Event(), threading.Event()

    def slow() -> str:
        has_begun.set()
        is_free.wait(BOUND_S)
        return "late"

    owner.later("slow", "first", slow)
    assert has_begun.wait(BOUND_S)
    owner.later("slow", "second", lambda: "after it")
    owner.later("other", "other", lambda: "beside it")
    owner.look(after_s=1.0)
    assert owner.await_done(1) == ["other: beside it"]
    is_free.set()
    assert owner.await_done(3) == ["other: beside it", "first: late", "second: after it"]


def test_what_is_alone_in_its_lane_is_waited_for_by_nobody(owner: Owner) -> None:
    together = threading.Barrier(10)
    for index in range(10):
        owner.later(f"{ALONE}{index}", "met", lambda: together.wait(BOUND_S) >= 0)
    owner.later("other", "other", lambda: "beside them")
    assert sorted(owner.await_done(11)) == [*["met: True"] * 10, "other: beside them"]


def test_what_waits_for_a_worker_that_has_still_to_begin_is_looked_at_soon(owner: Owner) -> None:
    with owner.lock:  # so none begins
        for lane in "ab":
            owner.workers.later(lane, lambda: None, owner.refused.append, 0.0)
        now = monotonic()
        assert owner.workers.check(now) == now + module.HAND_OVER_S


def test_what_has_not_begun_in_time_never_does(owner: Owner) -> None:
    is_free, has_begun = threading.Event(), threading.Event()
    owner.later("slow", "first", lambda: (has_begun.set(), is_free.wait(BOUND_S)), wait=1.0)
    assert has_begun.wait(BOUND_S)
    owner.later("slow", "second", lambda: "must not be", wait=1.0)
    owner.look(after_s=2.0)
    assert [answer.error for answer in owner.refused] == ["timeout", "timeout"]
    owner.later("slow", "third", lambda: "in time")
    is_free.set()
    owner.await_done(2)
    assert [each.partition(":")[0] for each in owner.done] == ["first", "third"]


def test_there_is_a_bound_on_what_waits(owner: Owner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_WAITING", 2)
    is_free = threading.Event()
    for _ in range(3):
        owner.later("slow", "each", lambda: is_free.wait(BOUND_S))
    assert [answer.error for answer in owner.refused] == ["busy"]
    is_free.set()
    owner.await_done(2)


def test_a_coroutine_that_ends_its_process_ends_nothing(owner: Owner) -> None:
    async def leave() -> object:
        raise SystemExit(1)

    async def cancel() -> object:
        import asyncio

        raise asyncio.CancelledError

    async def fine() -> str:
        return "is awaited"

    for code in (leave, cancel, fine):
        owner.later("", code.__name__, code)
    assert owner.await_done(3) == [
        "leave: SystemExit",
        "cancel: CancelledError",
        "fine: is awaited",
    ]


def test_what_has_ended_in_time_is_not_refused(owner: Owner) -> None:
    with owner.lock:
        owner.workers.refuse_after(1.0, owner.refused.append)()
        owner.workers.refuse_after(1.0, owner.refused.append)
        assert owner.workers.check(monotonic()) is not None
    owner.look(after_s=2.0)
    owner.look(after_s=3.0)
    assert [answer.error for answer in owner.refused] == ["timeout"]


def test_actions_are_bounded(owner: Owner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_MOST_ACTIONS", 1)
    is_free = threading.Event()
    ended: list[object] = []
    owner.workers.start(lambda: is_free.wait(BOUND_S), lambda *outcome: ended.append(outcome))
    with pytest.raises(PropertyError, match="1 calls are running"):
        owner.workers.start(lambda: None, lambda *outcome: None)
    is_free.set()
