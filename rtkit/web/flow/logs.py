"""Answers requests to follow logs: as a job, whose rows are records of `rtvlog --json`."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rtkit.api.logs import LEVELS
from rtkit.errors import Malformed
from rtkit.web.replies import body_of
from rtkit.web.site import WebSite

LOG = "log"
"""The kind of jobs that follow logs."""
_MOST_BEFORE = 5000


def routes(site: WebSite) -> list[Route]:
    """Return the requests about logs."""

    async def follow(request: Request) -> Response:
        body = await body_of(request)
        path, level, before = body.get("path", "/"), body.get("level", ""), body.get("before", 200)
        if not isinstance(path, str) or not path or "\0" in path:
            raise Malformed(f"path: a path is wanted, not {path!r}")
        if level not in LEVELS:
            raise Malformed(f"level: {', '.join(LEVELS)}, not {level!r}")
        if isinstance(before, bool) or not isinstance(before, int):
            raise Malformed(f"before: a number is wanted, not {before!r}")
        number = min(max(before, 0), _MOST_BEFORE)
        line = ("rtvlog", "--json", f"--level={level}", f"--number={number}", "--", path)
        job = await site.jobs.start(LOG, f"Follow the log of {path}", line)
        return JSONResponse(job.record())

    return [Route("/api/logs", follow, methods=["POST"])]
