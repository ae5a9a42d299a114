"""Answers about state machines: which there are, how one stands, and drafts of them."""

from __future__ import annotations

import asyncio
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.responses import StreamingResponse as Streaming
from starlette.routing import Route

from rtkit import PropertyError
from rtkit.api.asked import Ask
from rtkit.api.live_records import Record
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.services.statemachine.model import BadMachine
from rtkit.services.statemachine.rdf import write_machine
from rtkit.services.statemachine.texts import as_rdf_xml, read_text
from rtkit.web.fields import text_in
from rtkit.web.folders import granted, profiles_in
from rtkit.web.machines.drafts import draft_of, record_of
from rtkit.web.machines.machine_layout import machine_layout
from rtkit.web.machines.machine_steps import ENDINGS
from rtkit.web.machines.machine_watch import news_of
from rtkit.web.replies import body_of
from rtkit.web.site import WebSite

_BOUND_S = 2.0
_SHOWN = ("state", "run", "status")
_MOST_LETTERS = 4 << 20


def routes(site: WebSite) -> list[Route]:
    """Return the requests about state machines."""
    room = _MachineRoom(site)
    return [
        Route("/api/machines", room.machines),
        Route("/api/machine/stream", room.stream),
        Route("/api/machine/places", room.places),
        Route("/api/machine/stored", room.stored),
        Route("/api/machine/draft", room.draft, methods=["POST"]),
        Route("/api/machine/read", room.read, methods=["POST"]),
        Route("/api/machine/write", room.write, methods=["POST"]),
    ]


class _MachineRoom:
    def __init__(self, site: WebSite) -> None:
        self._site = site

    async def machines(self, _request: Request) -> Response:
        """Answer the machines of this host and of those that are linked."""
        return JSONResponse({"machines": await asyncio.to_thread(self._machines)})

    def _machines(self) -> list[Record]:
        machines = [id for id, words in self._services().items() if "statemachine" in words]
        answers = iter(self._ask(*(Ask(f"{id}.{name}") for id in machines for name in _SHOWN)))
        return [{"id": id, **{name: str(next(answers)) for name in _SHOWN}} for id in machines]

    async def places(self, _request: Request) -> Response:
        """Answer where machines may be stored: in storage services, and in folders."""
        stored = await asyncio.to_thread(self._stored)
        files = await asyncio.to_thread(profiles_in, self._site.folders, ENDINGS)
        folders = list(self._site.folders)
        return JSONResponse({"stored": stored, "folders": folders, "files": files})

    def _stored(self) -> list[str]:
        """Return the properties of storage services whose names end as those of machines do."""
        storages = [id for id, words in self._services().items() if "storage" in words]
        asks = [(id, ending) for id in storages for ending in ENDINGS]
        answers = self._ask(*(Ask(f"{id}.search", parameters={"name": f"*{e}"}) for id, e in asks))
        found = zip(asks, answers, strict=True)
        return sorted(f"{id}.{name}" for (id, _), names in found for name in _words(names))

    def _services(self) -> dict[str, tuple[str, ...]]:
        """Return the types of all services, by their paths."""
        hosts = sorted({each.place for each in self._site.managers} - {"localhost"})
        lists = self._ask(*(Ask(f"/{each}.services") for each in ("localhost", *hosts)))
        ids = [
            f"/{host}/{name}" if host else name
            for host, names in zip(("", *hosts), lists, strict=True)
            for name in _words(names)
        ]
        return dict(
            zip(ids, map(_words, self._ask(*(Ask(f"{id}.type") for id in ids))), strict=True)
        )

    def _ask(self, *asks: Ask) -> list[Any]:
        """Return answers, and errors of those that do not answer."""
        return self._site.client.ask_all(asks, _BOUND_S)

    async def stream(self, request: Request) -> Response:
        machine = _parameter(request, "of")
        news = news_of(self._site.client, machine)
        return Streaming(news, media_type="text/event-stream")

    async def stored(self, request: Request) -> Response:
        """Answer the text in a property of a storage, or in a file of a folder."""
        file = request.query_params.get("file", "")
        if file:
            path = granted(file, self._site.folders, endings=ENDINGS)
            text = await asyncio.to_thread(_content, path)
        else:
            target = _parameter(request, "target")
            text = await asyncio.to_thread(self._property, target)
        return JSONResponse({"text": text})

    def _property(self, target: str) -> str:
        try:
            return self._site.client.get_bytes(target).decode()
        except (PropertyError, UnicodeDecodeError) as error:
            raise Refused(f"{target}: {error}") from None

    async def draft(self, request: Request) -> Response:
        record = (await body_of(request)).get("machine")
        return JSONResponse(await asyncio.to_thread(_answer, record))

    async def read(self, request: Request) -> Response:
        """Answer the machine that a text is, or another one with the state that it is."""
        body = await body_of(request)
        text, at = text_in(body, "text", ""), text_in(body, "at", "")
        record = body.get("machine") if at else None
        return JSONResponse({"machine": await asyncio.to_thread(_read, text, record, at)})

    async def write(self, request: Request) -> Response:
        """Answer the text of a machine, or of a state with all inside it."""
        body = await body_of(request)
        form, at = text_in(body, "form", ""), text_in(body, "at", "")
        text = await asyncio.to_thread(_written, body.get("machine"), form, at)
        return JSONResponse({"text": text})


def _words(answer: Any) -> tuple[str, ...]:
    return tuple(map(str, answer)) if isinstance(answer, tuple) else ()


def _parameter(request: Request, name: str) -> str:
    value = request.query_params.get(name, "")
    if not value or "?" in value:
        raise Malformed(f"{name}: a path is wanted")
    return value


def _content(path: str) -> str:
    with open(path, encoding="utf-8") as stream:
        return stream.read(_MOST_LETTERS)


def _read(text: str, record: object, at: str) -> Record:
    try:
        return record_of(read_text(text, draft_of(record).machine if at else None, at))
    except BadMachine as error:
        raise Malformed(f"this is no machine: {error}") from None


def _answer(record: object) -> Record:
    """Return what a page is told of a draft: where it is drawn, what is wrong, its text."""
    draft = draft_of(record)
    return {
        "layout": machine_layout(draft.machine),
        "problems": [each._asdict() for each in draft.problems],
        "text": write_machine(draft.machine) if draft.is_whole else "",
    }


def _written(record: object, form: str, at: str) -> str:
    draft = draft_of(record)
    wrong = next((each for each in draft.problems if not each.is_odd), None)
    if wrong is not None:
        raise Refused(f"{wrong.state or 'the machine'}: {wrong.text}")
    if at and at not in draft.machine.states:
        raise NotFound(f"No such state: {at}")
    if form == "scxml" and not at:
        from rtkit.services.statemachine.scxml import write_scxml

        return write_scxml(draft.machine)
    text = write_machine(draft.machine, at)
    if form not in ("turtle", "xml"):
        raise Malformed(f"form: turtle, xml, of a whole machine scxml, not {form!r}")
    return as_rdf_xml(text) if form == "xml" else text
