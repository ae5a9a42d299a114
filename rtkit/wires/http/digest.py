"""Digest proof of an HTTP request: its sender knows the user's secret, and does not send it.

Digest authentication of RFC 7616 with SHA-256 and ``qop=auth`` and nothing else of it: what curl,
browsers and libraries know already.
"""

from __future__ import annotations

import re
from hashlib import sha256

from rtkit.link.secret import Secret

REALM = "rtkit"
_FIELD = re.compile(
    r'\s*([a-z*]+)\s*=\s*(?:"((?:[^"\\]|\\.)*)"|([^\s,"]*))\s*(?:,|$)', re.IGNORECASE
)
_ESCAPED = re.compile(r"\\(.)")
_SPECIAL = re.compile(r'["\\]')
_LONGEST = 4096


def response(secret: Secret, method: str, uri: str, nonce: str, count: str, own: str) -> str:
    """Return the proof for one request.

    Args:
        secret: Of the user.
        method: Of the request.
        uri: As the request line has it.
        nonce: What was to be proven with.
        count: How often the nonce has been used with this, as eight hexadecimal digits.
        own: What the client chose at random.
    """
    who = _hashed(f"{secret.user}:{REALM}:{secret.password}")
    return _hashed(f"{who}:{nonce}:{count}:{own}:auth:{_hashed(f'{method}:{uri}')}")


def challenge(nonce: str, *, is_stale: bool = False) -> str:
    """Return a challenge for a proof; `is_stale` means that only the nonce was too old."""
    more = ", stale=true" if is_stale else ""
    return f'Digest realm="{REALM}", qop="auth", algorithm=SHA-256, nonce="{nonce}"{more}'


def authorization(secret: Secret, method: str, uri: str, nonce: str, times: int, own: str) -> str:
    """Return what a request carries."""
    count = f"{times:08x}"
    proof = response(secret, method, uri, nonce, count, own)
    uri = _SPECIAL.sub(r"\\\g<0>", uri)
    return (
        f'Digest username="{secret.user}", realm="{REALM}", uri="{uri}", algorithm=SHA-256, '
        f'nonce="{nonce}", nc={count}, cnonce="{own}", qop=auth, response="{proof}"'
    )


def fields(header: str) -> dict[str, str]:
    """Return the fields of a challenge or of what answers it; empty if it is none, or malformed."""
    scheme, _, rest = header.strip().partition(" ")
    if scheme.lower() != "digest" or len(rest) > _LONGEST:
        return {}
    found: dict[str, str] = {}
    at = 0
    while at < len(rest):
        match = _FIELD.match(rest, at)
        if match is None or match[1].lower() in found:
            return {}
        quoted = match[2]
        found[match[1].lower()] = match[3] if quoted is None else _ESCAPED.sub(r"\1", quoted)
        at = match.end()
    return found


def _hashed(text: str) -> str:
    return sha256(text.encode("utf-8", "surrogateescape")).hexdigest()
