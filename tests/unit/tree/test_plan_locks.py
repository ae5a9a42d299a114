"""PlanLocks of several managers: all or none, waited for, given back."""

import os
import threading
import time

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.deployment.plan_lock import LockHolder, PlanLock, holder_from_text
from rtkit.errors import NotFound, Refused
from rtkit.link.processes import ProcessWatch
from rtkit.rtc.serde import encode
from rtkit.tree import plan_locks
from rtkit.tree.plan_locks import PlanLocks


@pytest.fixture
def trees():
    return [fake_tree(FakeManager(manager=name)) for name in ("a", "b")]


def command_at(tree):
    holder = holder_from_text(tree.plan_lock())
    return holder.command if holder is not None else ""


def test_all_are_taken_or_none(trees):
    a, b = trees
    told = []
    with (
        PlanLocks("rtapply x", 0, told.append) as mine,
        PlanLocks("rtstate y", 0, told.append) as other,
    ):
        other.take(b)
        with pytest.raises(Refused, match=r"manager 'b' is in use by rtstate y \(.*--wait SECO"):
            mine.take(a, b)
        assert [command_at(tree) for tree in trees] == ["", "rtstate y"]
        other.close()
        mine.take(a, b)
        assert [command_at(tree) for tree in trees] == ["rtapply x", "rtapply x"]
    assert [command_at(tree) for tree in trees] == ["", ""]
    assert told == []


def test_it_is_waited_for(trees):
    told = []
    other = PlanLocks("rtstate y", 0, told.append)
    other.take(trees[1])
    let_go = threading.Event()

    def tell(text):
        told.append(text)
        let_go.set()

    def end():
        let_go.wait(10)
        other.close()

    thread = threading.Thread(target=end)
    thread.start()
    with PlanLocks("rtapply x", 10, tell) as mine:
        mine.take(*trees)
        assert command_at(trees[1]) == "rtapply x"
    thread.join()
    (waiting,) = told
    assert waiting.startswith("waits: manager 'b' is in use by rtstate y (")


def test_the_end_of_the_process_that_has_it_is_awaited(monkeypatch):
    """And not found out by asking again after some time."""
    world = FakeManager(manager="a")
    world.plan_lock = PlanLock(ProcessWatch)
    tree = fake_tree(world)
    monkeypatch.setattr(plan_locks, "_ASK_AGAIN_S", 60.0)
    read, write = os.pipe()
    pid = os.fork()
    if not pid:
        os.close(write)
        os.read(read, 1)
        os._exit(0)
    os.close(read)
    holder = LockHolder("id", "rtapply far.xml", "somebody", os.uname().nodename, pid)
    tree.plan_lock({"take": encode(holder)})
    began = time.monotonic()
    with PlanLocks("rtapply x", 50, lambda _: os.close(write)) as mine:
        mine.take(tree)
        assert command_at(tree) == "rtapply x"
    assert time.monotonic() - began < 30
    os.waitpid(pid, 0)


def test_a_manager_that_has_none_is_gone_without(trees):
    def asked(_request=None):
        raise NotFound("no such view: lock")

    trees[0].plan_lock = asked
    told = []
    with PlanLocks("rtapply x", 0, told.append) as mine:
        mine.take(*trees)
        assert command_at(trees[1]) == "rtapply x"
    assert told == ["manager 'a' keeps no others off meanwhile: no such view: lock"]


def test_a_process_is_watched_to_its_end():
    read, write = os.pipe()
    pid = os.fork()
    if not pid:
        os.close(write)
        os.read(read, 1)
        os._exit(0)
    os.close(read)
    life = ProcessWatch(pid)
    assert not life.is_over
    os.close(write)
    os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)
    assert life.is_over
    os.waitpid(pid, 0)
    life.close()
    with pytest.raises(ProcessLookupError):
        ProcessWatch(pid)
