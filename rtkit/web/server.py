"""Serves the page: static files, the stream of changes, layouts, and what pages have done.

One event loop owns the records and the pages. The feed has a thread of its own, whose tidings come
in by `call_soon_threadsafe`; commands run as processes of their own.
"""

from __future__ import annotations

import asyncio
import json
import math
import shlex
import socket
from collections import deque
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from importlib.resources import files
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.responses import StreamingResponse as Streaming
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rtkit.api.session import Session
from rtkit.drawing.export import FORMS, exported
from rtkit.errors import Malformed, NotFound, Refused, RtkitError, Unreachable
from rtkit.link.places import host_name
from rtkit.version import __version__
from rtkit.web.actions import Action, CommandStep, steps_of
from rtkit.web.arrange import arranged, scene_of
from rtkit.web.feed import FeedUpdate, SystemFeed
from rtkit.web.fitting import fitting, offers_of
from rtkit.web.folders import granted, profiles_in
from rtkit.web.guard import HEADERS, Refusal, WebGuard
from rtkit.web.pages import CHANGE, NOTICE, RATES, Pages
from rtkit.web.records import Record, SystemRecords, change_between
from rtkit.web.running import carried_out, records_from, shown

HERE = "127.0.0.1"
"""The address of the page, which only this host reaches."""
STATIC = str(files("rtkit.web").joinpath("static"))
_MOST_BYTES = 4 << 20
_MOST_PAGES = 64
_KEPT_EVENTS = 10_000
_STATUSES = {NotFound.kind: 404, Malformed.kind: 400, Refused.kind: 409}
_TYPES = {"svg": "image/svg+xml"}


class WebServer:
    """The records of what lives, the pages that look at them, and the routes."""

    def __init__(
        self,
        session: Session,
        guard: WebGuard,
        ready: Callable[[], None],
        folders: Sequence[str] = (),
    ) -> None:
        """Serve nothing yet; `ready` is called when requests are answered.

        Files are read and written in `folders` only, whose paths have no links.
        """
        self._folders = folders
        self._ready = ready
        self._guard = guard
        self._host = host_name()
        self._update = FeedUpdate(SystemRecords.nothing(), (), (), None)
        self._revision = 0
        self._events: deque[Record] = deque(maxlen=_KEPT_EVENTS)
        self._pages = Pages(_MOST_PAGES)
        self._feed = SystemFeed(
            session, self._enter(self._take), self._enter(self._notice), self._enter(self._give_up)
        )
        self.failure: Exception | None = None
        self.end: Callable[[], None] = _never
        self._acting = asyncio.Lock()

    def app(self) -> ASGIApp:
        """Return the application, with the guard before it."""
        routes = [
            Route("/", lambda _request: FileResponse(f"{STATIC}/index.html")),
            Route("/api/stream", self._stream),
            Route("/api/layout", self._layout, methods=["POST"]),
            Route("/api/do", self._do, methods=["POST"]),
            Route("/api/connectable", self._connectable),
            Route("/api/offers", self._offers),
            Route("/api/files", self._files),
            Route("/api/compare", self._compare),
            Route("/api/export", self._export),
            Route("/api/events", self._history),
            Mount("/", StaticFiles(directory=STATIC, check_dir=False)),
        ]
        handlers = {RtkitError: _refused, HTTPException: _not_served}
        app = Starlette(routes=routes, lifespan=self._lifespan, exception_handlers=handlers)  # type: ignore[arg-type]
        return _Guarded(app, self._guard)

    @asynccontextmanager
    async def _lifespan(self, _app: Starlette) -> AsyncIterator[None]:
        self._loop = asyncio.get_running_loop()
        self._feed.start()
        self._ready()
        yield
        await asyncio.to_thread(self._feed.close)

    def _enter(self, take: Callable[[Any], None]) -> Callable[[Any], None]:
        def enter(news: Any) -> None:
            self._loop.call_soon_threadsafe(take, news)

        return enter

    # Updates of the feed

    def _take(self, update: FeedUpdate) -> None:
        change = change_between(self._update.records, update.records)
        self._update = update
        self._events.extend(update.events)
        if change or update.events:
            self._revision += 1
            fresh = {name: list(each.values()) for name, each in change.fresh._asdict().items()}
            data = {"revision": self._revision, **fresh, "gone": change.gone}
            self._pages.send(CHANGE, {**data, "events": list(update.events)})
        if update.rates is not None:
            self._pages.send(RATES, update.rates)

    def _give_up(self, failure: Exception) -> None:
        """End: pages that are not told what changes would show what is not so."""
        self.failure = failure
        self.end()

    def _notice(self, text: str) -> None:
        self._pages.send(NOTICE, {"level": "warning", "text": text})

    def _picture(self) -> Record:
        records = {
            name: list(each.values()) for name, each in self._update.records._asdict().items()
        }
        return {
            "revision": self._revision,
            "host": self._host,
            "version": __version__,
            "read_only": self._guard.is_read_only,
            **records,
        }

    # Requests

    async def _stream(self, _request: Request) -> Response:
        if self._pages.is_full:
            return _error(Refusal(503, "limit", f"{_MOST_PAGES} pages are open already"))
        return Streaming(self._pages.stream(self._picture), media_type="text/event-stream")

    async def _layout(self, request: Request) -> Response:
        folded = (await _body(request)).get("folded", [])
        if not isinstance(folded, list) or not all(isinstance(each, str) for each in folded):
            raise Malformed("folded: a list of ids is wanted")
        revision, records = self._revision, self._update.records
        layout = await asyncio.to_thread(arranged, records, folded)
        return JSONResponse({"revision": revision, **layout})

    async def _do(self, request: Request) -> Response:
        body = await _body(request)
        async with self._acting:  # what one action expects, another one may not change meanwhile
            steps = steps_of(body.get("actions"), self._update.records, self._folders)
            if body.get("dry_run"):
                return JSONResponse(_outcome([shown(each) for each in steps], steps))
            if self._guard.is_read_only:
                return _error(Refusal(403, "denied", "this page is read-only"))
            done: list[Record] = []
            for step in steps:
                done.append(await carried_out(step))
                if not done[-1]["ok"]:
                    break
        done += [shown(each) for each in steps[len(done) :]]
        return JSONResponse(_outcome(done, steps))

    async def _connectable(self, request: Request) -> Response:
        port = request.query_params.get("port", "")
        return JSONResponse({"ports": fitting(port, self._update.managers, self._host)})

    async def _offers(self, request: Request) -> Response:
        id = request.query_params.get("manager", "")
        if id not in self._update.records.managers:
            raise NotFound(f"No such manager: {id}")
        rows, (manager,) = await asyncio.gather(
            records_from(("rtmgr", "--json", "-m", "--", id)),
            records_from(("rtcat", "--json", "--", id)),
        )
        return JSONResponse(offers_of(rows, [each["file"] for each in manager["modules"]]))

    async def _files(self, _request: Request) -> Response:
        files = await asyncio.to_thread(profiles_in, self._folders)
        return JSONResponse({"folders": list(self._folders), "files": files})

    async def _compare(self, request: Request) -> Response:
        file = granted(request.query_params.get("file", ""), self._folders)
        state = request.query_params.get("state", "active")
        line = ("rtcheck", "--json", "--state", state, "--", file)
        deviations = await records_from(line, good=(0, 1))
        return JSONResponse({"command": shlex.join(line), "deviations": deviations})

    async def _export(self, request: Request) -> Response:
        form = request.query_params.get("form", "svg")
        if form not in FORMS:
            raise Malformed(f"form: {', '.join(FORMS)}, not {form!r}")
        text = exported(scene_of(self._update.records), form, self._host)
        return PlainTextResponse(text, media_type=_TYPES.get(form, "text/plain"))

    async def _history(self, request: Request) -> Response:
        try:
            since = float(request.query_params.get("since", "0"))
        except ValueError:
            since = math.nan
        if not math.isfinite(since):
            raise Malformed("since: a time is wanted [s since 1970]")
        return JSONResponse({"events": [each for each in self._events if each["time"] >= since]})


def _outcome(done: list[Record], steps: list[CommandStep]) -> Record:
    """Return how steps went, and the actions that take back those that were done."""
    count = sum(each["ok"] is not False for each in done)
    undone = steps[: next((n for n, each in enumerate(done) if each["ok"] is False), count)]
    undo: list[Action] | None = []
    reason = ""
    for step in reversed(undone):
        if step.undo is None:
            undo, reason = None, step.undo_reason
            break
        undo = [*(undo or []), *step.undo]
    return {"steps": done, "undo": undo, "undo_reason": reason}


async def _body(request: Request) -> Record:
    """Return the JSON object in a request.

    Raises:
        Malformed: There is none, or it is too large.
    """
    data = bytearray()
    async for piece in request.stream():
        data += piece
        if len(data) > _MOST_BYTES:
            raise Malformed(f"a request has {_MOST_BYTES >> 20} MiB at most")
    try:
        body = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise Malformed(f"this is no JSON: {error}") from None
    if not isinstance(body, dict):
        raise Malformed("a JSON object is wanted")
    return body


def _error(refusal: Refusal) -> JSONResponse:
    error = {"kind": refusal.kind, "text": refusal.text}
    return JSONResponse({"error": error}, status_code=refusal.status)


def _refused(_request: Request, error: RtkitError) -> Response:
    return _error(Refusal(_STATUSES.get(error.kind, 500), error.kind, str(error)))


def _not_served(request: Request, error: HTTPException) -> Response:
    kind = NotFound.kind if error.status_code == 404 else Malformed.kind
    return _error(Refusal(error.status_code, kind, f"{request.url.path}: {error.detail}"))


class _Guarded:
    """Asks the guard about each request, and sets the headers of each response."""

    def __init__(self, app: ASGIApp, guard: WebGuard) -> None:
        self._app = app
        self._guard = guard

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See ASGI."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in (*HEADERS.items(), ("Cache-Control", _caching(scope["path"]))):
                    headers[name] = value
            await send(message)

        headers = {name.lower(): value for name, value in Headers(scope=scope).items()}
        refusal = self._guard.refusal(scope["method"], scope["path"], headers)
        app = self._app if refusal is None else _error(refusal)
        await app(scope, receive, with_headers)


def _caching(path: str) -> str:
    """Return how long a browser may keep an answer: files with a hash in their name for ever."""
    is_hashed = path.startswith("/assets/")
    return "public, max-age=31536000, immutable" if is_hashed else "no-store"


def _never() -> None:
    """Stand for the end of a server that does not run."""


def listening(port: int) -> socket.socket:
    """Return a socket that listens on this host only, at a free port for 0.

    Raises:
        Unreachable: The port is taken.
    """
    listener = socket.socket()
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((HERE, port))
    except OSError as error:
        listener.close()
        raise Unreachable(f"port {port}: {error.strerror}") from None
    listener.listen(128)
    return listener


def address_of(listener: socket.socket, token: str) -> str:
    """Return the address that the user opens; what is behind ``#`` is never sent."""
    return f"http://{HERE}:{listener.getsockname()[1]}/#token={token}"


def serve(server: WebServer, listener: socket.socket) -> None:
    """Serve at a socket that listens already, until the process is told to end.

    Raises:
        Exception: What ended the feed.
    """
    config = uvicorn.Config(
        server.app(),
        log_level="warning",
        access_log=False,
        server_header=False,
        date_header=False,
        timeout_graceful_shutdown=1,
        limit_concurrency=_MOST_PAGES * 4,
        ws="none",
    )
    runner = uvicorn.Server(config)
    server.end = lambda: setattr(runner, "should_exit", True)
    runner.run(sockets=[listener])
    if server.failure is not None:
        raise server.failure
