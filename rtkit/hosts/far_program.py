"""Runs programs on another host, whose answers are a line behind a mark."""

from __future__ import annotations

import io
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, BinaryIO

from rtkit.errors import Refused, Unreachable
from rtkit.link.places import quoted

if TYPE_CHECKING:
    from paramiko.channel import Channel

    from rtkit.hosts.connection import HostConnection

MARK = "rtkit-answer: "
"""Begins the answer of a program there: the shell of the user may write lines of its own."""
_MOST = 1 << 20
"""How much a program there may write [bytes]."""
_PIECE = 1 << 18
"""How much of a file is held to be sent [bytes]."""
_TIMES = 10
"""How many times the time for one piece all of it may take."""
_CURRENT = ".local/share/rtkit/current"
NO_PROGRAM = 127
"""Exit status of ``env`` that finds no program to run."""
LineReader = Callable[[str], object]
"""Takes a line that a program there writes before its answer."""


def python(connection: HostConnection) -> list[str]:
    """Return the words that run the Python of the rtkit of a host, with its name in the tree."""
    # A shell expands no ~ in words: what is run there begins in the user's home.
    name = f"RTKIT_HOSTNAME={connection.host.name}"
    return ["env", name, f"{_CURRENT}/bin/python", "-P"]


def no_rtkit(host: str) -> str:
    """Return the message that a host has no rtkit (any more), with the cure."""
    return f"there is no rtkit (it is brought there with: rtmgr start --host {quoted(host)})"


def ask(
    connection: HostConnection,
    command: Sequence[str],
    data: bytes | BinaryIO = b"",
    *,
    timeout_s: float,
    on_line: LineReader = len,
) -> str:
    """Run a program there; return its answer, which a mark sets apart from what the shell writes.

    What it reads is `data`; a file is sent piece by piece.

    Raises:
        Refused: There is none; the text is the end of what it writes, without the host's name.
        Unreachable: The connection ended, or nothing came for `timeout_s` [s].
    """
    name, deadline = connection.host.name, time.monotonic() + _TIMES * timeout_s
    channel = connection.open(command)
    try:
        channel.settimeout(timeout_s)
        channel.set_combine_stderr(True)
        _send(channel, io.BytesIO(data) if isinstance(data, bytes) else data)
        text, seen = b"", 0
        while (found := answer_in(text)) is None and (chunk := channel.recv(1 << 16)):
            text += chunk
            *lines, _ = text[seen:].split(b"\n")
            for line in lines:
                seen += len(line) + 1
                on_line(line.decode("utf-8", "replace").strip())
            if len(text) > _MOST or time.monotonic() > deadline:
                raise Refused(f"it writes without end: {last_lines(text[:200])}")
        if found is None:
            channel.status_event.wait(timeout_s)
            # A link that breaks ends the text, too: only a program that ended has a status.
            if channel.exit_status < 0:
                connection.ping()
            raise Refused(last_lines(text) or f"exit status {channel.exit_status}")
        return found
    except TimeoutError as error:
        raise Unreachable(f"{name}: no answer in {timeout_s:g} s") from error
    finally:
        channel.close()


def _send(channel: Channel, source: BinaryIO) -> None:
    """Send what a program reads, piece by piece, as far as it wants it.

    Raises:
        TimeoutError: It takes nothing, and does not end.
    """
    while piece := source.read(_PIECE):
        try:
            channel.sendall(piece)
        except TimeoutError:
            raise
        except OSError:
            return  # what it writes tells why it wanted no more
    with suppress(OSError):
        channel.shutdown_write()


def answer_in(text: bytes) -> str | None:
    """Return the answer behind the last mark, None while its line has not ended."""
    _, mark, answer = text.rpartition(MARK.encode())
    line, end, _ = answer.partition(b"\n")
    return line.decode("utf-8", "replace") if mark and end else None


def last_lines(text: bytes) -> str:
    """Return the end of what a program writes, on one line."""
    lines = [each for each in text.decode("utf-8", "replace").splitlines() if each.strip()]
    own = [each for each in lines if not each.startswith(("fetching ", "installing ", "waiting "))]
    return " ".join(" ".join(own[-3:]).split())[-300:]


def text_of(name: str) -> bytes:
    """Return the text of a program that runs at the far side."""
    from importlib.resources import files

    return files("rtkit.hosts").joinpath(name).read_bytes()
