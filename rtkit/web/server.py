"""Serves the page: static files, the stream of changes, and the rooms that answer requests.

One event loop owns the records and the pages. The feed has a thread of its own, whose tidings come
in by `call_soon_threadsafe`; commands run as processes of their own.
"""

from __future__ import annotations

import asyncio
import socket
import ssl
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from importlib.resources import files
from types import FrameType
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.responses import StreamingResponse as Streaming
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rtkit.api.live_records import Record
from rtkit.errors import LimitReached, RtkitError
from rtkit.web.feed import FeedUpdate, SystemFeed
from rtkit.web.guard import HEADERS, MOST_A_SECOND, Pace, Refusal, WebGuard
from rtkit.web.pages import CHANGE, NOTICE, RATES
from rtkit.web.replies import error_of, not_served, refused
from rtkit.web.rooms import ROOMS
from rtkit.web.site import MOST_PAGES, WebSite

STATIC = str(files("rtkit.web").joinpath("static"))


class WebServer:
    """Keeps what lives up to date, and tells the pages that look at it."""

    def __init__(self, site: WebSite, guard: WebGuard, ready: Callable[[], None]) -> None:
        """Serve nothing yet; `ready` is called when requests are answered."""
        self._site = site
        self._guard = guard
        self._ready = ready
        self._feed = SystemFeed(
            site.session,
            self._enter(self._take),
            self._enter(self._notice),
            self._enter(self._give_up),
        )
        self.failure: Exception | None = None
        self.end: Callable[[], None] = _never

    def app(self) -> ASGIApp:
        """Return the application, with the guard before it."""
        routes = [
            Route("/", lambda _request: FileResponse(f"{STATIC}/index.html")),
            Route("/api/stream", self._stream),
            *(route for room in ROOMS for route in room(self._site)),
            Mount("/", StaticFiles(directory=STATIC, check_dir=False)),
        ]
        handlers = {RtkitError: refused, HTTPException: not_served}
        app = Starlette(routes=routes, lifespan=self._lifespan, exception_handlers=handlers)  # type: ignore[arg-type]
        return _Guarded(app, self._guard)

    @asynccontextmanager
    async def _lifespan(self, _app: Starlette) -> AsyncIterator[None]:
        self._loop = asyncio.get_running_loop()
        self._feed.start()
        self._ready()
        yield
        for close in self._site.closers:
            await close()
        await asyncio.to_thread(self._feed.close)
        await asyncio.to_thread(self._site.close)

    def _enter(self, take: Callable[[Any], None]) -> Callable[[Any], None]:
        def enter(news: Any) -> None:
            self._loop.call_soon_threadsafe(take, news)

        return enter

    # Updates of the feed

    def _take(self, update: FeedUpdate) -> None:
        was_known = self._site.is_known
        change = self._site.take(update)
        if not was_known:
            self._site.pages.wake()
        elif change is not None:
            self._site.pages.send(CHANGE, change)
        if update.rates is not None:
            self._site.pages.send(RATES, update.rates)

    def _give_up(self, failure: Exception) -> None:
        """End: pages that are not told what changes would show what is not so."""
        self.failure = failure
        self.end()

    def end_streams(self) -> None:
        """Have the streams of all pages end when the loop looks next; signals may call it."""
        self._site.pages.end()

    def _notice(self, text: str) -> None:
        self._site.pages.send(NOTICE, {"level": "warning", "text": text})

    async def _stream(self, request: Request) -> Response:
        pages = self._site.pages
        if pages.is_full:
            raise LimitReached(f"{pages.most} pages are open already")
        id = request.query_params.get("page", "")[:64]
        return Streaming(pages.stream(self._picture, id), media_type="text/event-stream")

    def _picture(self) -> Record | None:
        return self._site.picture() if self._site.is_known else None


class _Guarded:
    """Asks the guard about each request, and sets the headers of each response."""

    def __init__(self, app: ASGIApp, guard: WebGuard) -> None:
        self._app = app
        self._guard = guard
        self._pace = Pace()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See ASGI."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in (*HEADERS.items(), ("Cache-Control", _caching(scope["path"]))):
                    headers.setdefault(name, value)  # a component of a service has its own policy
            await send(message)

        headers = {name.lower(): value for name, value in Headers(scope=scope).items()}
        # A page whose name was bound anew to this host has a name, not the address it came to.
        came_to = str((scope.get("server") or ("",))[0]).lower()
        guard = self._guard
        if guard.is_public:
            guard = guard._replace(names=guard.names | {came_to})
        refusal = guard.refusal(scope["method"], scope["path"], headers)
        if refusal is None and scope["path"].startswith("/api/") and not self._pace.admits():
            refusal = Refusal(429, "limit", f"more than {MOST_A_SECOND} requests a second")
        app = self._app if refusal is None else error_of(refusal)
        await app(scope, receive, with_headers)


def _caching(path: str) -> str:
    """Return how long a browser may keep an answer: files with a hash in their name for ever."""
    is_hashed = path.startswith("/assets/")
    return "public, max-age=31536000, immutable" if is_hashed else "no-store"


class _Runner(uvicorn.Server):
    """Ends the streams when it is told to end: pages would read theirs for ever."""

    def __init__(self, config: uvicorn.Config, end_streams: Callable[[], object]) -> None:
        super().__init__(config)
        self._end_streams = end_streams

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Take a signal, on the thread of the event loop."""
        self._end_streams()
        super().handle_exit(sig, frame)


def _never() -> None:
    """Stand for the end of a server that does not run."""


def serve(server: WebServer, listener: socket.socket, tls: ssl.SSLContext | None = None) -> None:
    """Serve at a socket that listens already, by TLS where given, until told to end.

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
        limit_concurrency=MOST_PAGES * 4,
        ws="none",
    )
    config.load()
    config.ssl = tls
    runner = _Runner(config, server.end_streams)
    server.end = lambda: setattr(runner, "should_exit", True)
    runner.run(sockets=[listener])
    if server.failure is not None:
        raise server.failure
