"""Reads the bodies of requests, and answers errors: the same way in every room of the server."""

from __future__ import annotations

import json

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from rtkit.api.live_records import Record
from rtkit.errors import Denied, LimitReached, Malformed, NotFound, Refused, RtkitError
from rtkit.property.codes import CODES
from rtkit.web.guard import Refusal

_MOST_BYTES = 4 << 20


_STATUSES = {
    NotFound.kind: 404,
    Malformed.kind: 400,
    Refused.kind: 409,
    Denied.kind: 403,
    LimitReached.kind: 503,
    **{code: each.http or 502 for code, each in CODES.items()},
}


async def body_of(request: Request) -> Record:
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


def error_of(refusal: Refusal) -> JSONResponse:
    """Return the answer to a request that is refused."""
    error = {"kind": refusal.kind, "text": refusal.text}
    return JSONResponse({"error": error}, status_code=refusal.status)


def refused(_request: Request, error: RtkitError) -> Response:
    """Return the answer to a request that ended in an error of rtkit."""
    return error_of(Refusal(_STATUSES.get(error.kind, 500), error.kind, str(error)))


def not_served(request: Request, error: HTTPException) -> Response:
    """Return the answer to a request for something that is not there."""
    kind = NotFound.kind if error.status_code == 404 else Malformed.kind
    return error_of(Refusal(error.status_code, kind, f"{request.url.path}: {error.detail}"))
