"""Translates HTTP requests to requests of a service, and answers to HTTP responses.

``GET /ps/SERVICE/NAME?parameters`` is a GET, ``PUT`` or ``POST`` a SET, ``/ps/SERVICE`` stands for
the names it has, ``/ps`` for the services. A revision is an entity tag.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping
from http import HTTPStatus
from typing import Any, NamedTuple

from rtkit.property.codes import CODES, PropertyError
from rtkit.property.messages import Answer, Payload, text_or_bytes
from rtkit.property.naming import canonical_segment, with_parameter
from rtkit.property.plain import from_plain, payload_to_plain
from rtkit.property.reading import read
from rtkit.property.writing import write

METHODS = ("GET", "HEAD", "PUT", "POST")
ROOT = "/ps"
EVENTS = "text/event-stream"
JSON = "application/json"
TEXT = "text/plain; charset=utf-8"
BYTES = "application/octet-stream"
_PICTURES = {b"\xff\xd8\xff": "image/jpeg", b"\x89PNG\r\n\x1a\n": "image/png"}
_TAG = re.compile(r'"(\d{1,18})"')


class HttpRequest(NamedTuple):
    """Request of a service, read from HTTP.

    Attributes:
        service: Empty where the list of services is meant.
        target: As the service knows it.
    """

    service: str
    target: str


class Response(NamedTuple):
    """HTTP response."""

    status: int
    content_type: str
    body: bytes
    more: tuple[tuple[str, str], ...] = ()


def wanted(uri: str, services: Iterable[str]) -> HttpRequest:
    """Return what the target of a request names.

    Raises:
        PropertyError: ``unknown``: nothing is there; ``no-service``; ``syntax``.
    """
    path, mark, parameters = uri.partition("?")
    if path != ROOT and not path.startswith(f"{ROOT}/"):
        raise PropertyError("unknown", f"there is {ROOT}/SERVICE/NAME, and no {path[:80]}")
    rest = path[len(ROOT) + 1 :]
    if not rest:
        return HttpRequest("", "")
    steps = [canonical_segment(each) for each in rest.split("/")[:-1]]
    last = rest.rpartition("/")[2]
    whole = "/".join([*steps, last])
    known = set(services)
    if whole in known:
        return HttpRequest(whole, f"properties{mark}{parameters}")
    service = "/".join(steps)
    if service not in known:
        raise PropertyError("no-service", f"no such service: {service or last}"[:200])
    return HttpRequest(service, f"{last}{mark}{parameters}")


def with_revision(target: str, if_match: str | None) -> str:
    """Return a SET that happens only at the revision of an entity tag.

    Raises:
        PropertyError: ``bad-parameter``: it is no such tag.
    """
    if if_match is None or if_match.strip() == "*":
        return target
    tag = _TAG.fullmatch(if_match.strip())
    if tag is None:
        raise PropertyError("bad-parameter", f'If-Match is "REVISION", not {if_match[:80]}')
    return with_parameter(target, f"if={tag[1]}")


def to_listen(target: str) -> str:
    """Return what a GET is as a request to listen."""
    name, mark, parameters = target.partition("?")
    return f"{name}.listen{mark}{parameters}"


_OF_LISTINGS = frozenset({"all", "depth", "match", "names"})


def several(target: str) -> tuple[str, str] | None:
    """Return the listing of names, and the options, where one stream is for several properties.

    ``properties?values=1&all=1&every=0.1``, as a GET of the values of several is; else None.
    """
    name, _, tail = target.partition("?")
    given = [each for each in tail.split("&") if each]
    if name.rpartition(".")[2] != "properties" or not {"values", "values=1"}.intersection(given):
        return None
    of_listing = [each for each in given if each.partition("=")[0] in _OF_LISTINGS]
    options = [each for each in given if each not in ("values", "values=1", *of_listing)]
    return f"{name}?{'&'.join(of_listing)}".rstrip("?"), "&".join(options)


def names(listed: Payload) -> list[str]:
    """Return the names of a listing."""
    value = read(str(listed))
    return [str(each) for each in value] if isinstance(value, tuple) else []


def payload_of(body: bytes, content_type: str, is_text: bool) -> Payload:
    """Return what a SET carries.

    Args:
        body: As it came.
        content_type: Of it; JSON is translated, also the object that a GET tells.
        is_text: Of the property: what it holds is no value, so a JSON text is taken as it is.

    Raises:
        PropertyError: ``syntax``, ``too-large``: it is no JSON, or no value is like it.
    """
    if content_type.partition(";")[0].strip().lower() != JSON:
        return text_or_bytes(body)
    try:
        plain = json.loads(body)
    except UnicodeDecodeError as error:
        raise PropertyError("syntax", f"{error.start} expected UTF-8") from None
    except json.JSONDecodeError as error:
        raise PropertyError("syntax", f"{error.pos} expected JSON: {error.msg}") from None
    except (RecursionError, ValueError) as error:
        raise PropertyError("too-large", f"JSON: {type(error).__name__}") from None
    if isinstance(plain, dict) and plain.keys() == _GET_KEYS:
        text, plain = plain["text"], plain["value"]
        if isinstance(text, str) and _named(payload_to_plain(text)) == plain:
            return text  # nobody has changed what a GET told, so it means what it meant there
    value = from_plain(plain)
    if isinstance(value, bytes) or (is_text and isinstance(value, str)):
        return value
    return write(value)


_GET_KEYS = {"target", "value", "text"}


def response(
    answer: Answer, uri: str, *, is_get: bool, accepts: str, revision: int | None
) -> Response:
    """Return what an answer is as a response."""
    tag = () if revision is None else (("ETag", f'"{revision}"'),)
    if answer.error:
        return failure(answer.error, str(answer.payload))
    if not is_get and not answer.payload:
        return Response(HTTPStatus.NO_CONTENT, "", b"", tag)
    payload = answer.payload
    if JSON in accepts:
        record = {"target": uri, "value": payload_to_plain(payload),
                "text": None if isinstance(payload, bytes) else payload}  # fmt: skip
        return Response(HTTPStatus.OK, JSON, _json(record), tag)
    if isinstance(payload, bytes):
        return Response(HTTPStatus.OK, kind_of_bytes(payload), payload, tag)
    return Response(HTTPStatus.OK, TEXT, payload.encode("utf-8", "surrogateescape"), tag)


def kind_of_bytes(payload: bytes) -> str:
    """Return the media type of bytes: that of a picture a browser shows, else of any bytes.

    Only what is drawn and cannot run anything is told.
    """
    return next((kind for head, kind in _PICTURES.items() if payload.startswith(head)), BYTES)


def failure(code: str, text: str, status: int = 0) -> Response:
    """Return what an error is as a response: ``code text``."""
    known = CODES.get(code)
    found = status or (known.http if known is not None else 0) or HTTPStatus.BAD_GATEWAY
    more = (("Allow", ", ".join(METHODS)),) if found == HTTPStatus.METHOD_NOT_ALLOWED else ()
    body = f"{code} {text}\n".encode("utf-8", "replace")
    return Response(int(found), TEXT, body, more)


def _json(record: Mapping[str, Any]) -> bytes:
    try:
        text = json.dumps(record, ensure_ascii=False, allow_nan=False)
    except ValueError:
        text = json.dumps(_named(record), ensure_ascii=False, allow_nan=False)
    return text.encode("utf-8", "backslashreplace") + b"\n"


def _named(value: Any) -> Any:
    """Return the same with texts for numbers that JSON does not know."""
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    if isinstance(value, Mapping):
        return {key: _named(each) for key, each in value.items()}
    return [_named(each) for each in value] if isinstance(value, list) else value
