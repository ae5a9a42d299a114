"""Guards the work of the manager's loop: a fault in it is logged and dumped, and ends nothing else.

Work that failed pauses, longer each time, so that a fault that stays costs no processor; its dump
lies beside the logs, where `rtmgr replay` takes it.

See decision 48.
"""

from __future__ import annotations

import logging
import os
import select
import selectors
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from threading import Lock, Thread
from typing import Any, NamedTuple

from rtkit import fault
from rtkit.link import places
from rtkit.manager.core.event_ring import EventRing, Fault, Recording
from rtkit.manager.core.state import ManagerState

_PAUSE_S, _LONGEST_PAUSE_S = 0.1, 1.0
"""How long work pauses after its first fault, and at most [s]."""
_FORGIVEN_S = 10.0
"""After so long without a fault the next one is a first one [s]."""
_DUMP_EACH_S = 60.0
"""How long after a dump of a work there is no other one of it [s]; nor is its trace logged."""
_FILES = 4
"""How many dumps of faults a manager leaves: the first three of all, and the last one."""
_LONGEST_TRACE = 4000


class _Failing(NamedTuple):
    """Work that failed: until when it pauses, for how long, and when it was dumped last."""

    until: float
    pause_s: float
    dumped: float


class FaultGuard:
    """Does the work of one loop, on its thread."""

    def __init__(self, state: ManagerState, ring: EventRing) -> None:
        self._state = state
        self._ring = ring
        self._failing: dict[str, _Failing] = {}

    @property
    def retry_at(self) -> float | None:
        """Return when paused work is to be tried again, monotonic [s]; None for no such work."""
        now = time.monotonic()
        return min(
            (each.until for each in self._failing.values() if each.until > now), default=None
        )

    def is_paused(self, work: str) -> bool:
        """Return whether work waits after a fault in it."""
        failing = self._failing.get(work)
        return failing is not None and time.monotonic() < failing.until

    def run(self, work: str, call: Callable[..., Any], *arguments: object) -> Any:
        """Do some work, named for logs and dumps; return its result, None after a fault in it."""
        try:
            return call(*arguments)
        except Exception as error:
            self.note(work, error)
            return None

    def note(self, work: str, error: BaseException) -> None:
        """Log and dump a fault, and have that work pause."""
        now = time.monotonic()
        before = self._failing.get(work, _Failing(-_FORGIVEN_S, _PAUSE_S / 2, -_DUMP_EACH_S))
        is_first = now > before.until + _FORGIVEN_S
        pause_s = _PAUSE_S if is_first else min(2 * before.pause_s, _LONGEST_PAUSE_S)
        is_dumped = now >= before.dumped + _DUMP_EACH_S
        self._failing[work] = _Failing(now + pause_s, pause_s, now if is_dumped else before.dumped)
        text = f"{type(error).__name__}: {error}"
        trace = "".join(traceback.format_exception(error))[-_LONGEST_TRACE:]
        self._ring.note(Fault(work, text, trace))
        if not is_dumped:
            _log.error("fault in %s again: %s", work, text)
            return
        _log.error("fault in %s: %s\n%s", work, text, trace)
        try:
            texts = header(self._state, f"fault in {work}: {text}")
            arguments = (self._state.name, texts, self._ring.capture())
            Thread(target=_write, args=arguments, name="dump", daemon=True).start()
        except Exception as failure:  # no thread, no memory: the loop goes on all the same
            _log.error("no dump can be made: %s", failure)


_log = logging.getLogger(__name__)
_one_at_a_time = Lock()


def header(state: ManagerState, why: str) -> dict[str, str]:
    """Return the texts at the beginning of a dump."""
    return {
        "manager": state.name,
        "host": state.host,
        "pid": str(state.pid),
        "rtkit": state.version,
        "time": time.strftime("%Y-%m-%d %H:%M:%S %z"),
        "clock": repr(time.time()),
        "monotonic": repr(time.monotonic()),
        "why": why,
    }


def _write(manager: str, texts: dict[str, str], recording: Recording) -> None:
    """Write a dump of a fault beside the logs, whole or not at all."""
    try:
        text = text_of(texts, recording)
        with _one_at_a_time:
            path = _free_path(places.dump_file(manager))
            _write_text(path, text)
        _log.error("%s; dump for rtmgr replay: %s", texts["why"], path)
    except Exception as error:  # a fault of the dump itself must not look like another one
        _log.error("the dump cannot be written: %s (%s)", error, texts["why"])


def text_of(texts: dict[str, str], recording: Recording) -> str:
    """Return the text of a dump; safe on any thread."""
    from rtkit.manager.core.dump import Dump, to_lines  # not needed until then

    return "".join(f"{line}\n" for line in to_lines(Dump(texts, recording)))


def _free_path(pattern: str) -> str:
    """Return the first name of a dump that is free; the file of the last name is replaced."""
    paths = [pattern % number for number in range(1, _FILES + 1)]
    return next((path for path in paths if not os.path.lexists(path)), paths[-1])


def _write_text(path: str, text: str) -> None:
    draft = f"{path}.new"
    with suppress(FileNotFoundError):
        os.unlink(draft)  # of one that was killed meanwhile
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
    try:
        with open(os.open(draft, flags, 0o600), "w", encoding="utf-8") as file:
            fault.point("dump.drafted")
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        fault.point("dump.written")
        os.rename(draft, path)
    except BaseException:
        with suppress(FileNotFoundError):
            os.unlink(draft)
        raise


def select_but(
    selector: selectors.BaseSelector, is_left_alone: Callable[[int], bool], wait_s: float | None
) -> list[tuple[selectors.SelectorKey, int]]:
    """Return what is ready, but for descriptors that are left alone; wait at most so long [s]."""
    ready = selector.select(wait_s)
    others = [each for each in ready if not is_left_alone(each[0].fd)]
    if ready and not others:  # the selector returns at once as long as one of them is ready
        poll = select.poll()
        for key in selector.get_map().values():
            if not is_left_alone(key.fd):
                writing = select.POLLOUT if key.events & selectors.EVENT_WRITE else 0
                poll.register(key.fd, select.POLLIN | writing)
        poll.poll(None if wait_s is None else wait_s * 1000)
    return others
