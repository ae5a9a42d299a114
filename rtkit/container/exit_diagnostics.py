"""Diagnoses the exit of a process: the line at which it crashed, its last lines of output.

The stacks of a crash are copied to the log of the process, where `rtvlog` finds them.
"""

from __future__ import annotations

import json
import logging
import os
import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rtkit.component.current import current
from rtkit.container.stacks import place_of
from rtkit.link import places
from rtkit.logs.logfile import LogFile, Lossy
from rtkit.logs.outputs import is_of
from rtkit.logs.records import JsonLines, printable

_OUTPUT_BYTES = 256 * 1024
_LOG_BYTES = 16 * 1024
_LINES = 3
_OUTPUT_LINES = 10
_TICK_S = 0.01
"""By how much the kernel may date a file too early [s]: a crash comes after what was printed."""
_MAX_TEXT = 300
CRASH_HEAD = "Fatal Python error: "
"""Beginning of the interpreter's report of a crash, and of the record that is made of it."""
_CRASH = re.compile(f"^{CRASH_HEAD}", re.MULTILINE)
_CULPRIT = re.compile(r"^Current thread 0x([0-9a-f]+)", re.MULTILINE)
_LEVELS = ("WARN", "ERROR", "FATAL")
_PRINTED = ("stdout", "stderr")


class ExitDiagnostics(NamedTuple):
    """Diagnostics of the exit of a process.

    Attributes:
        place: ``file.py:12 in name`` of a crash; empty when there was none, or it is not known.
        text: The last lines that it printed, or that it logged as worth a warning; one line.
        thread: Identity of the thread that crashed; 0 when that is not known.
        stacks: Report of the interpreter about a crash, as it wrote it; empty when there was none.
        output: The last lines that it wrote past its log before that.
        time_s: When it wrote last past its log [s since 1970]; 0 when that is not known.
    """

    place: str = ""
    text: str = ""
    thread: int = 0
    stacks: str = ""
    output: tuple[str, ...] = ()
    time_s: float = 0.0

    def reason(self, end: str) -> str:
        """Return how it ended, ``signal 11``, with the place."""
        return f"{end} at {self.place}" if self.place else end


def exit_diagnostics(manager: str, slave: str, pid: int) -> ExitDiagnostics:
    """Return the exit diagnostics of a slave; nothing if they cannot be known."""
    path = places.output_file(manager, slave)
    output = _end(path, _OUTPUT_BYTES, keeps_head=True)
    if not is_of(output, pid):
        return ExitDiagnostics()
    crash = _CRASH.search(output)
    before, after = (output[: crash.start()], output[crash.start() :]) if crash else (output, "")
    culprit = _CULPRIT.search(after)
    thread = int(culprit[1], 16) if culprit else 0
    place = place_of(after, thread, must_be_own=True) if culprit else ""
    lines = before.splitlines()[1:]
    own = tuple(printable(line) for line in lines if line.strip())[-_OUTPUT_LINES:]
    if not own and not place:
        lines = _logged(places.log_file(manager, slave), pid)
    return ExitDiagnostics(place, _short(lines), thread, after.strip(), own, _written_s(path))


def _written_s(path: str) -> float:
    try:
        return os.stat(path).st_mtime + _TICK_S
    except OSError:
        return 0.0


def culprits(words: ExitDiagnostics, on_thread: str, codes: Mapping[str, str]) -> tuple[str, ...]:
    """Return the components whose code may have crashed; empty when that is not known.

    Args:
        words: The exit diagnostics of their process.
        on_thread: The one that was called on the thread that crashed, if any was.
        codes: For each component of the process what `ComponentFacts.code` says.
    """
    if on_thread or len(codes) == 1:
        return (on_thread or next(iter(codes)),)
    thread = f"Current thread 0x{words.thread:016x}"
    crashed = words.stacks.partition(thread)[2].partition("\n\n")[0]
    return tuple(
        instance
        for instance, code in codes.items()
        if any(f'"{line.partition(" ")[2]}"' in crashed for line in code.splitlines())
    )


def crash_text(words: ExitDiagnostics) -> tuple[str, str]:
    """Return a crash as one line, and the stacks."""
    what, _, stacks = words.stacks.partition("\n")
    return what + (f" at {words.place}" if words.place else ""), stacks.strip()


def log_crash(
    manager: str,
    slave: str,
    pid: int,
    words: ExitDiagnostics,
    instances: Sequence[str],
    time_s: float = 0.0,
) -> None:
    """Add a crash to the log of the process that it ended, under the names of components if known.

    Args:
        manager: Name of the manager.
        slave: Name of the slave, which writes no more; empty for a manager of that name before.
        pid: Of the process.
        words: Its last.
        instances: The components whose code may have crashed.
        time_s: When it crashed [s since 1970]; 0 for now.
    """
    what, stacks = crash_text(words)
    record = logging.LogRecord("rtkit", logging.CRITICAL, "", 0, what, (), None)
    record.process, record.stack_info = pid, stacks
    record.created = time_s or record.created
    target = Lossy(LogFile(places.log_file(manager, slave)), JsonLines(slave or manager))
    for instance in instances or ("",):
        before = current.set(instance)
        target.handle(record)
        current.reset(before)
    target.close()


def _short(lines: list[str]) -> str:
    parts = [" ".join(line.split()) for line in lines if line.strip()][-_LINES:]
    text = printable("; ".join(parts))
    return text if len(text) <= _MAX_TEXT else "…" + text[1 - _MAX_TEXT :]


def _logged(path: str, pid: int) -> list[str]:
    lines = []
    for line in _end(path, _LOG_BYTES).splitlines():
        try:
            record = json.loads(line)
            is_shown = record["level"] in _LEVELS or record.get("logger") in _PRINTED
            if record["pid"] == pid and is_shown:
                lines.append(str(record["message"]))
        except (ValueError, LookupError, TypeError):
            continue  # the first one is cut off
    return lines


def _end(path: str, size: int, *, keeps_head: bool = False) -> str:
    """Return the end of a file, with its first line if that is wanted."""
    try:
        with open(path, "rb") as file:
            head = file.readline(1024) if keeps_head else b""
            left = os.fstat(file.fileno()).st_size - len(head)
            file.seek(max(0, left - size), os.SEEK_CUR)
            return (head + file.read(size)).decode("utf-8", "replace")
    except OSError:
        return ""
