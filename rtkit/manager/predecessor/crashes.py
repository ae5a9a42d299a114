"""Finds crashes that no manager saw: its own, and those of its slaves while it did not run."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import closing, suppress
from typing import NamedTuple

from rtkit.container.exit_diagnostics import ExitDiagnostics, culprits, exit_diagnostics, log_crash
from rtkit.container.heartbeats import HeartbeatReader
from rtkit.container.slave_checkpoint import SlaveCheckpoint
from rtkit.link import places, running
from rtkit.logs.logfile import FILES

_HEAD = re.compile(r"== .*, pid (\d+), [^,\n]*\n")


class UnseenCrash(NamedTuple):
    """Crash of a process that is not in its log.

    Attributes:
        slave: Name of the slave; empty for the manager.
        instances: The components whose code may have crashed.
    """

    slave: str
    pid: int
    words: ExitDiagnostics
    instances: tuple[str, ...]

    def log(self, manager: str) -> None:
        """Add it to the log of its process."""
        log_crash(manager, self.slave, self.pid, self.words, self.instances, self.words.time_s)


def unseen_crashes(manager: str, dead: Mapping[int, SlaveCheckpoint]) -> list[UnseenCrash]:
    """Return the crashes of a manager that does not run, and of its dead slaves by pid.

    Its traces must not have been removed: they tell whose code ran.
    """
    found = []
    for pid, slave, codes in _processes(manager, dead):
        words = exit_diagnostics(manager, slave, pid)
        if words.stacks and not _is_logged(places.log_file(manager, slave), pid):
            instances = culprits(words, _instance_on(manager, pid, words.thread), codes)
            found.append(UnseenCrash(slave, pid, words, instances))
    return found


def _processes(
    manager: str, dead: Mapping[int, SlaveCheckpoint]
) -> Iterator[tuple[int, str, dict[str, str]]]:
    """Yield pid, name and the code of the components of each."""
    for pid, held in dead.items():
        yield pid, held.name, {each["instance"]: each.get("code", "") for each in held.components}
    with suppress(OSError, UnicodeDecodeError):
        with open(places.output_file(manager), encoding="utf-8") as file:
            head = _HEAD.match(file.readline(1024))
        if head is not None:
            yield int(head[1]), "", {}


def _instance_on(manager: str, pid: int, thread: int) -> str:
    """Return whose code ran last on a thread of a dead process; empty when that is not known."""
    path = running.traces(manager, "beats").get(pid)
    with suppress(OSError, ValueError):
        if path is not None:
            with closing(HeartbeatReader(path)) as reader:
                return next((b.instance for b in reader.inside() if b.thread == thread), "")
    return ""


def _is_logged(path: str, pid: int) -> bool:
    marks = (b'"level": "FATAL"', b'"pid": %d,' % pid, b'"message": "Fatal Python error')
    for number in range(FILES):
        with suppress(OSError), open(f"{path}.{number}" if number else path, "rb") as file:
            if any(all(mark in line for mark in marks) for line in file):
                return True
    return False
