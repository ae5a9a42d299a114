"""Samples the stacks of processes with py-spy, which the package index gives, and tidies them.

What is seen is where processor time goes: threads that wait are left out. py-spy takes some of them
for running, as it has stopped them itself; so those in calls that do nothing but wait are left out
by the name of the call. The receiving end of a socket both waits and works, and stays.
"""

from __future__ import annotations

import re
import subprocess
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from bench.flame_svg import Stack
from bench.peer_packages import programs

RATE_HZ = 100
"""Often enough for many seconds, and seldom enough that sampling itself is not what is seen."""
_WHOLE_HZ = 1000
_SKIPPED = re.compile(
    r"_run_module_as_main |_run_code |_find_and_load|_load_unlocked|_call_with_frames_removed"
    r"|_handle_fromlist|_LoaderBasics|Thread\._bootstrap|Thread\.run |thread_run |Main\.|_guarded "
    r"|_invoke |Command\.invoke|Context\.invoke|command\.<locals>|_run \(rtkit/cli"
    r"|.*in_slaves/sitecustomize\.py"
)
"""Frames that every stack has, or that are of the import of a module."""
_WAITING = re.compile(
    r"select_(epoll|poll|select)|_queue_SimpleQueue_get|lock_PyThread_acquire_lock|_R\w+|read$|os_read$"
    r"|ComponentContainer\.run · "
)
"""Innermost frames of threads that wait; code in Rust is that of zenoh, of which Python waits."""
_FRAME = re.compile(r"(?P<name>.*) \((?P<file>[^()]*?)(?::\d+)?\)")


def spy() -> str:
    """Return the path of py-spy.

    Raises:
        PeerMissing: It cannot be installed.
    """
    return str(programs("py-spy") / "py-spy")


def sampled(
    program: str, pids: Mapping[str, int], folder: str, work: Callable[[], object]
) -> Counter[Stack]:
    """Sample processes, each by its role, while work is done."""
    files = {role: Path(folder, f"{pid}.txt") for role, pid in pids.items()}
    spies = [
        subprocess.Popen(
            [program, *_words(RATE_HZ, files[role]), "--native", "--pid", str(pid)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        for role, pid in pids.items()
    ]
    for each in spies:
        assert each.stdout is not None
        each.stdout.readline()  # it says that it samples
    try:
        work()
    finally:
        for each in spies:
            each.send_signal(2)
            each.communicate()
    found = Counter[Stack]()
    for role, file in files.items():
        found += read(file.read_text(encoding="utf-8", errors="replace"), role)
    return found


def sampled_whole(program: str, words: Sequence[str], folder: str, role: str) -> Counter[Stack]:
    """Sample a process from its beginning to its end."""
    file = Path(folder, "whole.txt")
    told = subprocess.run(
        [program, *_words(_WHOLE_HZ, file), "--nonblocking", "--", *words],
        capture_output=True,
        check=False,
        text=True,
    )
    if not file.exists():
        raise RuntimeError(f"py-spy has not sampled {words[0]}: {told.stdout}{told.stderr}")
    return read(file.read_text(encoding="utf-8", errors="replace"), role)


def _words(rate_hz: int, file: Path) -> list[str]:
    return ["record", "--rate", str(rate_hz), "--format", "raw", "--output", str(file)]


def read(text: str, role: str) -> Counter[Stack]:
    """Return the stacks of lines ``FRAME;FRAME;… COUNT``, below a role.

    Where a process was not stopped, its stack may have been none: such a line is left out.
    """
    found = Counter[Stack]()
    for line in text.split("\n"):
        frames, _, count = line.rpartition(" ")
        if not count.isdecimal() or not line.isprintable():
            continue
        kept = tidied(frames.split(";"))
        if kept and not _WAITING.match(kept[-1]):
            found[f"{role}:", *kept] += int(count)
    return found


def tidied(frames: Sequence[str]) -> list[str]:
    """Return frames as ``NAME · FILE``, without those that every stack has.

    Of C code only the first frame that Python calls is left.
    """
    kept: list[str] = []
    native = ""
    for frame in frames:
        match = _FRAME.fullmatch(frame)
        name, file = (match["name"], _short(match["file"])) if match else (frame, "")
        if not file.endswith((".py", ">")):
            if not native and not name.startswith("0x"):
                native = name.removesuffix("_impl").removesuffix("_guts")
            continue
        native = ""
        if not _SKIPPED.match(frame):
            name = f"import {_module(file)}" if name == "<module>" else name
            kept.append(f"{name} · {file}")
    return [*kept, native] if native else kept


def _short(file: str) -> str:
    """Return a file, that of an absolute path by its last folder: the rest is of this machine."""
    return "/".join(file.split("/")[-2:]) if file.startswith("/") else file


def _module(file: str) -> str:
    return file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
