"""Record of what others did here: one JSON object a line, for this user alone, bounded."""

from __future__ import annotations

import json
import os
import re
from datetime import UTC, datetime
from time import monotonic
from typing import TYPE_CHECKING, NamedTuple

from rtkit.link import places

if TYPE_CHECKING:
    from rtkit.keys.tls import Peer

FILE = "audit.jsonl"
MOST_BYTES = 1 << 20
"""Size at which the file is set aside as ``audit.jsonl.1``, in place of the one before [bytes]."""
MOST_DENIED = 20
DENIED_S = 60.0
"""Lines about what one name is denied in an interval, and how long that is [s]."""
_LONGEST = 200
_SECRET = re.compile(r"passw|secret|token|key|credential|pin\b", re.IGNORECASE)


def file() -> str:
    """Return where the record is kept."""
    return os.path.join(places.state_dir(), FILE)


class _Denials(NamedTuple):
    until: float
    lines: int = 0
    more: int = 0


_denied: dict[str, _Denials] = {}
_MOST_KNOWN = 1000


def _bounded(line: dict[str, object]) -> dict[str, object] | None:
    """Return the line of a denial, None if its owner has many: they must not wash out the others.

    The first one after an interval says how many were left out.
    """
    name, now = str(line["name"]), monotonic()
    known = _denied.get(name) or _Denials(0.0)
    if now >= known.until:
        line = {**line, "left_out": known.more} if known.more else line
        known = _Denials(now + DENIED_S)
        if len(_denied) >= _MOST_KNOWN:
            _denied.clear()
    is_one_more = known.lines >= MOST_DENIED
    _denied[name] = known._replace(lines=known.lines + 1, more=known.more + is_one_more)
    return None if is_one_more else line


def record(
    peer: Peer, address: str, wire: str, what: str, result: str, value: object = None
) -> None:
    """Add a line; the value of what is named as a secret is left out.

    Raises:
        Refused: The folder is open to others.
        OSError: It cannot be written.
    """
    line: dict[str, object] = {
        "at": datetime.now(UTC).isoformat(timespec="milliseconds"),
        "name": peer.name,
        "role": peer.role,
        "serial": f"{peer.serial:x}",
        "address": address,
        "wire": wire,
        "what": what,
        "result": result[:_LONGEST],
    }
    if value is not None and not _SECRET.search(what) and not _SECRET.search(str(value)):
        line["value"] = value[:_LONGEST] if isinstance(value, str) else f"{len(bytes(value))} bytes"  # type: ignore[call-overload]
    shown = _bounded(line) if result.startswith("denied") else line
    if shown is None:
        return
    places.make_private(places.state_dir())
    path = file()
    flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_CLOEXEC
    descriptor = os.open(path, flags, 0o600)
    try:
        # One write a line: those of several processes do not mix.
        os.write(descriptor, (json.dumps(shown) + "\n").encode())
        if os.fstat(descriptor).st_size > MOST_BYTES:
            os.replace(path, f"{path}.1")
    finally:
        os.close(descriptor)
