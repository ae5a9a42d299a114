"""Checks data transport between processes here: connects, and sends a large value."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from threading import Event, Thread

from rtkit.cli.managers.doctor import ERROR, OK, Diagnosis
from rtkit.errors import Refused, RtkitError
from rtkit.link import places

_SIZE = 1 << 20
_MOST_S = 5.0


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

    # A folder for sockets may be on a file system that hangs: the thread can be abandoned.
    thread = Thread(target=run, daemon=True)
    thread.start()
    thread.join(2 * _MOST_S)
    yield from list(found) or [_broken(f"none is made within {2 * _MOST_S:g} s")]


def _tried(place: str) -> Diagnosis:
    from rtkit.link.local.streams import LocalStreams

    arrived = Event()
    reported: list[str] = []
    into, out = (LocalStreams(os.path.join(place, name)) for name in ("into", "out"))
    out.report = reported.append
    try:
        endpoint, _ = into.receive("value", lambda value: arrived.set())
        out.send(endpoint, "value", _MOST_S, is_blocking=True).put(bytes(_SIZE))
        has_come = arrived.wait(0.0 if reported else _MOST_S)
    except RtkitError as error:
        return _broken(str(error))
    finally:
        for each in (out, into):
            each.close()
    if not has_come:
        within = f"a value of {_SIZE} bytes has not come within {_MOST_S:g} s"
        return _broken(reported[0] if reported else within)
    return Diagnosis("links", OK, "values travel between processes, large ones too", "")


def _broken(why: str) -> Diagnosis:
    text = f"no connection between processes can be made: {why}"
    return Diagnosis("links", ERROR, text, "rtdoctor -v tells more; look at the lines above first")
