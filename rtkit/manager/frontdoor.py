"""Opens the front door of a manager, or tells why there is none."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from rtkit.errors import Refused, Unreachable
from rtkit.link import door, ports, secret
from rtkit.manager.settings.configuration import Door

if TYPE_CHECKING:
    import zenoh

_TRIES = 5


def open_front(
    wanted: Door, inner_endpoint: str, warn: Callable[[str], object]
) -> tuple[zenoh.Session, int] | None:
    """Open the door where it is wanted; return its session and port, None for no door.

    The usual port may be in use, which is only told: the manager can be reached all the same.

    Raises:
        Refused: A port that was asked for is in use; says by whom.
    """
    if wanted.port is None:
        return None
    secret_file = secret.make()
    for _ in range(_TRIES):
        port = wanted.port or door.free_port()
        if not door.is_free(port):
            break
        try:
            return door.open_door(port, inner_endpoint, secret_file), port
        except Unreachable:
            if door.is_free(port):
                raise  # it is not the port that is to blame
            if wanted.port:
                break
    why = f"port {port} is in use by {ports.holder(port) or 'somebody'}"
    if wanted.is_asked:
        raise Refused(f"{why}; choose another one with -p, or none with -a")
    warn(f"{why}: this manager has no TCP port; -p gives it one of its own, -a does without")
    return None
