"""Which managers of this user run on this host: those that hold the lock of their name."""

from __future__ import annotations

import os

from rtkit.link import places

_LOCK = ".lock"
_SOCKET = ".sock"


def managers() -> list[str]:
    """Return the names of the managers that run, in order."""
    try:
        entries = os.listdir(places.runtime_dir())
    except OSError:
        return []
    names = (entry.removesuffix(_LOCK) for entry in entries if entry.endswith(_LOCK))
    return sorted(
        name for name in names if not name.endswith(_SOCKET) and places.owner(name) is not None
    )
