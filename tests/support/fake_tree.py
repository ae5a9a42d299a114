"""Fake tree: shows commands a fake manager as a `Tree`, without a process."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from threading import RLock

from fake_manager import FakeManager

from rtkit.deployment.batch import batch_from_text, results_to_text
from rtkit.deployment.delta import TREE, FullSnapshot, delta_between, snapshot_to_text
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.listing import listing_of, listing_to_text
from rtkit.deployment.part import part_of
from rtkit.errors import NotFound, RtkitError
from rtkit.fast_dataclass import replace
from rtkit.link import keys
from rtkit.link.inproc import InprocLink
from rtkit.property.exchange import Reply, Request, failure
from rtkit.rtc.serde import encode
from rtkit.tree.client import Tree

_RUN = "fake"


def fake_tree(world: FakeManager, timeout_s: float = 1.0) -> Tree:
    """Return the real client of a fake manager that keeps its facts in `world`."""
    link = InprocLink()
    service = keys.service(world.host, world.manager)
    tell = link.announce(keys.line_key(service, TREE), lambda _is_heard: None)
    link.serve(service, _Server(world, tell).serve)
    return Tree(link, world.host, world.manager, timeout_s)


class _Server:
    """Answers as a manager would, and notifies subscribers when the world changes."""

    def __init__(self, world: FakeManager, tell: Callable[[str], object]) -> None:
        self._world = world
        self._tell = tell
        self._told = self._facts()
        self._number = 0
        self._lock = RLock()
        world.changed = self._publish

    def serve(self, request: Request) -> None:
        try:
            with self._lock:
                if request.is_extension and request.name == "picture":
                    reply = Reply(self._snapshot_text())
                else:
                    reply = Reply(_answer(self._world, request))
        except RtkitError as error:
            reply = failure(error)
        request.answer(reply)

    def _facts(self) -> Snapshot:
        """Return what subscribers receive; the manager is this process."""
        return replace(self._world.snapshot(), pid=os.getpid(), modules=(), properties={})

    def _publish(self) -> None:
        with self._lock:
            self._number += 1
            now = self._facts()
            delta = delta_between(self._told, now, _RUN, self._number)
            self._told = now
            self._tell(json.dumps(encode(delta)))

    def _snapshot_text(self) -> str:
        self._publish()
        return snapshot_to_text(FullSnapshot(_RUN, self._number, self._told))


def _answer(world: FakeManager, request: Request) -> str:
    if request.is_extension and request.name == "listing":
        return listing_to_text(listing_of(world.snapshot()))
    if request.is_extension and request.name == "snapshot":
        return json.dumps(encode(world.snapshot()))
    if request.is_extension and request.name == "lease":
        return world.lease.asked(request.payload)
    kind, _, which = request.name.partition("/")
    if request.is_extension and kind == "part":
        instances = keys.unescape(which).split(",")
        return json.dumps(encode(part_of(world.snapshot(), instances)))
    if request.is_extension and request.name == "lacking" and request.payload is not None:
        asked = json.loads(request.payload)
        return json.dumps([world.lacking.get(create.partition("?")[0], "") for _, create in asked])
    if request.name == "batch" and request.payload is not None:
        batch = batch_from_text(request.payload)
        return results_to_text(world.batch(batch.actions, batch.is_ordered))
    if request.name == "get_loadable_modules":
        return world.properties.get(request.name, "")
    if request.payload is not None:
        world.properties[request.name] = request.payload
    if request.name not in world.properties:
        raise NotFound(f"No such property: {request.name}")
    return world.properties[request.name]
