"""Checks data transport between processes here: connects, and sends a large value."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from threading import Event, Thread

from rtkit.cli.managers.doctor import ERROR, OK, WARNING, Diagnosis
from rtkit.errors import Refused, RtkitError
from rtkit.link import places

_SIZE = 1 << 20
_MOST_S = 5.0
_SHM = "/dev/shm"
_LEAST = 64 << 20


def data_link() -> Iterator[Diagnosis]:
    """Send a large value over a connection like those between two processes."""
    found: list[Diagnosis] = []

    def run() -> None:
        try:
            runtime = places.runtime_dir()
            folder = runtime if os.path.isdir(runtime) else None
            with tempfile.TemporaryDirectory(dir=folder, prefix="doctor.") as place:
                found.append(_tried(place))
        except Refused as error:
            found.append(_broken(str(error)))
        except OSError as error:
            text = f"no connection can be tried: {error.strerror}: {error.filename}"
            found.append(Diagnosis("links", ERROR, text, "make room in the folder for sockets"))

    # Zenoh ignores Ctrl-C while it opens a session, and may hang: the thread can be abandoned.
    thread = Thread(target=run, daemon=True)
    thread.start()
    thread.join(2 * _MOST_S)
    yield from list(found) or [_broken(f"none is made within {2 * _MOST_S:g} s")]


def _tried(place: str) -> Diagnosis:
    try:
        from rtkit.link.streams import Streams
    except ImportError as error:  # the check of the installation reports it, too
        return _broken(str(error))
    arrived = Event()
    into, out = (Streams(os.path.join(place, name)) for name in ("into", "out"))
    try:
        endpoint, _ = into.receive("value", lambda value: arrived.set())
        out.send(endpoint, "value", _MOST_S, is_blocking=True).put(bytes(_SIZE))
        has_come = arrived.wait(_MOST_S)
    except RtkitError as error:
        return _broken(str(error))
    finally:
        shared = _shared_memory()
        for each in (out, into):
            each.close()
        _remove(shared)
    if not has_come:
        return _broken(f"a value of {_SIZE} bytes has not come within {_MOST_S:g} s")
    return judge(into.slow or out.slow, _free())


def judge(slow: str, free: int) -> Diagnosis:
    """Judge a connection that works.

    Args:
        slow: Why it has no shared memory, empty if it has.
        free: Free shared memory [bytes].
    """
    if slow:
        text = f"large values between processes are copied, which is slower: {slow}"
        cure = f"mount -t tmpfs -o size=512m tmpfs {_SHM} (of a container: --shm-size 512m)"
        return Diagnosis("links", WARNING, text, cure, _SHM)
    if free < _LEAST:
        text = f"only {free >> 20} MiB are free in {_SHM}: large values may have to be copied"
        cure = f"mount -o remount,size=512M {_SHM} (of a container: --shm-size 512m)"
        return Diagnosis("links", WARNING, text, cure, _SHM)
    text = f"values travel between processes; {free >> 20} MiB are free in {_SHM} for large ones"
    return Diagnosis("links", OK, text, "", _SHM)


def _free() -> int:
    """Return the amount of free shared memory [bytes]."""
    try:
        status = os.statvfs(_SHM)
    except OSError:
        return 0
    return status.f_bavail * status.f_frsize


def _broken(why: str) -> Diagnosis:
    text = f"no connection between processes can be made: {why}"
    return Diagnosis("links", ERROR, text, "rtdoctor -v tells more; look at the lines above first")


def _shared_memory() -> list[str]:
    """Return the files of shared memory of this process, all of which it made itself."""
    try:
        with open("/proc/self/maps", encoding="utf-8", errors="replace") as file:
            lines = [line.split(maxsplit=5) for line in file]
    except OSError:
        return []
    paths = {line[5].strip() for line in lines if len(line) > 5}
    return [path for path in paths if path.startswith(f"{_SHM}/") and path.endswith(".zenoh")]


def _remove(paths: list[str]) -> None:
    """Remove files that zenoh leaves of closed sessions, so that the check changes nothing."""
    for path in paths:
        try:
            os.unlink(path)
        except OSError:
            continue  # zenoh has removed it first
