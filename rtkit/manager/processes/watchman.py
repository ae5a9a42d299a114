"""Watches the heartbeats of slaves: names callbacks that are stuck, with the line they are at.

The line comes from the slave's own stack, which it writes at a signal, also while code holds the
interpreter lock.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import sysconfig
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from rtkit.manager.core.events import CallbackStuck
from rtkit.manager.holding.beats import Beat, BeatReader
from rtkit.rtc.create import parse_create

POLL_S = 0.025
"""How often heartbeats are read [s]."""

STACK_SIGNAL = signal.SIGUSR1
"""At which a slave writes its stack."""

_FRAME = re.compile(r'  File "(.+)", line (\d+) in (.+)')
_OURS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
_LIBRARIES = (
    f"{_OURS}{os.sep}",
    f"{sysconfig.get_path('stdlib')}{os.sep}",
    f"{sysconfig.get_path('purelib')}{os.sep}",
    "<frozen ",
)


def beats_path(pattern: str, pid: int) -> str:
    """Return where a process keeps its heartbeats; `pattern` is that of its data socket."""
    return pattern.replace("%p", str(pid)).removesuffix(".data") + ".beats"


def stack_path(pattern: str, pid: int) -> str:
    """Return where a process writes its stack."""
    return pattern.replace("%p", str(pid)).removesuffix(".data") + ".stack"


DEADLINE_KEY = "exec_cxt.callback_deadline"
DEADLINE_S = 1.0
"""How long a callback may take before it is called stuck, unless the create string says [s]."""


def callback_deadline_s(create: str) -> float:
    """Return the deadline that a create string sets, ``exec_cxt.callback_deadline`` [s]."""
    if DEADLINE_KEY not in create:
        return DEADLINE_S
    try:
        deadline = float(parse_create(create).options.get(DEADLINE_KEY, ""))
    except ValueError:
        return DEADLINE_S
    return deadline if deadline > 0 else DEADLINE_S


@dataclass(slots=True)
class _Watched:
    """A slave and what is known to be stuck in it, by instance."""

    pid: int
    reader: BeatReader
    stuck: dict[str, Beat]
    stack_from: int = -1


class Watchman:
    """Reads heartbeats of slaves and tells what is stuck, and what no longer is.

    Args:
        pattern: Of the slaves' data sockets; heartbeats and stacks lie beside them.
        deadline_s: Returns how long a callback of an instance may take [s].
        send: Sends a signal to a slave.
    """

    def __init__(
        self,
        pattern: str,
        deadline_s: Callable[[str], float],
        send: Callable[[int, signal.Signals], object],
    ) -> None:
        self._pattern = pattern
        self._deadline_s = deadline_s
        self._send = send
        self._watched: dict[int, _Watched] = {}

    @property
    def has_work(self) -> bool:
        """Whether there is a slave to watch."""
        return bool(self._watched)

    def watch(self, key: int, pid: int) -> None:
        """Begin to watch a slave; one without heartbeats is let be."""
        with contextlib.suppress(OSError):
            self._watched[key] = _Watched(pid, BeatReader(beats_path(self._pattern, pid)), {})

    def forget(self, key: int) -> None:
        """Watch a slave that ended no longer, and remove what it wrote."""
        watched = self._watched.pop(key, None)
        if watched is None:
            return
        watched.reader.close()
        for path in (
            beats_path(self._pattern, watched.pid),
            stack_path(self._pattern, watched.pid),
        ):
            with contextlib.suppress(FileNotFoundError):
                os.unlink(path)

    def poll(self) -> Iterator[CallbackStuck]:
        """Yield what got stuck since the last poll, then its line, and what goes on again."""
        now_ns = time.monotonic_ns()
        for key, watched in self._watched.items():
            yield from self._poll(key, watched, now_ns)

    def _poll(self, key: int, watched: _Watched, now_ns: int) -> Iterator[CallbackStuck]:
        if watched.stack_from >= 0:
            stacks = self._stacks(watched)
            for instance, beat in watched.stuck.items():
                yield CallbackStuck(key, instance, _text(beat, now_ns, stacks))
        late = {
            beat.instance: beat
            for beat in watched.reader.inside()
            if now_ns - beat.since_ns > self._deadline_s(beat.instance) * 1e9
        }
        for instance in [each for each in watched.stuck if each not in late]:
            del watched.stuck[instance]
            yield CallbackStuck(key, instance, "")
        fresh = [beat for name, beat in late.items() if watched.stuck.get(name) != beat]
        for beat in fresh:
            watched.stuck[beat.instance] = beat
            yield CallbackStuck(key, beat.instance, _text(beat, now_ns, ""))
        if fresh:
            self._ask_for_stack(key, watched)

    def _ask_for_stack(self, key: int, watched: _Watched) -> None:
        with contextlib.suppress(OSError):
            watched.stack_from = os.stat(stack_path(self._pattern, watched.pid)).st_size
            self._send(key, STACK_SIGNAL)

    def _stacks(self, watched: _Watched) -> str:
        start, watched.stack_from = watched.stack_from, -1
        with (
            contextlib.suppress(OSError),
            open(
                stack_path(self._pattern, watched.pid), encoding="utf-8", errors="replace"
            ) as file,
        ):
            file.seek(start)
            return file.read()
        return ""


def _text(beat: Beat, now_ns: int, stacks: str) -> str:
    began = time.localtime(time.time() - (now_ns - beat.since_ns) / 1e9)
    place = place_of(stacks, beat.thread)
    since = time.strftime("%H:%M:%S", began)
    return f"stuck in {beat.callback} since {since}" + (f" ({place})" if place else "")


def place_of(stacks: str, thread: int, *, must_be_own: bool = False) -> str:
    """Return ``file.py:12 in name`` of a thread's innermost frame that is a component's own.

    Code of libraries and of rtkit is passed over, so that the line is one its author can mend;
    where there is no other, the innermost frame is returned unless it must be a component's.
    """
    _, found, rest = stacks.partition(f"hread 0x{thread:016x}")
    if not found:
        return ""
    frames = []
    for line in rest.splitlines()[1:]:
        match = _FRAME.fullmatch(line)
        if match is None:
            break
        frames.append(match.groups())
    own = [frame for frame in frames if not frame[0].startswith(_LIBRARIES)]
    for file, number, name in own[:1] or ([] if must_be_own else frames[:1]):
        return f"{os.path.basename(file)}:{number} in {name}"
    return ""
