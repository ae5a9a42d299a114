"""Pages of the HTTP endpoint: the panel of a service with its files, and components in a sandbox.

Nothing is run that is not a file of ours, but for the HTML that a service brings along
(``P.gui.html``, ``TYPE.html`` of the GUI service): that is answered to a frame, with a policy that
takes from it its origin and its network.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from http import HTTPStatus

from rtkit.wires.http.request import ROOT, Response

_HTML = "text/html; charset=utf-8"
_NEVER = "base-uri 'none'; form-action 'none'"
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    f"connect-src 'self'; frame-src 'self'; frame-ancestors 'none'; {_NEVER}"
)
_COMPONENT_POLICY = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; "
    f"style-src 'unsafe-inline'; img-src data: blob:; frame-ancestors 'self'; {_NEVER}"
)
COMPONENT_HEADERS = (
    ("Content-Security-Policy", _COMPONENT_POLICY),
    ("Connection-Allowlist", "()"),
    ("Permissions-Policy", "camera=(), microphone=(), geolocation=(), clipboard-write=()"),
)
"""Headers of the HTML that a service brings along: no origin, no network, in a frame only.

The policy does not hold for WebRTC and for connections that are made in advance; the list does, in
browsers that know it.
"""
_FILES = {
    "/static/frames.js": "text/javascript",
    "/static/map.js": "text/javascript",
    "/static/page.js": "text/javascript",
    "/static/panel.css": "text/css",
    "/static/values.js": "text/javascript",
    "/static/widgets.css": "text/css",
    "/static/widgets.js": "text/javascript",
}
_COMPONENT = re.compile(r"\.html(\?|$)")


def page(uri: str, headers: Mapping[str, str], services: Collection[str]) -> Response | None:
    """Return what is answered to a browser that asks for a page, or a file of one; else None."""
    if uri in _FILES:
        return _file(uri, _FILES[uri])
    is_of_service = uri in (ROOT, f"{ROOT}/") or uri.removeprefix(f"{ROOT}/") in services
    if uri == "/" or (is_of_service and "text/html" in headers.get("accept", "")):
        return _file("/static/page.html", _HTML)
    return None


def _file(uri: str, kind: str) -> Response:
    from importlib.resources import files

    return Response(HTTPStatus.OK, kind, files("rtkit.wires.http").joinpath(uri[1:]).read_bytes())


def framed(response: Response, uri: str, headers: Mapping[str, str]) -> Response:
    """Return a response as it is answered to a frame: a component as HTML, all else as it is."""
    if headers.get("sec-fetch-dest") != "iframe" or response.status != HTTPStatus.OK:
        return response
    if not _COMPONENT.search(uri):
        return response
    return response._replace(content_type=_HTML, more=(*response.more, *COMPONENT_HEADERS))
