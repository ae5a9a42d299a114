"""Notes of what listens to other hosts without TLS: ``rtls -l`` shows them to this user.

A file ``PORT-PID.insecure`` beside the sockets holds an address; the listening process locks it, so
that the note of a process that was killed counts no more.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable

from rtkit.link import places

_SUFFIX = ".insecure"
_LONGEST = 1000


def note(address: str) -> Callable[[], object]:
    """Note that this process listens there; return the function that takes the note away.

    Raises:
        Refused: The folder of sockets is open to others.
        OSError: It cannot be written.
    """
    import fcntl
    import re

    folder = places.make_private(places.runtime_path())
    place = re.sub(r"\W+", "_", address)[-60:]
    path = os.path.join(folder, f"{place}-{os.getpid()}{_SUFFIX}")
    flags = os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW | os.O_CLOEXEC
    descriptor = os.open(path, flags, 0o600)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    os.write(descriptor, address.encode())

    def forget() -> None:
        os.unlink(path)
        os.close(descriptor)

    return forget


def noted() -> list[str]:
    """Return the addresses that are listened at; notes of the dead are removed."""
    try:
        folder = places.runtime_dir()
        entries = sorted(each for each in os.listdir(folder) if each.endswith(_SUFFIX))
    except OSError:
        return []
    return [text for each in entries if (text := _read(os.path.join(folder, each)))]


def _read(path: str) -> str:
    """Return an address, empty if nobody listens there any more."""
    import fcntl

    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return ""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return os.read(descriptor, _LONGEST).decode("utf-8", "replace")
    else:
        with contextlib.suppress(OSError):
            os.unlink(path)
        return ""
    finally:
        os.close(descriptor)
