"""Tells pages what ports carry: those that a page shows, ten times a second at most.

One connection to each manager is asked, as long as some page shows a port of it. Nothing is
connected to the ports, so nothing of it is seen in the tree.
"""

from __future__ import annotations

import asyncio
from collections.abc import Collection, Mapping
from time import monotonic, time
from typing import TYPE_CHECKING

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rtkit.api.live_records import KnownManager, Record
from rtkit.deployment.port_samples import MOST_PORTS
from rtkit.errors import Malformed, RtkitError
from rtkit.rtc.manager_address import is_address
from rtkit.rtc.names import LOCAL
from rtkit.tree.connect import connect
from rtkit.web.replies import body_of
from rtkit.web.site import WebSite

if TYPE_CHECKING:
    from rtkit.deployment.port_samples import PortName
    from rtkit.tree.client import Tree

_PERIOD_S = 0.1
_TIMEOUT_S = 2.0
_AGAIN_S = 2.0
"""After how long a manager is asked again that did not answer [s]."""

Paths = Mapping[str, Mapping["PortName", str]]
"""Paths of ports by manager, and by instance and port."""


def routes(site: WebSite) -> list[Route]:
    """Return the requests about values."""
    follower = PortFollower(site)
    site.closers.append(follower.close)

    async def watch(request: Request) -> Response:
        body = await body_of(request)
        page, ports = body.get("page"), body.get("ports")
        if not isinstance(page, str) or not isinstance(ports, list):
            raise Malformed("page and ports: a text and a list are wanted")
        if not all(isinstance(each, str) for each in ports) or len(ports) > MOST_PORTS:
            raise Malformed(f"ports: {MOST_PORTS} paths of ports at most")
        site.pages.watch(page, frozenset(ports))
        return JSONResponse({"values": follower.follow(ports)})

    return [Route("/api/watch", watch, methods=["POST"])]


class PortFollower:
    """Asks managers for samples, and passes on what is new."""

    def __init__(self, site: WebSite) -> None:
        """Ask for nothing yet."""
        self._site = site
        self._samples: dict[str, Record] = {}
        self._trees: dict[str, Tree] = {}
        self._asking: dict[str, asyncio.Task[None]] = {}
        self._again_at: dict[str, float] = {}
        self._is_at_work = self._is_closed = False
        self._task: asyncio.Task[None] | None = None

    def follow(self, ports: Collection[str]) -> Record:
        """Go on, or begin; return what is known of some ports already."""
        if ports and (self._task is None or self._task.done()):
            self._task = asyncio.create_task(self._run())
        return {path: self._samples[path] for path in ports if path in self._samples}

    async def close(self) -> None:
        """Ask for nothing any more, and return when all connections are closed."""
        self._is_closed = True
        if self._task is not None:
            await self._task

    async def _run(self) -> None:
        self._is_at_work = True
        try:
            while not self._is_closed and (wanted := self._site.pages.watched()):
                for manager, paths in self._by_manager(wanted).items():
                    is_due = monotonic() >= self._again_at.get(manager, 0.0)
                    if manager not in self._asking and is_due:
                        self._asking[manager] = asyncio.create_task(self._ask(manager, paths))
                await asyncio.sleep(_PERIOD_S)
        finally:
            self._is_at_work = False
            await asyncio.gather(*self._asking.values(), return_exceptions=True)
            while self._trees:
                self._trees.popitem()[1].close()
            self._samples.clear()

    def _by_manager(self, wanted: Collection[str]) -> Paths:
        found: dict[str, dict[PortName, str]] = {}
        for path in wanted:
            component, _, port = path.rpartition(":")
            record = self._site.records.components.get(component)
            if record is not None:
                found.setdefault(record["manager"], {})[record["name"], port] = path
        return found

    async def _ask(self, manager: str, paths: Mapping[PortName, str]) -> None:
        try:
            await self._take(manager, paths)
        except RtkitError:  # the feed tells that the manager is away
            self._again_at[manager] = monotonic() + _AGAIN_S
            tree = self._trees.pop(manager, None)
            if tree is not None:
                await asyncio.to_thread(tree.close)
        finally:
            del self._asking[manager]

    def _connect(self, manager: str, address: str) -> None:
        """Connect to a manager, on a thread: the last page may leave meanwhile."""
        tree = connect(address, _TIMEOUT_S)
        if self._is_at_work:
            self._trees[manager] = tree
        else:
            tree.close()

    async def _take(self, manager: str, paths: Mapping[PortName, str]) -> None:
        if manager not in self._trees:
            known = next((each for each in self._site.managers if each.id == manager), None)
            if known is None:
                return
            await asyncio.to_thread(self._connect, manager, address_of(known))
        tree = self._trees.get(manager)
        if tree is None:
            return
        samples = await asyncio.to_thread(tree.port_samples, [*paths])
        now, news = time(), {}
        for name, sample in samples.items():
            path, age = paths.get(name, ""), sample.pop("age", None)
            before = self._samples.get(path, {})
            if path and any(before.get(key) != value for key, value in sample.items()):
                at = before.get("at") if age is None else now - age
                news[path] = self._samples[path] = {**sample, "at": at}
        if news:
            self._site.pages.send_values(news)


def address_of(manager: KnownManager) -> str:
    """Return what `connect` takes for a manager."""
    if is_address(manager.place):
        return manager.place
    name = manager.facts.manager
    return name if manager.place == LOCAL else f"{manager.place}/{name}"
