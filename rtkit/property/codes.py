"""Error codes of the Property Service: the codes that travel, and the meaning of each.

Source: `property-service` reference, section 5. An error reply is ``code`` blank ``human text``.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from rtkit import errors


class ErrorCode(NamedTuple):
    """Meaning of a code: its HTTP status, and its exit detail."""

    http: int
    detail: int


CODES: dict[str, ErrorCode] = {
    "unknown": ErrorCode(404, 4),
    "no-service": ErrorCode(502, 5),
    "read-only": ErrorCode(405, 1),
    "write-only": ErrorCode(405, 1),
    "denied": ErrorCode(403, 1),
    "syntax": ErrorCode(400, 2),
    "bad-value": ErrorCode(400, 2),
    "bad-parameter": ErrorCode(400, 2),
    "conflict": ErrorCode(409, 1),
    "busy": ErrorCode(409, 1),
    "too-large": ErrorCode(413, 1),
    "timeout": ErrorCode(504, 5),
    "checksum": ErrorCode(0, 5),
    "internal": ErrorCode(500, 1),
}
"""Every code there is; the text ``checksum`` never leaves a serial line, so it has no status."""

PASSING = frozenset({"no-service", "timeout", "busy", "checksum"})
"""Codes that say nothing of what was asked for, only of the moment: asked again it may be well."""

_OF_KIND = {
    "usage": "bad-parameter",
    "malformed": "bad-value",
    "invalid": "bad-value",
    "not-found": "unknown",
    "unreachable": "no-service",
    "refused": "conflict",
    "denied": "denied",
    "partial": "conflict",
}


class PropertyError(errors.RtkitError):
    """Request that was answered with an error code.

    Attributes:
        code: One of `CODES`.
        CAME_BACK: How the text of a ``conflict`` begins where a request would wait for itself.
    """

    CAME_BACK: Final = "the request has come back to"

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code
        self.kind = code
        self.detail = CODES[code].detail if code in CODES else 1


def code_of(error: BaseException) -> str:
    """Return the code that stands for an error of whatever kind."""
    if isinstance(error, PropertyError):
        return error.code
    if isinstance(error, errors.RtkitError):
        return _OF_KIND.get(error.kind, "internal")
    return "internal"


def rebuilt(kind: str, text: str) -> errors.RtkitError:
    """Return the error that travelled as a code, or as a kind of `rtkit.errors`, and its text."""
    return PropertyError(kind, text) if kind in CODES else errors.from_kind(kind, text)
