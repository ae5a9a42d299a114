"""Answers the request for the past, of which the page shows any moment.

It reaches back to what the managers still hold of what was before the server began.
"""

from __future__ import annotations

import asyncio
import json
import sys
from asyncio.subprocess import DEVNULL, PIPE
from collections.abc import Mapping, Sequence

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from rtkit.api.live_records import Record, SystemRecords, change_between
from rtkit.web.flow.values import address_of
from rtkit.web.site import WebSite

PAST = "past"
"""The event that tells since when the past is known, once it reaches back further."""
_MAIN = "import sys; from rtkit.web.flow.system_past import main; sys.exit(main())"


def routes(site: WebSite) -> list[Route]:
    """Return the requests about the past."""
    earlier = _EarlierPast(site)
    site.when_begun.append(earlier.begin)
    site.closers.append(earlier.close)

    async def past(_request: Request) -> Response:
        body = b"".join(site.past.pieces(site.picture()))
        return Response(body, media_type="application/json")

    return [Route("/api/past", past)]


class _EarlierPast:
    """Asks managers for what was before the first look; without an answer the past begins there."""

    def __init__(self, site: WebSite) -> None:
        self._site = site
        self._task: asyncio.Task[None] | None = None

    def begin(self) -> None:
        """Ask, in a process of its own: events of hours are to be replayed."""
        if self._site.managers:
            self._task = asyncio.create_task(self._ask())

    async def close(self) -> None:
        """Ask no longer."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)

    async def _ask(self) -> None:
        site = self._site
        managers = [(address_of(each), each[:3]) for each in site.managers if not each.why]
        asked = {"managers": managers, "host": site.host, "until": site.past.since}
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-P", "-c", _MAIN, stdin=PIPE, stdout=PIPE, stderr=DEVNULL
        )
        try:
            out, _ = await process.communicate(json.dumps(asked).encode())
        finally:
            if process.returncode is None:
                process.kill()
                await process.wait()
        if process.returncode == 0:
            self._take(json.loads(out))

    def _take(self, found: Record) -> None:
        site, first_look = self._site, self._site.past.since
        last = change_between(_records(found["after"]), site.past.before)
        fresh = {name: list(each.values()) for name, each in last.fresh._asdict().items()}
        joint = {"time": first_look, **fresh, "gone": last.gone, "events": []}
        changes = [*found["changes"], *([joint] if last else ())]
        if site.past.reach_back(found["since"], _records(found["before"]), changes):
            site.add_earlier([event for change in changes for event in change["events"]])
            site.pages.send(PAST, {"since": site.past.since})


def _records(lists: Mapping[str, Sequence[Record]]) -> SystemRecords:
    return SystemRecords(*({each["id"]: each for each in lists[k]} for k in SystemRecords._fields))
