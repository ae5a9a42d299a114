"""Fake tree: shows commands a fake manager as a `Tree`, without a process."""

from __future__ import annotations

import json
import math
from functools import partial
from threading import RLock
from typing import TypeVar

from fake_link import InprocLink
from fake_manager import FakeManager

from rtkit.deployment.batch import results_to_text
from rtkit.deployment.delta import TREE
from rtkit.deployment.metrics import METRICS
from rtkit.errors import RtkitError, Unreachable
from rtkit.link import zenoh_keys
from rtkit.manager.core import events as ev
from rtkit.manager.query_server import ManagerQueryServer
from rtkit.property.exchange import Reply, Request, failure
from rtkit.tree.client import Tree

T = TypeVar("T", bound=Tree)


def fake_tree(world: FakeManager, timeout_s: float = 1.0) -> Tree:
    """Return the real client of a fake manager, over its real query server."""
    return tree_of(Tree, world, timeout_s)


def tree_of(kind: type[T], world: FakeManager, timeout_s: float = 1.0) -> T:
    """Return the real client of a fake manager, over its real query server."""
    link = InprocLink()
    service = zenoh_keys.service(world.host, world.manager)
    link.serve(service, _Server(world, link, service).serve)
    return kind(link, world.host, world.manager, timeout_s)


class _Server:
    """Turns requests into events, and carries publications to subscribers."""

    def __init__(self, world: FakeManager, link: InprocLink, service: str) -> None:
        self._world = world
        self._lock = RLock()
        tell = {
            line: link.announce(zenoh_keys.line_key(service, line), partial(self._listened, line))
            for line in (TREE, METRICS)
        }
        before = world.publish

        def publish(told: ev.Publish) -> None:
            before(told)
            tell[told.line](json.dumps({**told.message, "time": 0.0}))

        world.publish = publish

    def _listened(self, line: str, is_heard: bool) -> None:
        with self._lock:
            self._world.shell.feed(ev.ListenersChanged(line, is_heard, f"tree {id(self)}"))

    def serve(self, request: Request) -> None:
        try:
            with self._lock:
                self._serve(request)
        except RtkitError as error:
            request.answer(failure(error))

    def _serve(self, request: Request) -> None:
        world = self._world
        if world.gone:
            raise Unreachable(world.gone)
        if request.is_extension and request.name == "lacking" and request.payload is not None:
            asked = json.loads(request.payload)
            lacking = [world.lacking.get(create.partition("?")[0], "") for _, create in asked]
            request.answer(Reply(json.dumps(lacking)))
        elif request.name == "get_loadable_modules":
            request.answer(Reply(world.loadable))
        else:
            queries = ManagerQueryServer(world.shell.state, world.shell.requests)
            queries.plan_lock = world.plan_lock
            event = queries.take(request._replace(until=math.inf))  # by a clock of its own
            if isinstance(event, ev.BatchRequested):
                results = world.batch(event.batch.actions, event.batch.is_ordered)
                world.shell.requests.answer(event.request, Reply(results_to_text(results)))
            elif event is not None:
                world.shell.feed(event)
                world.settle()
