"""The rooms of the server: each answers the requests of one part of the page."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from starlette.routing import Route

from rtkit.web import (
    building,
    comparing,
    documents,
    files,
    job_room,
    logs,
    machines,
    ordering,
    past,
    planning,
    ports,
    property_pages,
    system,
    values,
)
from rtkit.web.site import WebSite

ROOMS: Sequence[Callable[[WebSite], list[Route]]] = (
    system.routes,
    files.routes,
    job_room.routes,
    values.routes,
    ports.routes,
    building.routes,
    machines.routes,
    property_pages.routes,
    documents.routes,
    planning.routes,
    comparing.routes,
    ordering.routes,
    past.routes,
    logs.routes,
)
"""Each returns the routes of its room."""
