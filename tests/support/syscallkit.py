"""Makes the N-th system call of a kind kill its process, or fail: with strace from outside.

Nothing in rtkit knows of it. strace counts for each thread by itself, so that the N-th call of a
thread is meant; those that a traced process starts are followed.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from faultkit import Site

CALLS = {
    "fsync": "fsync,fdatasync",
    "rename": "rename,renameat,renameat2",
    "openat": "openat",
    "sendmsg": "sendmsg,sendto",
    "clone": "clone,clone3,fork,vfork",
    "execve": "execve,execveat",
}
"""What is called by one name here: which of them a library takes depends on its version."""

_LINE = re.compile(r"(?:(\d+) +)?(\w+)\(")
_KILLED = re.compile(r"(?:(\d+) +)?\+\+\+ killed by SIGKILL")


@cache
def missing() -> str:
    """Return why nothing can be tried here, empty if it can."""
    if shutil.which("strace") is None:
        return "strace is not installed"
    with subprocess.Popen(["sleep", "60"]) as sleeper:
        try:
            with _attached([sleeper.pid], ["-e", "trace=none"], Path(os.devnull)):
                return ""
        except AssertionError as error:
            return f"strace may not look into other processes here: {error}"
        finally:
            sleeper.kill()


@dataclass(frozen=True)
class Strike:
    """What is to happen at the N-th system call of a kind.

    Attributes:
        target: Whose calls: ``command`` (and all that it starts), ``manager``, ``loop`` (the one
            thread of it that deals with slaves), ``zygote`` (and the slaves that it forks),
            ``slave`` (all those that are there before).
        call: One of `CALLS`.
        action: ``signal=KILL`` or ``error=ENOSPC`` and the like.
        number: Which call of each thread, from 1.
        path: Count only those calls that name this file of the test's folder; empty for all.
    """

    target: str
    call: str
    action: str
    number: int
    path: str = ""

    def __str__(self) -> str:
        path = self.path and f" on {self.path}"
        return f"{self.action} at {self.call} {self.number}{path} of the {self.target}"

    def options(self, folder: Path) -> list[str]:
        """Return what strace is told."""
        inject = f"inject={CALLS[self.call]}:{self.action}:when={self.number}"
        only = ["-P", str(folder / self.path)] if self.path else []
        return ["-e", f"trace={CALLS[self.call]}", "-e", inject, *only]


class AtCall:
    """A breach from outside; see `faultkit.Breach`.

    Attributes:
        has_struck: Whether there was such a call, once it was carried out.
        told: What the command said then.
    """

    def __init__(self, strike: Strike) -> None:
        self._strike = strike
        self.has_struck = False
        self.told = ""

    def __str__(self) -> str:
        return str(self._strike)

    def carry_out(self, site: Site, line: str) -> tuple[Any, set[str]]:
        """Run a command with it; return its outcome, and the kinds of processes that died."""
        manager = site.manager_pid()
        zygote = zygote_of(manager) if manager else 0
        options = self._strike.options(site.shell.folder)
        outcome, log = traced(site, line, self._strike.target, options)
        self.told = outcome.err
        counts = calls_by_thread(log)
        self.has_struck = max(counts.values(), default=0) >= self._strike.number
        killed = {int(match[1] or manager) for match in map(_KILLED.match, log) if match}
        kinds = {manager: ["manager", "holder"], zygote: ["zygote"]}
        return outcome, {kind for pid in killed for kind in kinds.get(pid, ["slave"])}


def calls_by_thread(log: list[str]) -> Counter[int]:
    """Return how many calls each thread made."""
    return Counter(int(match[1] or 0) for match in map(_LINE.match, log) if match)


def traced(site: Site, line: str, target: str, options: list[str]) -> tuple[Any, list[str]]:
    """Run a command while strace looks at it, or at a daemon; return outcome and log."""
    file = site.shell.folder / "state" / "strace"
    if target == "command":
        process = site.shell.open(line, begin="import os; os.kill(os.getpid(), 19); ")
        os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WNOWAIT)
        with _attached([process.pid], ["-f", *options], file):
            os.kill(process.pid, signal.SIGCONT)
            outcome = site.shell.end_of(process, 60.0)
    else:
        manager = site.manager_pid()
        zygote = zygote_of(manager)
        pids = {"zygote": [zygote], "slave": children_of(zygote)}
        follow = ["-f"] if target != "loop" else []
        with _attached(pids.get(target, [manager]), [*follow, *options], file):
            outcome = site.shell.run(line, timeout_s=60.0)
    return outcome, file.read_text().splitlines()


@contextmanager
def _attached(pids: list[int], options: list[str], log: Path) -> Iterator[None]:
    """Have strace look at processes and what they start; where there are none, do nothing."""
    if not pids:
        log.touch()
        yield
        return
    whom = [option for pid in pids for option in ("-p", str(pid))]
    command = ["strace", "-o", str(log), *options, *whom]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as strace:
        assert strace.stderr is not None
        try:
            for _ in pids:
                line = strace.stderr.readline()
                assert " attached" in line, line
            yield
        finally:
            strace.terminate()  # lets all go
            strace.communicate()


def zygote_of(manager: int) -> int:
    """Return the process that forks the slaves of a manager, 0 if there is none."""
    for child in children_of(manager):
        try:
            command = Path(f"/proc/{child}/cmdline").read_bytes()
        except OSError:
            continue
        if b"rtkit.manager.slaves.zygote" in command:
            return child
    return 0


def children_of(pid: int) -> list[int]:
    """Return the processes that a process, or a thread of it, started."""
    tasks = Path(f"/proc/{pid}/task").iterdir()
    return [int(child) for task in tasks for child in (task / "children").read_text().split()]


def numbers_of(site: Site, line: str, target: str, call: str) -> list[int]:
    """Carry a command out in peace; return which of its calls to try.

    Of the files that it opens only those of rtkit itself, not those that Python imports.
    """
    _, log = traced(site, line, target, ["-e", f"trace={CALLS[call]}"])
    folder, numbers = str(site.shell.folder), set()
    counts: Counter[int] = Counter()
    for match in map(_LINE.match, log):
        if match:
            counts[int(match[1] or 0)] += 1
            if call != "openat" or f"{folder}/" in match.string:
                numbers.add(counts[int(match[1] or 0)])
    return sorted(numbers)
