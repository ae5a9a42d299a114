"""Answers about single ports: what a value of theirs is made of, whether one fits, recordings."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rtkit.api.live_records import Record
from rtkit.component.values.type_layout import (
    BasicLayout,
    EnumLayout,
    Layout,
    StructLayout,
    layout_of,
    zero,
)
from rtkit.component.values.value_text import plain
from rtkit.errors import Malformed, NotFound, Refused, RtkitError
from rtkit.probe.known_types import data_type, definitions
from rtkit.probe.templates import Template
from rtkit.rtc.data_types import scoped_name
from rtkit.rtc.enums import PortType
from rtkit.web.audit.audit_log import Author
from rtkit.web.folders import granted
from rtkit.web.replies import body_of
from rtkit.web.site import WebSite

if TYPE_CHECKING:
    from rtkit.rtc.profiles import PortProfile

RECORD = "record"
"""The kind of jobs that record."""
_ENDINGS = (".mcap", ".txt")
_STAMP = "tm"
_MOST_FIELDS = 64
_MOST_RECORDED = 200


def routes(site: WebSite) -> list[Route]:
    """Return the requests about ports."""

    async def port(request: Request) -> Response:
        path = request.query_params.get("port", "")
        return JSONResponse(await asyncio.to_thread(_described, site, path))

    async def check(request: Request) -> Response:
        body = await body_of(request)
        path, value = body.get("port"), body.get("value")
        if not isinstance(path, str) or not isinstance(value, str):
            raise Malformed("port and value: texts are wanted")
        why = await asyncio.to_thread(_misfit, site, path, value)
        return JSONResponse({"why": why})

    async def record(request: Request) -> Response:
        site.check_change()
        body = await body_of(request)
        file, ports = body.get("file"), body.get("ports")
        if not isinstance(file, str) or not isinstance(ports, list) or not ports:
            raise Malformed("file and ports: a text and a list with one port or more are wanted")
        if not all(isinstance(each, str) for each in ports) or len(ports) > _MOST_RECORDED:
            raise Malformed(f"ports: {_MOST_RECORDED} paths of ports at most")
        for each in ports:
            if _profile(site, each)[0].port_type is not PortType.OUT:
                raise Refused(f"{each} is no out port")
        path = granted(file, site.folders, is_new=True, endings=_ENDINGS)
        if body.get("replace") is not True and await asyncio.to_thread(os.path.exists, path):
            raise Refused(f"{path} is there already")
        text = f"Record {', '.join(ports)} in {path}"
        job = await site.jobs.start(RECORD, text, ("rtlog", f"--filename={path}", "--", *ports))
        site.audit.add(Author(request), f"Begin: {job.text}", job.typed)
        return JSONResponse(job.record())

    return [
        Route("/api/port", port),
        Route("/api/port/check", check, methods=["POST"]),
        Route("/api/record", record, methods=["POST"]),
    ]


def _profile(site: WebSite, path: str) -> tuple[PortProfile, str]:
    """Return a port, and the definition of its type as far as a port has it.

    Raises:
        NotFound: It is not there.
    """
    component, _, name = path.rpartition(":")
    for manager in site.managers:
        for facts in manager.facts.components:
            if manager.path(facts, site.host) == component:
                port = facts.port(name)
                if port is not None:
                    known = definitions(manager.facts).get(scoped_name(port.data_type), "")
                    return port, port.definition or known
    raise NotFound(f"No such port: {path}")


def _type(site: WebSite, path: str) -> type:
    port, definition = _profile(site, path)
    return data_type(port.data_type, path, definition)


def _described(site: WebSite, path: str) -> Record:
    """Return the type of a port, and the fields of its values; or why these are not known."""
    name = scoped_name(_profile(site, path)[0].data_type)
    try:
        cls = _type(site, path)
    except NotFound as error:
        return {"type": name, "fields": [], "why": str(error)}
    if cls is bytes:
        return {"type": name, "fields": [], "why": f"{path} takes values of any type"}
    fields = []
    for each in _fields(layout_of(cls), zero(layout_of(cls)), ""):
        fields.append(each)
        if len(fields) > _MOST_FIELDS:
            return {"type": name, "fields": [], "why": f"{name} has too many fields for a form"}
    return {"type": name, "fields": fields, "why": ""}


def _fields(layout: Layout, value: object, name: str) -> Iterator[Record]:
    """Yield the fields that a form has, with their zero values; stamps are left to the writer."""
    if isinstance(layout, StructLayout):
        for field, inner in layout.fields:
            if field != _STAMP:
                below = f"{name}.{field}" if name else field
                yield from _fields(inner, getattr(value, field), below)
        return
    choices = [each.name for each in layout.cls] if isinstance(layout, EnumLayout) else []
    is_basic = isinstance(layout, BasicLayout)
    kind = "choice" if choices else _KINDS.get(layout.cls, "json") if is_basic else "json"  # type: ignore[union-attr]
    yield {
        "name": name, "kind": kind, "type": layout.name, "value": plain(value), "choices": choices,
    }  # fmt: skip


_KINDS = {bool: "truth", int: "number", float: "number", str: "text"}


def _misfit(site: WebSite, path: str, value: str) -> str:
    """Return why a value does not fit a port, empty if it does."""
    try:
        Template(value, {"": _type(site, path)})
    except RtkitError as error:
        return str(error)
    return ""
