"""Record of what others did here: one JSON object a line, for this user alone, bounded."""

from __future__ import annotations

import json
import os
import re
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from rtkit.link import places

if TYPE_CHECKING:
    from rtkit.keys.tls import Peer

FILE = "audit.jsonl"
MOST_BYTES = 1 << 20
"""Size at which the file is set aside as ``audit.jsonl.1``, in place of the one before [bytes]."""
_LONGEST = 200
_SECRET = re.compile(r"passw|secret|token|key|credential|pin\b", re.IGNORECASE)


def file() -> str:
    """Return where the record is kept."""
    return os.path.join(places.state_dir(), FILE)


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
    places.make_private(places.state_dir())
    path = file()
    flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_CLOEXEC
    descriptor = os.open(path, flags, 0o600)
    try:
        # One write a line: those of several processes do not mix.
        os.write(descriptor, (json.dumps(line) + "\n").encode())
        if os.fstat(descriptor).st_size > MOST_BYTES:
            os.replace(path, f"{path}.1")
    finally:
        os.close(descriptor)
