"""Answers about system profiles that are edited with nothing running."""

from __future__ import annotations

import asyncio
from datetime import datetime
from itertools import count

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rtkit.api.live_records import Record
from rtkit.errors import LimitReached, Malformed, NotFound, Refused
from rtkit.profile_tools.new_system import new_system
from rtkit.web.audit.audit_log import Author
from rtkit.web.documents.component_types import TypeStock
from rtkit.web.documents.document import Document, opened
from rtkit.web.documents.document_edits import edited
from rtkit.web.documents.document_view import fitting_ports
from rtkit.web.documents.drafts import DocumentDraft, DocumentDrafts, digest
from rtkit.web.documents.lost_variables import lost_variables
from rtkit.web.fields import text_in, words_in
from rtkit.web.folders import granted
from rtkit.web.replies import body_of
from rtkit.web.site import WebSite

DOCUMENT = "document"
"""Event that tells all pages that a document has changed, or that it was closed."""
_MOST = 32
_WAYS = {"undo": -1, "redo": 1}


def routes(site: WebSite) -> list[Route]:
    """Return the requests about documents."""
    room = _DocumentRoom(site)
    site.closers.append(room.close_drafts)
    return [
        Route("/api/documents", room.listed),
        Route("/api/documents/types", room.types),
        Route("/api/documents/open", room.open, methods=["POST"]),
        Route("/api/documents/new", room.new, methods=["POST"]),
        Route("/api/documents/drafts/take", room.take, methods=["POST"]),
        Route("/api/documents/drafts/drop", room.drop, methods=["POST"]),
        Route("/api/documents/{id}", room.picture, methods=["POST"]),
        Route("/api/documents/{id}/edit", room.edit, methods=["POST"]),
        Route("/api/documents/{id}/move", room.move, methods=["POST"]),
        Route("/api/documents/{id}/save", room.save, methods=["POST"]),
        Route("/api/documents/{id}/close", room.close, methods=["POST"]),
        Route("/api/documents/{id}/fitting", room.fitting),
    ]


class _DocumentRoom:
    """Documents are shared by all pages: each change is told to all of them."""

    def __init__(self, site: WebSite) -> None:
        self._site = site
        self._types = TypeStock(site.folders)
        self._open: dict[str, Document] = {}
        self._drafts = DocumentDrafts()
        self._numbers = count(1)
        self._acting = asyncio.Lock()  # documents are read and changed by one request at a time

    async def listed(self, _request: Request) -> Response:
        drafts = await asyncio.to_thread(self._drafts.found, self._site.folders)
        documents = [each.heading() for each in self._open.values()]
        return JSONResponse({"documents": documents, "drafts": [each.record() for each in drafts]})

    async def take(self, request: Request) -> Response:
        self._site.check_change()
        body = await body_of(request)
        async with self._acting:
            draft = await asyncio.to_thread(
                self._drafts.one, text_in(body, "draft"), self._site.folders
            )
            if any(each.file == draft.file != "" for each in self._open.values()):
                raise Refused(f"{draft.file} is open: close it first")
            self._check_count()
            id = str(next(self._numbers))
            document = await asyncio.to_thread(self._recovered, id, draft)
            self._open[id] = document
            await asyncio.to_thread(self._drafts.keep, document)
            self._drafts.drop(draft.id)
            self._site.pages.send(DOCUMENT, {"id": id, "revision": document.revision})
            return await _answer(document, body)

    async def drop(self, request: Request) -> Response:
        self._site.check_change()
        body = await body_of(request)
        id = text_in(body, "draft")
        await asyncio.to_thread(self._drafts.one, id, self._site.folders)
        self._drafts.drop(id)
        return JSONResponse({})

    async def close_drafts(self) -> None:
        """Leave what was not saved to the next server."""
        self._drafts.close()

    def _recovered(self, id: str, draft: DocumentDraft) -> Document:
        try:
            file = granted(draft.file, self._site.folders) if draft.file else ""
        except NotFound:
            file = ""  # it was deleted: what was drawn is still there, without a file
        if not file:
            return Document(id, draft.profile, self._types)
        document = opened(id, file, self._types)
        document.recover(draft.profile, is_outdated=digest(document.data) != draft.base)
        return document

    async def types(self, _request: Request) -> Response:
        found = await asyncio.to_thread(self._types.records)
        return JSONResponse({"types": found})

    async def open(self, request: Request) -> Response:
        body = await body_of(request)
        file = granted(text_in(body, "file"), self._site.folders)
        async with self._acting:
            known = next((each for each in self._open.values() if each.file == file), None)
            if known is None:
                self._check_count()
                id = str(next(self._numbers))
                known = await asyncio.to_thread(opened, id, file, self._types)
                self._open[id] = known
            return await _answer(known, body)

    async def new(self, request: Request) -> Response:
        self._site.check_change()
        body = await body_of(request)
        async with self._acting:
            self._check_count()
            now = datetime.now().astimezone().replace(microsecond=0).isoformat()
            vendor, version = text_in(body, "vendor", "Me"), text_in(body, "version", "1.0.0")
            profile = new_system(text_in(body, "name"), now, vendor=vendor, version=version)
            id = str(next(self._numbers))
            document = await asyncio.to_thread(Document, id, profile, self._types)
            self._open[id] = document
            return await _answer(document, body)

    async def picture(self, request: Request) -> Response:
        body = await body_of(request)
        async with self._acting:
            return await _answer(self._found(request), body)

    async def edit(self, request: Request) -> Response:
        self._site.check_change()
        body = await body_of(request)
        edit = body.get("edit")
        if not isinstance(edit, dict):
            raise Malformed("edit: an object is wanted")
        async with self._acting:
            document = self._found(request)
            before = document.revision

            profile, text = await asyncio.to_thread(edited, document, edit, self._types)
            lost = lost_variables(document.profile, profile)
            if lost and body.get("replaces_variables") is not True:
                return JSONResponse({"asks": lost})
            await asyncio.to_thread(document.edit, profile, text)
            await asyncio.to_thread(self._drafts.keep, document)
            self._notify(document, before)
            return await _answer(document, body)

    async def move(self, request: Request) -> Response:
        self._site.check_change()
        body = await body_of(request)
        way = text_in(body, "way")
        if way not in _WAYS:
            raise Malformed(f"way: {' or '.join(_WAYS)}, not {way!r}")
        async with self._acting:
            document = self._found(request)
            before = document.revision
            await asyncio.to_thread(document.move, _WAYS[way])
            await asyncio.to_thread(self._drafts.keep, document)
            self._notify(document, before)
            return await _answer(document, body)

    async def save(self, request: Request) -> Response:
        self._site.check_change()
        body = await body_of(request)
        async with self._acting:
            document = self._found(request)
            file = text_in(body, "file", "") or document.file
            if not file:
                raise Malformed("file: this document has no file yet")
            granted(file, self._site.folders, is_new=True)
            taken = (each for each in self._open.values() if each is not document)
            if any(each.file == file for each in taken):
                raise Malformed(f"{file} is open as another document: close that first")
            before, is_replaced = document.revision, body.get("replace") is True
            await asyncio.to_thread(document.save, file, is_replaced=is_replaced)
            await asyncio.to_thread(self._drafts.keep, document)
            self._site.audit.add(Author(request), f"Save {file}")
            self._notify(document, before)
            return await _answer(document, body)

    async def close(self, request: Request) -> Response:
        async with self._acting:
            document = self._found(request)
            if document.is_changed:
                self._site.check_change()
            del self._open[document.id]
            self._drafts.drop_own(document)
            self._site.pages.send(DOCUMENT, {"id": document.id, "revision": None})
        return JSONResponse({})

    async def fitting(self, request: Request) -> Response:
        port = request.query_params.get("port", "")
        async with self._acting:
            view = self._found(request).view
        return JSONResponse({"ports": await asyncio.to_thread(fitting_ports, view, port)})

    def _found(self, request: Request) -> Document:
        id = request.path_params["id"]
        if id not in self._open:
            raise NotFound(f"No such document is open: {id}")
        return self._open[id]

    def _check_count(self) -> None:
        if len(self._open) >= _MOST:
            raise LimitReached(f"{_MOST} documents are open: close one")

    def _notify(self, document: Document, before: int) -> None:
        if document.revision != before:
            news = {"id": document.id, "revision": document.revision}
            self._site.pages.send(DOCUMENT, news)


async def _answer(document: Document, body: Record) -> Response:
    record = await asyncio.to_thread(document.record, words_in(body, "folded"))
    return JSONResponse(record)
