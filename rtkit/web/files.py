"""Answers about system profiles in the folders that were granted."""

from __future__ import annotations

import asyncio
import shlex

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rtkit.web.folders import granted, profiles_in
from rtkit.web.running import records_from
from rtkit.web.site import WebSite


def routes(site: WebSite) -> list[Route]:
    """Return the requests about files."""

    async def files(_request: Request) -> Response:
        found = await asyncio.to_thread(profiles_in, site.folders)
        return JSONResponse({"folders": list(site.folders), "files": found})

    async def compare(request: Request) -> Response:
        file = granted(request.query_params.get("file", ""), site.folders)
        state = request.query_params.get("state", "active")
        line = ("rtcheck", "--json", "--state", state, "--", file)
        deviations = await records_from(line, good=(0, 1))
        return JSONResponse({"command": shlex.join(line), "deviations": deviations})

    return [Route("/api/files", files), Route("/api/compare", compare)]
