"""The rooms of the server: each answers the requests of one part of the page."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from starlette.routing import Route

from rtkit.web import files
from rtkit.web.audit import room as audit
from rtkit.web.builder import room as builder
from rtkit.web.documents import room as documents
from rtkit.web.flow import logs, past, ports, values
from rtkit.web.jobs import room as jobs
from rtkit.web.live import room as live
from rtkit.web.machines import room as machines
from rtkit.web.plans import comparing, ordering
from rtkit.web.plans import room as plans
from rtkit.web.properties import room as properties
from rtkit.web.site import WebSite

ROOMS: Sequence[Callable[[WebSite], list[Route]]] = (
    live.routes,
    files.routes,
    jobs.routes,
    audit.routes,
    values.routes,
    ports.routes,
    builder.routes,
    machines.routes,
    properties.routes,
    documents.routes,
    plans.routes,
    comparing.routes,
    ordering.routes,
    past.routes,
    logs.routes,
)
"""Each returns the routes of its room."""
