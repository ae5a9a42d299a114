"""Plans of the page: what is to become of a system, shown as its command plans it, then done.

A request names what is to be done (`DOES`), the file of a system profile, or no file for what
lives now, and options. What is done is what was shown: where what lives has changed meanwhile, the
page has to look again.
"""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rtkit.api.live_records import Record
from rtkit.errors import Malformed, Refused
from rtkit.web.audit.audit_log import Author
from rtkit.web.fields import text_in, texts_in, words_in
from rtkit.web.folders import granted
from rtkit.web.jobs.running import outcome_of
from rtkit.web.live.steps import Action
from rtkit.web.replies import body_of
from rtkit.web.site import WebSite

KIND = "plan"
"""The kind of jobs that carry out a plan."""
LIVE_LINE = ("rtcryo", "--all")
"""Tells what lives now, as a profile."""


class _Deed(NamedTuple):
    """One way to deal with a system profile.

    Attributes:
        line: The command that does it; with `_JSON` it tells what becomes of each step.
        looks: The command that plans it; with `_JSON` it tells the plan.
        text: What it does, as a sentence about a profile.
        flags: Options without a value that it has.
    """

    line: tuple[str, ...]
    looks: tuple[str, ...]
    text: str
    flags: tuple[str, ...]


_MAKING = ("stand-in", "transmit")
DOES: Mapping[str, _Deed] = {
    "apply": _Deed(
        ("rtapply",), ("rtplan",), "Apply {}",
        ("replace", "prune", "rollback", *_MAKING),
    ),
    "restore": _Deed(
        ("rtresurrect",), ("rtresurrect", "--dry-run"), "Restore {}",
        ("no-create", "strict-path", *_MAKING),
    ),
    "start": _Deed(("rtstart",), ("rtstart", "--dry-run"), "Start {}", ()),
    "stop": _Deed(("rtstop",), ("rtstop", "--dry-run"), "Stop {}", ()),
    "take_down": _Deed(
        ("rtteardown",), ("rtteardown", "--dry-run"), "Take down {}", ("exit", "uninstall"),
    ),
}  # fmt: skip
_STATES = ("active", "inactive", "any")
_JSON = "--json"
_ONLY_DONE = ("--rollback",)
"""Options that a look does not have."""


class PlanRequest(NamedTuple):
    """A request that was read.

    Attributes:
        deed: What is to be done.
        file: The file of the profile; empty for what lives now.
        options: Of the command line.
    """

    deed: _Deed
    file: str
    options: tuple[str, ...]

    @property
    def line(self) -> tuple[str, ...]:
        """The command line that does it."""
        return self._with(self.deed.line, self.options)

    @property
    def look(self) -> tuple[str, ...]:
        """The command line that shows the plan."""
        return self._with(self.deed.looks, [o for o in self.options if o not in _ONLY_DONE])

    @property
    def text(self) -> str:
        """A sentence about what it does."""
        return self.deed.text.format(os.path.basename(self.file) or "what lives now")

    def _with(self, line: tuple[str, ...], options: Sequence[str]) -> tuple[str, ...]:
        return (*line, *options, *(("--", self.file) if self.file else ()))

    def typed(self, line: Sequence[str]) -> str:
        """Return a command line as a user types it."""
        text = shlex.join(line)
        return text if self.file else f"{shlex.join(LIVE_LINE)} | {text}"

    async def given(self) -> bytes | None:
        """Return what the command reads from stdin: what lives now, if there is no file."""
        return None if self.file else (await live_profile()).encode()


async def live_profile() -> str:
    """Return what lives now as a profile.

    Raises:
        Refused: It cannot be told; says why.
        Unreachable: That took too long.
    """
    outcome = await outcome_of(LIVE_LINE)
    if not outcome.out:
        raise Refused(outcome.error or "nothing lives")
    return outcome.out


def request_in(body: Action, folders: Sequence[str]) -> PlanRequest:
    """Read what a page asks for.

    Raises:
        Malformed: It makes no sense; names the part.
        Refused: The file is in no folder that was granted.
        NotFound: There is no such file.
    """
    name = text_in(body, "do")
    if name not in DOES:
        raise Malformed(f"do: there is no {name!r}; there are {', '.join(DOES)}")
    deed = DOES[name]
    file = text_in(body, "file", "")
    if file:
        file = granted(file, folders)
    flags = body.get("flags", [])
    if not isinstance(flags, list) or not all(each in deed.flags for each in flags):
        raise Malformed(f"flags: {name} has {', '.join(deed.flags) or 'none'}, not {flags!r}")
    options = [f"--{each}" for each in deed.flags if each in flags]
    state = text_in(body, "state", "")
    if state and (name != "apply" or state not in _STATES):
        raise Malformed(f"state: apply has {', '.join(_STATES)}, not {state!r}")
    options += [f"--state={state}"] if state else []
    options += [f"--map={old}={new}" for old, new in texts_in(body, "map").items() if old != new]
    options += [f"--set={key}={value}" for key, value in texts_in(body, "set").items()]
    options += [f"--place={name}={place}" for name, place in texts_in(body, "place").items()]
    options += [f"--without={each}" for each in words_in(body, "without")]
    prefix = text_in(body, "prefix", "")
    options += [f"--prefix={prefix}"] if prefix else []
    return PlanRequest(deed, file, tuple(options))


async def plan_of(request: PlanRequest, given: bytes | None) -> Record:
    """Return the plan that a command shows.

    Raises:
        Refused: There is none; says why.
        Unreachable: That took too long.
    """
    outcome = await outcome_of(_as_json(request.look), given)
    if outcome.status:
        raise Refused(outcome.error or f"{request.look[0]} failed")
    return {
        **_joined([json.loads(line) for line in outcome.out.splitlines()]),
        "command": request.typed(request.line),
        "look": request.typed(request.look),
        "text": request.text,
        "notes": outcome.error.splitlines(),
    }


def _as_json(line: Sequence[str]) -> tuple[str, ...]:
    return (line[0], _JSON, *line[1:])


def _joined(plans: Sequence[Record]) -> Record:
    """Return plans that are carried out one after the other as one."""
    found = {key: value for key, value in plans[0].items() if key != "schema"}
    for plan in plans[1:]:
        layers = max((step["layer"] for step in found["steps"]), default=0)
        found["steps"] += [
            {**step, "number": number, "layer": step["layer"] + layers}
            for number, step in enumerate(plan["steps"], len(found["steps"]) + 1)
        ]
    return found


def routes(site: WebSite) -> list[Route]:
    """Return the requests about plans."""

    async def show(request: Request) -> Response:
        asked = request_in(await body_of(request), site.folders)
        return JSONResponse(await plan_of(asked, await asked.given()))

    async def start(request: Request) -> Response:
        site.check_change()
        body = await body_of(request)
        asked = request_in(body, site.folders)
        shown = body.get("shown")
        given = await asked.given()
        plan = await plan_of(asked, given)
        if shown is not None and shown != [each["text"] for each in plan["steps"]]:
            raise Refused("what lives has changed since this plan was shown: look again")
        request_again = {key: value for key, value in body.items() if key != "shown"}
        job = await site.jobs.start(
            KIND,
            asked.text,
            _as_json(asked.line),
            typed=asked.typed(asked.line),
            about={"plan": plan, "request": request_again},
            given=given,
            follows_stderr=True,
        )
        site.audit.add(Author(request), f"Begin: {job.text}", job.typed)
        return JSONResponse(job.record())

    return [
        Route("/api/plans/show", show, methods=["POST"]),
        Route("/api/plans/start", start, methods=["POST"]),
    ]
