"""The manager as a site of its own plans: asked over its desk, kept to itself by its lock."""

from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from threading import Thread

import pytest
from fake_manager import Immortal
from fake_shell import FakeShell

from rtkit.deployment.actions import Delete
from rtkit.deployment.batch import results_to_text
from rtkit.deployment.plan_lock import PlanLock
from rtkit.errors import Refused
from rtkit.manager.core.events import BatchRequested
from rtkit.manager.core.requests import PendingRequests
from rtkit.manager.following.worker import Ended, OwnSite
from rtkit.manager.query_server import ManagerQueryServer
from rtkit.property.exchange import Reply, Request

WAIT_S = 10.0


class Manager:
    """A desk that is served at once; batches are answered by the test."""

    def __init__(self) -> None:
        self.requests = PendingRequests()
        self.query_server = ManagerQueryServer(FakeShell().state, self.requests)
        self.query_server.plan_lock = PlanLock(lambda _pid: Immortal())
        self.batches: Queue[BatchRequested] = Queue()
        self.site = self.another("the manager itself, which follows S")

    def another(self, purpose: str) -> OwnSite:
        return OwnSite(self._post, "manager", purpose)

    def _post(self, request: Request) -> None:
        try:
            event = self.query_server.take(request)
        except Refused as error:
            request.answer(Reply(str(error), error.kind))
            return
        if isinstance(event, BatchRequested):
            self.batches.put(event)


def aside(work: Callable[[], object]) -> tuple[Thread, Queue[object]]:
    """Run something on a thread; return that, and what comes of it."""
    found: Queue[object] = Queue()

    def run() -> None:
        try:
            found.put(work())
        except Ended as error:
            found.put(error)

    thread = Thread(target=run, daemon=True)
    thread.start()
    return thread, found


def test_it_is_looked_at_and_acted_on_like_any_manager() -> None:
    manager = Manager()
    assert manager.site.snapshot().manager == "manager"
    _, found = aside(lambda: manager.site.apply([Delete("A")]))
    asked = manager.batches.get(timeout=WAIT_S)
    assert asked.batch.actions == (Delete("A"),)
    manager.requests.answer(asked.request, Reply(results_to_text([])))
    assert found.get(timeout=WAIT_S) == ()
    with pytest.raises(Refused, match="starts no other"):
        manager.site.start_manager("m1")
    assert manager.site.end_started() == []


def test_one_at_a_time_carries_plans_out_and_others_are_told_who() -> None:
    manager = Manager()
    manager.site.take_lock(lambda _: None)
    waits: Queue[str] = Queue()
    other = manager.another("rtapply")
    thread, _ = aside(lambda: other.take_lock(waits.put))
    told = waits.get(timeout=WAIT_S)
    assert told.startswith("the manager itself, which follows S (")
    manager.site.give_lock()
    thread.join(WAIT_S)
    assert not thread.is_alive()
    assert str(manager.query_server.plan_lock.holder).startswith("rtapply (")
    assert waits.empty()


def test_whatever_it_waits_for_it_ends_when_told_to() -> None:
    manager = Manager()
    other = manager.another("rtapply")
    other.take_lock(lambda _: None)
    waits: Queue[str] = Queue()
    _, found = aside(lambda: manager.site.take_lock(waits.put))
    waits.get(timeout=WAIT_S)
    manager.site.end()
    assert isinstance(found.get(timeout=WAIT_S), Ended)
    manager = Manager()
    _, found = aside(lambda: manager.site.apply([Delete("A")]))
    manager.batches.get(timeout=WAIT_S)
    manager.site.end()
    assert isinstance(found.get(timeout=WAIT_S), Ended)
    with pytest.raises(Ended):
        manager.site.snapshot()
    manager.site.give_lock()
    assert manager.query_server.plan_lock.holder is None
