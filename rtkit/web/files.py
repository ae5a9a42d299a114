"""Answers about system profiles in the folders that were granted."""

from __future__ import annotations

import asyncio

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rtkit.profile.forms import may_be_system
from rtkit.web.folders import profiles_of
from rtkit.web.site import WebSite


def routes(site: WebSite) -> list[Route]:
    """Return the requests about files."""

    async def files(_request: Request) -> Response:
        found = await asyncio.to_thread(profiles_of, site.folders, may_be_system)
        return JSONResponse({"folders": list(site.folders), "files": found})

    return [Route("/api/files", files)]
