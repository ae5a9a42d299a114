"""Answers the request for what pages and scripts have changed."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rtkit.web.site import WebSite


def routes(site: WebSite) -> list[Route]:
    """Return the request about changes."""

    async def changes(_request: Request) -> Response:
        return JSONResponse({"changes": site.audit.records()})

    return [Route("/api/changes", changes)]
