"""Compares a system profile with another, or with what lives, as a list and as a picture.

Facts and verdict are those of ``rtprofile diff`` and of ``rtcheck --diff``. The picture shows both
systems in one, with a mark at whatever differs.
"""

from __future__ import annotations

import asyncio
import json
import shlex
from collections.abc import Sequence

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rtkit.api.live_records import Record
from rtkit.api.system_profiles import load
from rtkit.errors import Refused
from rtkit.profile.read import read_rts
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile_tools.difference import Difference
from rtkit.web.folders import granted
from rtkit.web.jobs.running import outcome_of
from rtkit.web.plans.compared_scene import CHANGED, marks_of, pictured, subject_at, subject_in
from rtkit.web.plans.room import live_profile
from rtkit.web.site import WebSite

ADDED, REMOVED = "+", "-"
_CHANGES = {"added": ADDED, "removed": REMOVED, "changed": CHANGED}

_Two = tuple[RtsProfile, RtsProfile]


def routes(site: WebSite) -> list[Route]:
    """Return the requests that compare."""

    async def compare(request: Request) -> Response:
        asked = request.query_params
        before = granted(asked.get("before", ""), site.folders)
        if after := asked.get("after", ""):
            return JSONResponse(await _with_file(before, granted(after, site.folders)))
        return JSONResponse(await _with_live(before, asked.get("state", "active")))

    return [Route("/api/plans/compare", compare)]


async def _with_file(before: str, after: str) -> Record:
    line = ("rtprofile", "diff", "--json", "--", before, after)
    rows, is_same = await _compared(line)
    profiles = load(before).profile, load(after).profile
    return _comparison(line, [_of_files(row, profiles) for row in rows], is_same, profiles)


async def _with_live(file: str, state: str) -> Record:
    line = ("rtcheck", "--diff", "--json", f"--state={state}", "--", file)
    (rows, is_same), live = await asyncio.gather(_compared(line), live_profile())
    profiles = load(file).profile, read_rts(live, "what lives").profile
    return _comparison(line, [_of_live(row, profiles) for row in rows], is_same, profiles)


def _comparison(line: Sequence[str], facts: list[Record], is_same: bool, profiles: _Two) -> Record:
    marks = marks_of(facts, lambda fact: fact["is_whole"])
    picture = pictured(*profiles, marks)
    return {"command": shlex.join(line), "same": is_same, "facts": facts, "picture": picture}


async def _compared(line: Sequence[str]) -> tuple[list[Record], bool]:
    """Return what a command tells, and its verdict.

    Raises:
        Refused: It could not compare; says why.
        Unreachable: It did not end in time.
    """
    outcome = await outcome_of(line)
    rows = [json.loads(each) for each in outcome.out.splitlines()]
    if outcome.status and (outcome.status != 1 or not rows):
        raise Refused(outcome.error or f"{line[0]} failed")
    return rows, outcome.status == 0


def _of_files(row: Record, profiles: _Two) -> Record:
    row.pop("schema")
    difference = Difference(**row)
    return {
        "mark": _CHANGES[difference.change],
        "text": difference.text[2:],
        "required": True,
        "is_whole": not difference.field,
        "subject": subject_in(difference.name, profiles),
    }


def _of_live(row: Record, profiles: _Two) -> Record:
    is_whole = row["kind"] in ("component", "connection") and not (row["wanted"] and row["found"])
    mark = CHANGED if not is_whole else ADDED if row["found"] else REMOVED
    return {
        "mark": mark,
        "text": row["text"],
        "required": row["required"],
        "wanted": row["wanted"],
        "found": row["found"],
        "is_whole": is_whole,
        "subject": subject_at(row["path"], profiles),
    }
