"""Names of properties and their suffixes: segments, escapes, parameters.

A name is segments joined by dots; all but letters, digits and ``_ - + ~`` is escaped as ``%XX``.
Two spellings of one name are the same name. Source: `property-service` reference, section 2.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

from rtkit.property.codes import PropertyError

LONGEST = 255
MOST_SEGMENTS = 32
EXTENSIONS = frozenset({"properties", "parameters", "gui", "listen", "meta", "history"})
"""Last segments that ask something about a property; no property can be named so."""

_CANONICAL = re.compile(r"[A-Za-z0-9_+~\-]+(?:\.[A-Za-z0-9_+~\-]+)*")
_SEGMENT = re.compile(r"(?:[A-Za-z0-9_+~\-]|%[0-9A-Fa-f]{2})+")
_FREE = frozenset(b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+~")
_KEY = re.compile(r"[A-Za-z_][A-Za-z0-9_\-]*")
_CODED = {f"{byte:02{case}}": bytes([byte]) for byte in range(256) for case in "xX"}
_CODED |= {code[0].upper() + code[1].lower(): byte for code, byte in list(_CODED.items())}
_CODED |= {code[0].lower() + code[1].upper(): byte for code, byte in list(_CODED.items())}
_NOT_IN_PARAMETER = re.compile(r"[&?=;#%\x00-\x20\x7f]")


class RequestTarget(NamedTuple):
    """Target of a request, read from its text.

    Attributes:
        name: In its one canonical spelling.
        parameters: Value texts by key, escapes resolved; None where no ``=`` was given.
        service: Text before the last slash.
    """

    name: str
    parameters: dict[str, str | None]
    service: str = ""


def parse_target(text: str) -> RequestTarget:
    """Read ``[service/]name[?key=value&…]``.

    Raises:
        PropertyError: ``syntax``, ``bad-parameter``, ``too-large``.
    """
    whole, mark, tail = text.partition("?")
    service, _, name = whole.rpartition("/")
    if service:
        service = "/".join(map(canonical_segment, service.split("/")))
    return RequestTarget(canonical(name), parse_parameters(tail) if mark else {}, service)


def canonical(name: str) -> str:
    """Return the one spelling of a name.

    Raises:
        PropertyError: ``syntax``, or ``too-large``.
    """
    if len(name) > LONGEST:
        raise PropertyError("too-large", f"name is longer than {LONGEST} bytes: {name[:40]}…")
    if not _CANONICAL.fullmatch(name):
        name = ".".join(map(canonical_segment, name.split(".")))
    if name.count(".") >= MOST_SEGMENTS:
        raise PropertyError("too-large", f"name has more than {MOST_SEGMENTS} parts: {name[:40]}…")
    return name


def canonical_segment(segment: str) -> str:
    """Return the one spelling of a part of a name.

    Raises:
        PropertyError: ``syntax``: an empty part, or a character that is not escaped.
    """
    if not _SEGMENT.fullmatch(segment):
        raise PropertyError("syntax", f"0 expected a name: {segment[:80]!r}")
    return segment if "%" not in segment else escape(unescape(segment))


def escape(text: str) -> str:
    """Return any text as a part of a name."""
    if text.isascii() and text.isalnum():
        return text
    raw = text.encode("utf-8", "surrogatepass")
    return "".join([chr(byte) if byte in _FREE else f"%{byte:02X}" for byte in raw])


def segment_of(text: str) -> str:
    """Return any text as a part of a name that a property may bear."""
    segment = escape(text)
    return f"{segment}_" if segment in EXTENSIONS else segment


def unescape(segment: str) -> str:
    """Return the text that a part of a name stands for.

    Raises:
        PropertyError: ``syntax``: half an escape, or the bytes are no UTF-8.
    """
    if "%" not in segment:
        return segment
    if "%20" in segment:
        # Of long texts nearly all escapes are blanks.
        segment = segment.replace("%20", " ")
        if "%" not in segment:
            return segment
    head, *rest = segment.split("%")
    parts = [head.encode("utf-8", "surrogatepass")]
    for each in rest:
        byte = _CODED.get(each[:2])
        if byte is None:
            raise PropertyError("syntax", f"0 expected two hexadecimal digits: %{each[:2]!r}")
        parts.append(byte)
        if len(each) > 2:
            parts.append(each[2:].encode("utf-8", "surrogatepass"))
    try:
        return b"".join(parts).decode("utf-8")
    except UnicodeDecodeError:
        raise PropertyError("syntax", f"0 expected escaped UTF-8: {segment[:80]!r}") from None


def parse_parameters(text: str) -> dict[str, str | None]:
    """Read what follows the question mark.

    Raises:
        PropertyError: ``bad-parameter``: no key, a key twice; ``syntax``: escaped rubbish.
    """
    parameters: dict[str, str | None] = {}
    for part in text.split("&"):
        key, mark, raw = part.partition("=")
        if not _KEY.fullmatch(key):
            raise PropertyError("bad-parameter", f"not a parameter: {part[:80]!r}")
        if key in parameters:
            raise PropertyError("bad-parameter", f"given twice: {key}")
        parameters[key] = unescape(raw) if mark else None
    return parameters


def write_parameters(parameters: Mapping[str, str | None]) -> str:
    """Return parameters as they follow the question mark."""
    return "&".join(
        [
            key if text is None else f"{key}={_NOT_IN_PARAMETER.sub(_escaped, text)}"
            for key, text in parameters.items()
        ]
    )


def with_parameter(target: str, parameter: str) -> str:
    """Return a target with one more parameter, ``key=value`` as it is written."""
    return f"{target}{'&' if '?' in target else '?'}{parameter}"


def without_parameter(target: str, key: str) -> str:
    """Return a target without one of its parameters."""
    name, _, tail = target.partition("?")
    given = tail.split("&")
    kept = [each for each in given if not each.startswith(f"{key}=")]
    if len(kept) == len(given):
        return target
    return f"{name}?{'&'.join(kept)}" if kept else name


def _escaped(found: re.Match[str]) -> str:
    return f"%{ord(found[0]):02X}"


def check_registrable(name: str) -> str:
    """Return the canonical spelling of a name that a property may bear.

    Raises:
        PropertyError: ``syntax``, ``too-large``; ``conflict``: a part of it is reserved.
    """
    name = canonical(name)
    reserved = EXTENSIONS.intersection(name.split("."))
    if reserved:
        raise PropertyError("conflict", f"{min(reserved)} is reserved: {name}")
    return name
