"""Answers the request for the past, of which the page shows any moment."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from rtkit.web.site import WebSite


def routes(site: WebSite) -> list[Route]:
    """Return the requests about the past."""

    async def past(_request: Request) -> Response:
        body = b"".join(site.past.pieces(site.picture()))
        return Response(body, media_type="application/json")

    return [Route("/api/past", past)]
