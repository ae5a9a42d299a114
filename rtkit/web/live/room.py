"""Answers about the system that lives: its layout, actions, what fits and is offered, events."""

from __future__ import annotations

import asyncio
import math

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from rtkit.api.asked import Ask
from rtkit.api.live_records import Record, SystemRecords
from rtkit.api.live_scene import drawing_of
from rtkit.drawing.export import FORMS, exported
from rtkit.errors import Malformed, NotFound
from rtkit.web.audit.audit_log import Author
from rtkit.web.fields import words_in
from rtkit.web.jobs.running import carried_out, records_from, shown
from rtkit.web.live.actions import steps_of
from rtkit.web.live.arrange import arranged, part_of
from rtkit.web.live.fitting import fitting, offers_of
from rtkit.web.live.steps import Action, CommandStep
from rtkit.web.replies import body_of
from rtkit.web.site import WebSite

_BOUND_S = 2.0
_TYPES = {"svg": "image/svg+xml"}


def routes(site: WebSite) -> list[Route]:
    """Return the requests about what lives."""
    room = _SystemRoom(site)
    return [
        Route("/api/layout", room.layout, methods=["POST"]),
        Route("/api/do", room.do, methods=["POST"]),
        Route("/api/connectable", room.connectable),
        Route("/api/offers", room.offers),
        Route("/api/export", room.export),
        Route("/api/events", room.events),
    ]


class _SystemRoom:
    def __init__(self, site: WebSite) -> None:
        self._site = site
        self._acting = asyncio.Lock()

    async def layout(self, request: Request) -> Response:
        body = await body_of(request)
        folded, moment = words_in(body, "folded"), body.get("at")
        if moment is not None and (isinstance(moment, bool) or not isinstance(moment, int | float)):
            raise Malformed("at: a time is wanted [s since 1970]")
        revision, records = self._site.revision, self._records_at(moment)
        if "shown" in body:
            records = part_of(records, frozenset(words_in(body, "shown")))
        layout = await asyncio.to_thread(arranged, records, folded)
        return JSONResponse({"revision": revision, **layout})

    async def do(self, request: Request) -> Response:
        body = await body_of(request)
        async with self._acting:  # what one action expects, another one may not change meanwhile
            given = body.get("actions"), self._site.records, self._site.folders, self._value_of
            steps = await asyncio.to_thread(steps_of, *given)
            if body.get("dry_run"):
                return JSONResponse(_outcome([shown(each) for each in steps], steps))
            self._site.check_change()
            done: list[Record] = []
            for step in steps:
                done.append(await carried_out(step))
                self._site.audit.add_step(Author(request), step, done[-1])
                if not done[-1]["ok"]:
                    break
        done += [shown(each) for each in steps[len(done) :]]
        return JSONResponse(_outcome(done, steps))

    def _records_at(self, moment: float | None) -> SystemRecords:
        """Return what was at a moment [s since 1970], what is for None."""
        return self._site.records if moment is None else self._site.past.at(moment)

    def _value_of(self, target: str) -> str | bytes:
        return self._site.client.payload(Ask(target), _BOUND_S)

    async def connectable(self, request: Request) -> Response:
        port = request.query_params.get("port", "")
        return JSONResponse({"ports": fitting(port, self._site.managers, self._site.host)})

    async def offers(self, request: Request) -> Response:
        id = request.query_params.get("manager", "")
        if id not in self._site.records.managers:
            raise NotFound(f"No such manager: {id}")
        rows, (manager,) = await asyncio.gather(
            records_from(("rtmgr", "--json", "-m", "--", id)),
            records_from(("rtcat", "--json", "--", id)),
        )
        return JSONResponse(offers_of(rows, manager["modules"]))

    async def export(self, request: Request) -> Response:
        form = request.query_params.get("form", "svg")
        if form not in FORMS:
            raise Malformed(f"form: {', '.join(FORMS)}, not {form!r}")
        moment = _time_in(request, "at") if "at" in request.query_params else None
        since = self._site.past.since
        if moment is not None and moment < since:
            raise NotFound(f"at: what was before {since:.3f} is not known")
        text = exported(drawing_of(self._records_at(moment)).scene, form, self._site.host)
        return PlainTextResponse(text, media_type=_TYPES.get(form, "text/plain"))

    async def events(self, request: Request) -> Response:
        since = _time_in(request, "since")
        return JSONResponse({"events": [e for e in self._site.events if e["time"] >= since]})


def _time_in(request: Request, key: str) -> float:
    """Return a time that a request names, 0 where it names none [s since 1970].

    Raises:
        Malformed: It is none.
    """
    try:
        time = float(request.query_params.get(key, "0"))
    except ValueError:
        time = math.nan
    if not math.isfinite(time):
        raise Malformed(f"{key}: a time is wanted [s since 1970]")
    return time


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
