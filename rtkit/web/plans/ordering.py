"""Tells what a system profile says of its components, its hosts, its variables and its orders."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rtkit.api.live_records import Record
from rtkit.api.system_profiles import load
from rtkit.errors import InvalidDocument, Malformed, Refused
from rtkit.profile.read import read_bytes, read_rts
from rtkit.profile.rts_model import DataPortConnector, ServicePortConnector, TargetPort
from rtkit.profile.words import strip_instance
from rtkit.profile_tools.ordering import NAMES, steps_in
from rtkit.web.fields import text_in, words_in
from rtkit.web.folders import granted
from rtkit.web.live.steps import Action, CommandStep
from rtkit.web.site import WebSite


def routes(site: WebSite) -> list[Route]:
    """Return the requests about what a profile says."""

    async def profile(request: Request) -> Response:
        file = granted(request.query_params.get("file", ""), site.folders)
        return JSONResponse(await asyncio.to_thread(_profile_record, file))

    return [Route("/api/plans/profile", profile)]


def _profile_record(file: str) -> Record:
    own = read_rts(read_bytes(file), file).profile
    try:
        profile = load(file).profile
    except InvalidDocument:
        profile = own  # variables have no values yet: they are given before a plan is made
    connectors: list[DataPortConnector | ServicePortConnector]
    connectors = [*profile.data_port_connectors, *profile.service_port_connectors]
    return {
        "components": [
            {
                "name": each.instance_name,
                "path": each.path_uri,
                "host": each.path_uri.partition("/")[0],
                "required": each.is_required,
                "sets": [configuration.id for configuration in each.configuration_sets],
            }
            for each in profile.components
        ],
        "connectors": [
            {
                "id": each.connector_id,
                "text": f"{_end(each.source)} → {_end(each.target)}",
                "ends": [each.source.instance_name, each.target.instance_name],
            }
            for each in connectors
        ],
        "variables": [
            {"name": each.name, "default": each.default, "description": each.description or ""}
            for each in own.variables
        ],
        "orders": {name: steps_in(own, name) for name in NAMES},
    }


def _end(end: TargetPort) -> str:
    return f"{end.instance_name}.{strip_instance(end.port_name, end.instance_name)}"


def ordered(action: Action, folders: Sequence[str]) -> CommandStep:
    """Return the step that writes an order into a profile; what takes it back is the former one.

    Raises:
        Malformed: It names no order.
        Refused: The file is in no folder that was granted, or has another order than expected.
        NotFound: There is no such file.
    """
    file, name = granted(text_in(action, "file"), folders), text_in(action, "order")
    steps = words_in(action, "steps")
    if name not in NAMES:
        raise Malformed(f"order: there is no {name!r}; there are {', '.join(NAMES)}")
    former = steps_in(read_rts(read_bytes(file), file).profile, name)
    if "expect" in action and words_in(action, "expect") != former:
        raise Refused(f"{file} has another order by now")
    line = ["rtprofile", "order", *([] if steps else ["--remove"]), "--", file, name, *steps]
    undo = {"do": "order", "file": file, "order": name, "steps": former, "expect": steps}
    return CommandStep(f"Write the order {name} into {file}", tuple(line), (undo,))
