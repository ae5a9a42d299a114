"""Namespaces of the profiles, and names written with their usual prefixes."""

from __future__ import annotations

from functools import cache

_BASE = "http://www.openrtp.org/namespaces/"
XSI = "http://www.w3.org/2001/XMLSchema-instance"
XML = "http://www.w3.org/XML/1998/namespace"
RTKIT = "urn:rtkit:profile"
"""Namespace of rtkit's own elements and attributes in system profiles."""

NAMESPACES = {
    "rtc": f"{_BASE}rtc",
    "rtcDoc": f"{_BASE}rtc_doc",
    "rtcExt": f"{_BASE}rtc_ext",
    "rts": f"{_BASE}rts",
    "rtsExt": f"{_BASE}rts_ext",
    "rtkit": RTKIT,
    "xsi": XSI,
}
_PREFIXES = {uri: prefix for prefix, uri in NAMESPACES.items()} | {XML: "xml"}
XSI_TYPE = f"{{{XSI}}}type"


@cache
def clark(short_name: str) -> str:
    """Return ``{namespace}local`` for a name with a usual prefix, ``rts:id``."""
    prefix, _, local = short_name.partition(":")
    return f"{{{NAMESPACES[prefix]}}}{local}"


def split(name: str) -> tuple[str, str]:
    """Return namespace and local name of ``{namespace}local``; the namespace may be empty."""
    if name[:1] != "{":
        return "", name
    namespace, _, local = name[1:].rpartition("}")
    return namespace, local


def short(name: str) -> str:
    """Return a name as people write it: with the usual prefix where there is one."""
    namespace, local = split(name)
    prefix = _PREFIXES.get(namespace)
    return f"{prefix}:{local}" if prefix else name


def shorten(text: str) -> str:
    """Replace the namespaces inside a message by their usual prefixes."""
    for uri, prefix in _PREFIXES.items():
        text = text.replace(f"{{{uri}}}", f"{prefix}:")
    return text
