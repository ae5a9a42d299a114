"""Answers about live properties: which there are, property pages and their values, SETs."""

from __future__ import annotations

import asyncio
import shlex
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from rtkit.api.asked import Ask
from rtkit.api.live_records import Record
from rtkit.errors import Malformed, NotFound, RtkitError
from rtkit.panel.description import Panel, read_panel
from rtkit.web.audit.audit_log import Author
from rtkit.web.fields import Fields, text_in
from rtkit.web.pages import NOTICE, PageStream
from rtkit.web.properties.description import PropertyDescriptions
from rtkit.web.properties.foreign_components import ForeignComponents
from rtkit.web.properties.property_services import PropertyServices
from rtkit.web.properties.property_steps import Before, before_of, inverse
from rtkit.web.properties.property_watches import PropertyWatch
from rtkit.web.properties.rest_values import ResettingValues, Rest
from rtkit.web.replies import body_of
from rtkit.web.site import WebSite
from rtkit.wires.http.pages import COMPONENT_HEADERS

_BOUND_S = 5.0
_LONGEST_REST_S = 2.0
_SHORTEST_REST_S = 0.1
_AT_ONCE = 16


def routes(site: WebSite) -> list[Route]:
    """Return the requests about live properties."""
    room = _PropertyRoom(site)
    return [
        Route("/api/properties/services", room.services),
        Route("/api/properties/names", room.names),
        Route("/api/properties/value", room.value),
        Route("/api/properties/set", room.set, methods=["POST"]),
        Route("/api/properties/watch", room.watch, methods=["POST"]),
        Route("/api/properties/component", room.component, methods=["POST"]),
        Route("/component/{id}", room.shown_component),
    ]


class _PropertyRoom:
    def __init__(self, site: WebSite) -> None:
        self._site = site
        self._client = site.client
        self._threads = ThreadPoolExecutor(_AT_ONCE, "properties")
        self._services = PropertyServices(self._client)
        self._descriptions = PropertyDescriptions(self._client, self._services)
        self._watches: dict[PageStream, PropertyWatch] = {}
        self._components = ForeignComponents()
        self._held = ResettingValues(self._set, self._notice)
        site.pages.when_ended(self._page_ended)
        site.closers.append(self._close)

    async def services(self, _request: Request) -> Response:
        found = await self._run(self._services.all)
        return JSONResponse({"services": [each._asdict() for each in found]})

    async def names(self, request: Request) -> Response:
        of = _target(request.query_params, "of")
        names = partial(self._services.names, of)
        found = await self._run(partial(names, all=1)) or await self._run(names)
        return JSONResponse({"names": found})

    async def value(self, request: Request) -> Response:
        ask = Ask(_target(request.query_params))
        payload = await self._run(partial(self._client.payload, ask, _BOUND_S))
        if isinstance(payload, bytes):
            return Response(payload, media_type="application/octet-stream")
        return PlainTextResponse(payload.encode("utf-8", "replace"))

    async def set(self, request: Request) -> Response:
        body = await body_of(request)
        target, text = _target(body), text_in(body, "value")
        self._site.check_change()
        rest = _rest(body)
        page = None
        if rest is not None or "page" in body:
            page = self._site.pages.found(text_in(body, "page"))
        author, audit, line = Author(request), self._site.audit, set_line(target, text)
        moving = audit.moving(author, target)
        if rest is not None:
            before = Before(None, "it was held, and has returned")
        elif moving is not None:
            before = Before(moving.old, moving.why)
        else:
            before = await self._run(partial(before_of, target, self._value_of))
        is_echoed = before.text is not None
        try:
            echo = await self._held.set(page, target, text, rest, is_echoed=is_echoed)
        except RtkitError as error:
            failed = str(error)
            audit.move(author, target, line, text, old=before.text, why=before.why, error=failed)
            raise
        new = echo if is_echoed and isinstance(echo, str) else text
        number = audit.move(author, target, line, new, old=before.text, why=before.why)
        undo = None if before.text is None else [inverse(target, before.text, new)]
        about = {"undo": undo, "undo_reason": before.why, "change": number}
        return JSONResponse({"command": line, **about})

    async def watch(self, request: Request) -> Response:
        body = await body_of(request)
        page = self._site.pages.found(text_in(body, "page"))
        before = self._watches.pop(page, None)
        if before is not None:
            await before.end()
        describe = self._described(body)
        if describe is None:
            return JSONResponse({"gui": ""})
        watch = self._watches[page] = PropertyWatch(page, self._client, self._threads)
        text = await watch.begin(describe)
        if self._watches.get(page) is not watch:  # the page has ended, or looks elsewhere
            await watch.end()
        return JSONResponse({"gui": text})

    def _described(self, body: Record) -> Callable[[], Panel] | None:
        if body.get("layout"):
            return partial(self._descriptions.of_page, read_panel(text_in(body, "layout")))
        if body.get("of"):
            return partial(self._descriptions.of, _target(body, "of"))
        return None

    async def component(self, request: Request) -> Response:
        target = _target(await body_of(request))
        if not target.endswith(".html"):
            raise NotFound(f"this is no component: {target}")
        code = await self._run(partial(self._client.payload, Ask(target), _BOUND_S))
        return JSONResponse({"address": self._components.address_for(str(code))})

    async def shown_component(self, request: Request) -> Response:
        if request.headers.get("sec-fetch-dest", "iframe") != "iframe":
            raise NotFound("this is for a frame")
        code = self._components.take(request.path_params["id"])
        return HTMLResponse(code, headers=dict(COMPONENT_HEADERS))

    async def _set(self, target: str, text: str, is_echoed: bool) -> object:
        ask = Ask(target, text, {"echo": 1} if is_echoed else {})
        return await self._run(partial(self._client.payload, ask, _BOUND_S))

    def _value_of(self, target: str) -> str | bytes:
        return self._client.payload(Ask(target), _BOUND_S)

    def _run(self, call: Callable[[], Any]) -> Awaitable[Any]:
        return asyncio.get_running_loop().run_in_executor(self._threads, call)

    def _notice(self, text: str) -> None:
        self._site.pages.send(NOTICE, {"level": "error", "text": text})

    def _page_ended(self, page: PageStream) -> None:
        self._held.page_ended(page)
        watch = self._watches.pop(page, None)
        if watch is not None:
            self._ending = asyncio.create_task(watch.end())

    async def _close(self) -> None:
        await self._held.close()
        for each in self._watches.values():
            await each.end()
        self._threads.shutdown(wait=False)


def set_line(target: str, text: str) -> str:
    """Return the command line that sets a property."""
    is_option = target.startswith("-") or text.startswith("-")
    return shlex.join(("rtset", *(("--",) if is_option else ()), target, text))


def _rest(body: Record) -> Rest | None:
    """Return what is set when a value is held no longer, None for one that is not held."""
    if "rest" not in body:
        return None
    after = body.get("after", _SHORTEST_REST_S)
    if isinstance(after, bool) or not isinstance(after, int | float):
        raise Malformed(f"after: a time is wanted [s], not {after!r}")
    return Rest(text_in(body, "rest"), min(_LONGEST_REST_S, max(_SHORTEST_REST_S, float(after))))


def _target(fields: Fields, key: str = "target") -> str:
    target = text_in(fields, key, "")
    if not target or "\n" in target:
        raise Malformed(f"{key}: the name of a property is wanted")
    return target
