"""Answers about jobs: their rows, and their end."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rtkit.web.site import WebSite


def routes(site: WebSite) -> list[Route]:
    """Return the requests about jobs."""

    async def rows(request: Request) -> Response:
        job = site.jobs.found(request.path_params["id"])
        first = job.count - len(job.rows)
        return JSONResponse({**job.record(), "first": first, "rows": list(job.rows)})

    async def stop(request: Request) -> Response:
        job = site.jobs.found(request.path_params["id"])
        site.jobs.stop(job.id)
        return JSONResponse(job.record())

    return [
        Route("/api/jobs/{id}", rows),
        Route("/api/jobs/{id}/stop", stop, methods=["POST"]),
    ]
