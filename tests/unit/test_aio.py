"""The tree of scripts for asyncio: real, cancelable, beside whatever else the loop does."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Iterator
from contextvars import ContextVar
from pathlib import Path
from threading import Event

import pytest
from fake_manager import FakeManager
from fake_tree import tree_of
from worlds import made

import rtkit
from rtkit.aio import AsyncPlan, AsyncStream, AsyncTree, in_thread
from rtkit.api.session import ScriptSession
from rtkit.api.tree import Tree
from rtkit.deployment import actions as act
from rtkit.errors import NotFound
from rtkit.link import stopping
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import TypeProfile
from rtkit.tree.grace import uninterrupted

A = "/localhost/A.rtc"


@pytest.fixture
def world() -> FakeManager:
    return made(FakeManager([ComponentPattern(TypeProfile("Std"))]), "Std?instance_name=A")


@pytest.fixture
def sync(world: FakeManager, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Tree]:
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path))
    with tree_of(Tree, world) as tree:
        yield tree


def test_calls_are_awaited_side_by_side_and_errors_come_through(sync: Tree) -> None:
    async def main() -> None:
        tree = AsyncTree(sync)
        both = await asyncio.gather(tree.ls(), tree.component(A))
        assert (both[0], both[1].instance) == (["A.rtc", "manager.mgr"], "A")
        with pytest.raises(NotFound):
            await tree.component("/localhost/B.rtc")
        plan = await tree.plan(await tree.save(unconnected=True))
        assert isinstance(plan, AsyncPlan)
        assert (bool(plan), len(plan), plan.steps) == (True, 1, ["activate A"])
        await plan.apply()
        assert (await tree.component(A)).state == "Active"
        assert set(dir(sync)) - set(dir(tree)) == {"live"}

    asyncio.run(main())


def test_events_are_listened_to_from_the_beginning_of_the_block(
    sync: Tree, world: FakeManager
) -> None:
    async def main() -> None:
        async with AsyncTree(sync).events() as events:
            world.perform(act.Delete("A"))
            async for event in events:
                assert (event.event, event.path) == ("VANISHED", A)
                break

    asyncio.run(main())


def test_what_waits_is_cancelled_at_once_and_leaves_no_thread(sync: Tree) -> None:
    async def main() -> None:
        tree = AsyncTree(sync)
        before = threading.enumerate()
        began = time.monotonic()
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.05):
                await tree.wait(A, state="error")
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.05):
                await anext(tree.events())
        assert time.monotonic() - began < 5.0, "not the time that there was to wait"
        for thread in set(threading.enumerate()).difference(before):
            thread.join(5.0)
            assert not thread.is_alive()

    asyncio.run(main())


def test_the_loop_goes_on_meanwhile() -> None:
    async def main() -> None:
        release = Event()
        waiting = asyncio.create_task(in_thread(release.wait))
        await asyncio.sleep(0)
        release.set()  # by the loop itself: it would never come to this if it was blocked
        assert await waiting

    asyncio.run(main())


def test_a_call_knows_the_context_of_its_task() -> None:
    mark: ContextVar[str] = ContextVar("mark")

    async def main() -> None:
        mark.set("mine")
        assert await in_thread(mark.get) == "mine"

    asyncio.run(main())


def test_a_plan_under_way_ends_in_order_when_it_is_cancelled() -> None:
    """The step under way is done, the next is not begun, and what ends in order is waited for."""
    done: list[str] = []
    begun, release = Event(), Event()

    def step() -> None:
        begun.set()
        release.wait()
        done.append("step")

    def plan() -> None:
        try:
            uninterrupted(step)
            uninterrupted(lambda: done.append("next"))
        except KeyboardInterrupt:
            uninterrupted(lambda: done.append("back"))
            raise KeyboardInterrupt("1 step left") from None

    async def main() -> None:
        task = asyncio.create_task(in_thread(plan, is_orderly=True))
        await in_thread(begun.wait)
        task.cancel()
        await asyncio.sleep(0)
        release.set()
        with pytest.raises(asyncio.CancelledError) as cancelled:
            await task
        assert cancelled.value.__notes__ == ["1 step left"]

    asyncio.run(main())
    assert done == ["step", "back"]


def test_what_cannot_be_stopped_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rtkit.aio._GRACE_S", 0.01)
    release = Event()

    async def main() -> None:
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.01):
                await in_thread(release.wait)

    asyncio.run(main())
    release.set()


def test_a_stop_wakes_each_way_of_waiting_once(sync: Tree) -> None:
    request = stopping.StopRequest()
    woken: list[str] = []

    def wait() -> None:
        stopping.heed(request)
        with stopping.waking(lambda: woken.append("woken")), ScriptSession(sync, print) as session:
            request.ring()
            with pytest.raises(stopping.Stopped):
                session.wait_for([], None)
            session.wait_for([], time.monotonic())
            stopping.check()

    async def main() -> None:
        await in_thread(wait)

    asyncio.run(main())
    assert woken == ["woken"]


def test_a_stream_that_is_left_is_closed() -> None:
    ended = Event()

    def values() -> Iterator[int]:
        try:
            yield from range(10)
        finally:
            ended.set()

    async def main() -> None:
        stream = AsyncStream(values)  # type: ignore[arg-type]
        async for value in stream:
            assert value == 0
            break
        await stream.aclose()
        assert ended.is_set()

    asyncio.run(main())


def test_it_is_reached_from_the_package() -> None:
    assert rtkit.aio.AsyncTree is AsyncTree
    assert "aio" in dir(rtkit)
